"""Instructions of each stage on aarch64, counted under QEMU; and what bounds a whole solve.

A stage's instructions depend on the pattern, but for a few branches around selections and copies. `count_stages.c` takes
the longer way where a state can be made that does; of the rest the bound is what many data sets showed, and a little more.
"""

from __future__ import annotations

import shutil
import subprocess
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from orbsoc import _core
from orbsoc.conic.problem import Problem
from orbsoc.conic.settings import Settings

from .c_source import pattern_header, pattern_source
from .mission import OnBoard, mission_texts
from .partitioned import FlightError
from .selftest import given_data
from .tables import Tables, tables_of

COMPILER, EMULATOR = "aarch64-linux-gnu-gcc", "qemu-aarch64"
OPTIONS = ("-std=c99", "-O2", "-ffp-contract=off", "-static")
SETS = 12
"""Data sets that bounds are taken from."""
MARGIN = 0.005
"""Of a stage's instructions, added to the most that was seen."""
WORST_ITERATIONS = 5
"""Of the one attempt that `count_stages.c` makes in full."""
EACH_RUN = 40
"""More instructions than the loop over a list takes for one stage."""
_AFTER = 1000
_OUTER = 108
_NAMES = {
    100: "begin",
    101: "conclude",
    102: "restart",
    103: "load_point",
    104: "solve",
    105: "solve_from",
    106: "nothing",
    107: "worst",
}
Step = tuple[str, ...]
Work = tuple[int, int, int]
"""Instructions, and among them divisions and roots of doubles."""


@dataclass(frozen=True, slots=True)
class Counted:
    """Instructions of every run between two marks, by name; and of each solve iterations, refinement steps, attempts."""

    runs: dict[str, list[int]]
    outcomes: list[tuple[int, int, int]]


def varied(problem: Problem, sets: int, seed: int = 0, share: float = 0.04) -> list[Problem]:
    """The problem, and others of its pattern with each number of c, b and h moved by up to a share."""
    random = np.random.default_rng(seed)

    def moved(values: np.ndarray) -> np.ndarray:
        finite = np.where(np.isfinite(values), values, 0.0)
        return np.where(
            np.isfinite(values), finite * (1 + share * random.uniform(-1, 1, values.size)), values
        )

    def other() -> Problem:
        c, b, h = (moved(np.asarray(v)) for v in (problem.c, problem.b, problem.h))
        return Problem(P=problem.P, c=c, A=problem.A, b=b, G=problem.G, h=h, cones=problem.cones)

    return [problem, *(other() for _ in range(sets - 1))]


@dataclass(frozen=True, slots=True)
class Tools:
    """A compiler with its options, and what runs the program."""

    compiler: str = COMPILER
    emulator: str = EMULATOR
    options: tuple[str, ...] = OPTIONS


def counted(
    folder: Path,
    problems: Sequence[Problem],
    settings: Settings,
    fp: int,
    mode: str,
    tools: Tools | None = None,
) -> Counted:
    """Count the `stages`, the `spared` ones, the `solves` or the `worst` attempt of data sets of one pattern; `folder` is for what
    is made on the way.

    Raises FlightError where a tool is missing.
    """
    with (folder / "data").open("wb") as file:
        for problem in problems:
            given = given_data(problem)
            for name in "pagcbh":
                file.write(given[name].tobytes())
    tables = tables_of(problems[0], settings)
    texts = _library(tables, settings, fp)
    marks, told = _executed(folder, texts, tables.index_bits, fp, "count_stages.c", (mode,), tools or Tools())
    outcomes = [tuple(map(int, line.split()[:3])) for line in told]
    return Counted(_between(marks), outcomes)  # type: ignore[arg-type]


def outer_loop_counts(folder: Path, mission: OnBoard, tools: Tools | None = None) -> list[list[Work]]:
    """Of each recorded plan of a mission, what ran before its first solve, between two, and after the last.

    Raises FlightError where a tool is missing, or the program does not make the recorded plans.
    """
    tools = tools or Tools()
    with (folder / "data").open("wb") as file:
        for plan in mission.plans:
            file.write(np.ascontiguousarray(plan.start_si, "<f8").tobytes())
    settings = Settings(max_time_s=float("inf"))
    tables = tables_of(mission.problem, settings)
    program = {name: text for name, text in mission_texts(mission).items() if "selftest" not in name}
    texts = _library(tables, settings, 64) | {
        name.removeprefix("flight/"): text for name, text in program.items()
    }
    wrapped = replace(tools, options=(*tools.options, "-Wl,--wrap=orbsoc_solve"))
    marks, told = _executed(folder, texts, tables.index_bits, 64, "count_mission.c", (), wrapped)
    if told != [f"{plan.subproblems} 0 0" for plan in mission.plans]:
        raise FlightError(f"the mission in C does not make the recorded plans: {told}")
    gaps = iter(_gaps(marks))
    return [[next(gaps) for _ in range(plan.subproblems + 1)] for plan in mission.plans]


def _library(tables: Tables, settings: Settings, fp: int) -> dict[str, str]:
    own = {"pattern.h": pattern_header(tables, fp), "pattern.c": pattern_source(tables, settings)}
    return own | _core.flight_sources()


def _executed(
    folder: Path,
    texts: Mapping[str, str],
    index_bits: int,
    fp: int,
    main: str,
    arguments: Sequence[str],
    tools: Tools,
) -> tuple[list[str], list[str]]:
    """Compile sources with a main program, run it on the folder's `data`: the lines of its marks, and what it printed."""
    require_tools(tools)
    for name, text in texts.items():
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_text(text, encoding="utf-8")
    here = Path(__file__).parent
    program, plugin, marks = folder / "program", folder / "count.so", folder / "marks"
    macros = [f"-DORBSOC_FP={fp}", f"-DORBSOC_INDEX_BITS={index_bits}", f"-I{folder}"]
    written = sorted(folder / name for name in texts if name.endswith(".c"))
    sources = [str(path) for path in (*written, here / main)]
    _run([tools.compiler, *tools.options, *macros, *sources, "-lm", "-o", str(program)])
    _run(["gcc", "-shared", "-fPIC", "-O2", str(here / "count_instructions.c"), "-o", str(plugin)])
    command = [
        tools.emulator,
        "-plugin",
        f"{plugin},out={marks}",
        str(program),
        *arguments,
        str(folder / "data"),
    ]
    told = _run(command)
    return marks.read_text().splitlines(), told.splitlines()


def require_tools(tools: Tools | None = None) -> None:
    """Raise FlightError that names what is missing."""
    tools = tools or Tools()
    missing = [tool for tool in (tools.compiler, "gcc", tools.emulator) if shutil.which(tool) is None]
    if missing:
        raise FlightError(f"instructions cannot be counted here: no {', '.join(missing)}")


def _run(command: list[str]) -> str:
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise FlightError(f"{Path(command[0]).name}: {done.stderr.strip()[-500:]}")
    return done.stdout


def _between(lines: Iterable[str]) -> dict[str, list[int]]:
    """Instructions from each mark to the one after it, without those of a mark."""
    names = dict(enumerate(_core.stages())) | _NAMES
    found: dict[str, list[int]] = defaultdict(list)
    begun = (0, 0)
    for line in lines:
        kind, number, executed = line.split()[:3]
        if kind != "mark":
            continue
        if int(number) == _AFTER:
            found[names[begun[0]]].append(int(executed) - begun[1])
        else:
            begun = int(number), int(executed)
    marks = min(found.pop("nothing", [0]))
    return {name: [run - marks for run in runs] for name, runs in found.items()}


def _gaps(lines: Iterable[str]) -> Iterator[Work]:
    """What ran from each mark of the outer loop to the one after it."""
    begun = (0, 0, 0)
    for line in lines:
        kind, number, *executed = line.split()
        if kind != "mark":
            continue
        if int(number) == _AFTER:
            yield _less(executed, begun)
        elif int(number) == _OUTER:
            begun = _less(executed, (0, 0, 0))


def _less(executed: Sequence[str], begun: Work) -> Work:
    instructions, divisions, roots = (int(now) - then for now, then in zip(executed, begun, strict=True))
    return instructions, divisions, roots


def bounds_of(found: Counted) -> dict[str, int]:
    """Of each stage, and of what stands around the lists; 0 for what this pattern does not have."""
    bounds = dict.fromkeys((*_core.stages(), "begin", "conclude", "restart", "load_point"), 0)
    for name, runs in found.runs.items():
        bounds[name] = max(runs) + int(MARGIN * max(runs)) + 1
    return bounds


def list_instructions(steps: Iterable[Step], of: Mapping[str, int], refinements: int) -> int:
    """Of a list of steps with this many refinement steps in each repeated one."""
    total = 0
    for step in steps:
        if len(step) == 1:
            total += of[step[0]] + EACH_RUN
        else:
            stage, until = step
            total += of[until] + EACH_RUN + refinements * (of[stage] + of[until] + 2 * EACH_RUN)
    return total


def solve_instructions(of: Mapping[str, int], settings: Settings, attempts: int, *, warm: bool) -> int:
    """Of a whole solve that uses every iteration, refinement step and attempt that is allowed."""
    most = settings.refinement_max
    cold = list_instructions(_core.startup(), of, most)
    first = of["load_point"] + list_instructions(_core.warm_startup(), of, most) if warm else cold
    each = settings.max_iterations * list_instructions(_core.iteration(), of, most)
    last = (
        of["statistics"]
        + EACH_RUN
        + list_instructions(_core.closing(), of, most)
        + of["conclude"]
        + of["restart"]
    )
    return of["begin"] + first + (attempts - 1) * cold + attempts * (each + last)


def used_instructions(of: Mapping[str, int], outcome: tuple[int, int, int], *, warm: bool) -> int:
    """The same of a solve of one attempt with these iterations and refinement steps, the dearer kind each."""
    iterations, refinements, _ = outcome
    refinement = (
        max(of["refine_pair"] + of["check_pair"], of["refine_kkt"] + of["check_solve"]) + 2 * EACH_RUN
    )
    first = list_instructions(_core.warm_startup() if warm else _core.startup(), of, 0)
    first += of["load_point"] if warm else 0
    last = (
        of["statistics"]
        + EACH_RUN
        + list_instructions(_core.closing(), of, 0)
        + of["conclude"]
        + of["restart"]
    )
    each = list_instructions(_core.iteration(), of, 0)
    return of["begin"] + first + iterations * each + refinements * refinement + last
