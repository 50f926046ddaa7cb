"""Schedules against the RTL: the same microcode under Verilator, cycles and every word of storage compared.

A case is a text file (docs/pl-machine.md, "Validation cases"); `rtl/build.sh` builds a harness for one engine, and
the harness compares: every word of storage, whether the program writes it or not, and the cycles of the RTL's own counter,
which must be those that its busy signal was up. Operands come from the RTL's storage alone.
"""

from __future__ import annotations

import re
import shutil
import subprocess
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
from scipy import sparse

from orbsoc.conic.problem import Cones, Problem
from orbsoc.conic.settings import Settings
from orbsoc.hw.precision import narrow_settings
from orbsoc.hw.schedules import KKT_SOLVES, Engine, PlProgram, Stream, scheduled, with_exact_depth

from .rule_violations import Bench, control_case, silent_rules
from .same_pattern import same_pattern

Format = Literal["flat", "compressed", "in_order"]
SEQUENCERS: dict[Format, int] = {"flat": 0, "compressed": 1, "in_order": 2}
MODULES = (
    "matrix_update",
    "matrix_scaling",
    "factorization",
    "linear_solve",
    "cone_ops",
    "line_search",
)
ADDRESS_BITS = 15
_CODE_BITS = 17
"""Lines of microcode memory as a power of two, at least: most programs share a harness."""
_MOST_LEVEL = 255
_MICROCODE = re.compile(r"^microcode (\d+)$", re.MULTILINE)
_RUN = re.compile(
    r"^run (\S+) cycles (\d+) expected (\d+) different (\d+) asserted (\d+)((?:\n(?!run ).*)*)", re.MULTILINE
)
_SIGNAL = re.compile(r"^(?:counter|status) .*$", re.MULTILINE)


class RtlError(RuntimeError):
    """The RTL cannot be built or run here; says what is missing."""


@dataclass(frozen=True, slots=True)
class Point:
    """One module of one problem on one engine.

    Raises ValueError for a level at which fetch would never deliver, and for a stream that begins with another module's
    stage: its segment counts as the module's of its first stage, so that the case would be empty.
    """

    problem: str
    module: str
    engine: Engine
    format: Format = "flat"
    level: int = 0
    """Of fetch gaps, of 256; in_order only."""
    stream: Stream | None = None
    """Stages of that module and others as one segment, in place of the module's own."""
    interleaved: int = 1
    """Problems of the pattern in each segment, with numbers of their own."""

    def __post_init__(self) -> None:
        if not 0 <= self.level <= _MOST_LEVEL:
            raise ValueError(f"`level` = {self.level}: allowed is 0 to {_MOST_LEVEL}")
        if self.stream is not None and self.stream.module not in (None, self.module):
            raise ValueError(
                f"`module` = {self.module!r}: the stream begins with stage {self.stream.stages[0]!r},"
                f" which is a stage of {self.stream.module!r}; name that module"
            )

    def with_interleaved(self, copies: int) -> Point:
        """The same for as many problems, with room for the words of all."""
        if copies == 1:
            return self
        bits = (self.engine.address_bits or ADDRESS_BITS) + (copies - 1).bit_length()
        return replace(self, engine=replace(self.engine, address_bits=bits), interleaved=copies)


@dataclass(frozen=True, slots=True)
class Outcome:
    """What the RTL did with one segment of a point."""

    point: Point
    segment: str
    rtl_cycles: int
    """By the RTL's own counter."""
    model_cycles: int
    different_words: int
    assertions: int
    signals: tuple[str, ...] = ()
    """What counter, status or interrupt said that was not so, as the harness puts it."""

    @property
    def good(self) -> bool:
        """Equal cycles, equal words, no assertion, and registers and interrupt of a segment that ended."""
        equal = self.rtl_cycles == self.model_cycles and not self.different_words
        return equal and not self.assertions and not self.signals


def rtl_folder(given: Path | None) -> Path:
    """`rtl_sources`, where there is a Verilator to build them. Raises RtlError without."""
    folder = rtl_sources(given)
    if shutil.which("verilator") is None:
        raise RtlError("Verilator is not installed; on Debian or Ubuntu: apt install verilator")
    return folder


def rtl_sources(given: Path | None) -> Path:
    """The RTL's folder: `given`, or that of the source tree which this package runs from, or in which the command runs.

    Raises RtlError if there is none.
    """
    tree = Path(__file__).resolve().parents[3] / "rtl"
    places = [given] if given else [tree, Path("rtl").absolute()]
    for folder in places:
        if (folder / "build.sh").is_file():
            return folder
    raise RtlError(
        f"{places[-1]}: no RTL there; run from the top of a source tree of orbsoc, or name its rtl/ with --rtl"
    )


def built(
    folder: Path,
    engine: Engine,
    form: Format,
    *,
    lines: int,
    resident: bool = False,
    parity: bool = False,
    top: str = "engine",
) -> Path:
    """The harness for one engine with room for `lines` of microcode, from the cache of `rtl/build.sh`; `resident`: with
    the operation control that runs whole attempts; `parity`: with a bit a word and a line; `top`: engine, or engine_upsets, whose
    bits can be turned over.

    Raises RtlError with the log of the build.
    """
    parameters = {
        "FP": engine.fp, "LANES": engine.lanes, "DIVIDERS": engine.dividers, "BANKS": engine.banks, "CLUSTERS": engine.clusters,
        "ADDRESS_BITS": engine.address_bits, "SEQUENCER": SEQUENCERS[form],
        "CODE_BITS": max(_CODE_BITS, (lines - 1).bit_length()),
    }  # fmt: skip
    if engine.rows is not None:
        parameters["ROWS"] = engine.rows
    if resident:
        parameters["RESIDENT"] = 1
    if parity:
        parameters["PARITY"] = 1
    arguments = [f"-G{name}={value}" for name, value in parameters.items()]
    done = subprocess.run(
        ["sh", folder / "build.sh", top, *arguments], capture_output=True, text=True, check=False
    )
    if done.returncode != 0:
        raise RtlError(f"the RTL does not build for {engine}: {done.stderr.strip()[-2000:]}")
    return Path(done.stdout.strip())


@dataclass(frozen=True, slots=True)
class Prepared:
    """A point as the harness takes it."""

    point: Point
    case: str
    harness: Path


def case_of(point: Point, program: PlProgram, others: Sequence[Problem] = ()) -> str:
    """A point of a program, as the text that harnesses read; `others`: the problems interleaved with the program's own."""
    return program.core.case(
        point.module, point.format, seed=point.level + 1, level=point.level, others=list(others)
    )


def prepared(folder: Path, point: Point, case: str) -> Prepared:
    """A case, and the harness of its point's engine. Raises RtlError with the log of the build."""
    return Prepared(point, case, built(folder, point.engine, point.format, lines=_lines(case)))


def silent_checks(folder: Path, ready: Prepared) -> list[str]:
    """Rules that a program of `rtl_controls` breaks on this harness, without a word from the RTL's checks."""
    bench = Bench.of(ready.case, folder)
    done = _answer(ready.harness, control_case(bench))
    if _RUN.search(done.stdout) is None:
        raise _broken_off("the control", done)
    return silent_rules(bench, done.stdout)


def compared(ready: Prepared) -> list[Outcome]:
    """Run and compare one point. Raises RtlError if the harness breaks off, or exits otherwise than it says."""
    point, text, done = ready.point, ready.case, _answer(ready.harness, ready.case)
    found = [_outcome(point, match) for match in _RUN.finditer(done.stdout)]
    if not found or len(found) != text.count("\nrun "):
        raise _broken_off(point, done)
    if done.returncode != (0 if all(outcome.good for outcome in found) else 1):
        raise RtlError(
            f"{point}: the harness exits with {done.returncode}, but says: {done.stdout.strip()[-2000:]}"
        )
    return found


def run(folder: Path, point: Point, program: PlProgram) -> list[Outcome]:
    """Build, run and compare one point. Raises RtlError as `prepared` and `compared` do."""
    return compared(prepared(folder, point, case_of(point, program)))


def _answer(harness: Path, text: str) -> subprocess.CompletedProcess[str]:
    """Of a harness to a case."""
    with tempfile.TemporaryDirectory() as scratch:
        case = Path(scratch) / "point.case"
        case.write_text(text)
        return subprocess.run([harness, case], capture_output=True, text=True, check=False)


def _broken_off(what: object, done: subprocess.CompletedProcess[str]) -> RtlError:
    return RtlError(f"{what}: the harness broke off: {(done.stdout + done.stderr).strip()[-2000:]}")


def _outcome(point: Point, run: re.Match[str]) -> Outcome:
    """Of a run's lines."""
    name, cycles, expected, different, asserted, rest = run.groups()
    return Outcome(
        point,
        name,
        rtl_cycles=int(cycles),
        model_cycles=int(expected),
        different_words=int(different),
        assertions=int(asserted),
        signals=tuple(_SIGNAL.findall(rest)),
    )


def _lines(case: str) -> int:
    """Of microcode in a case."""
    match = _MICROCODE.search(case)
    if match is None:
        raise RtlError("a case without microcode")
    return int(match[1])


def problems(largest: Problem | None = None) -> dict[str, Problem]:
    """Problems of five sizes, every kind of block in them; `largest` is mission 004's subproblem, if given."""
    made = {
        "1 variable, 2 rows": _drawn(1, 0, 2, []),
        "6 variables, cones 3": _drawn(6, 2, 3, [3]),
        "12 variables, cones 4 6": _drawn(12, 4, 6, [4, 6]),
        "24 variables, cones 3 3 9": _drawn(24, 10, 12, [3, 3, 9]),
    }
    if largest is None:
        return made | {"40 variables, cones 4 4 4 4": _drawn(40, 24, 10, [4, 4, 4, 4])}
    return made | {"mission 004, N = 12": largest}


def mission_004(file: Path, *, free_perigee: bool) -> Problem:
    """The first subproblem of rec1, N = 12, as it is (problem A) or with the perigee free (problem C).

    Raises RtlError where the scenario is not at hand: another problem would be another validation.
    """
    require_scenario(file)
    from orbsoc.missions.registry import load_scenario

    free = {"problem": "max_energy", "target.perigee_direction": "free"}
    mission, scenario = load_scenario(file, free if free_perigee else None)
    return mission.plan(scenario).subproblems[0].problem


def require_scenario(file: Path) -> None:
    """Raises RtlError without mission 004's scenario."""
    if not file.is_file():
        raise RtlError(
            f"{file}: no scenario there, and mission 004's subproblem is one of those compared;"
            " scenarios/ must be beside the RTL's folder, as in a source tree of orbsoc"
        )


def _drawn(n: int, p: int, l: int, q: list[int]) -> Problem:
    """A bounded problem with a point inside its cones, from a seed of its sizes."""
    random = np.random.default_rng([n, p, l, *q])
    cones = Cones(l=l, q=q)
    m = l + sum(q)
    a = sparse.random_array((p, n), density=0.4, rng=random, data_sampler=random.standard_normal)
    g = sparse.random_array((m, n), density=0.4, rng=random, data_sampler=random.standard_normal)
    g = g + sparse.eye_array(m, n)
    x, heads = random.standard_normal(n), np.zeros(m)
    heads[[*range(l), *(l + np.cumsum([0, *q[:-1]]) if q else [])]] = 1.0
    half = sparse.eye_array(n) * 0.5
    return Problem(P=half, c=random.standard_normal(n), A=a, b=a @ x, G=g, h=g @ x + heads, cones=cones)


def quick_points(names: Sequence[str]) -> list[Point]:
    """The CI subset: every module, lane count, bank count, precision and format at least once."""
    small, middle = names[1], names[2]
    flat = [
        Point(middle if k % 2 else small, module, Engine(lanes=lanes, banks=banks, address_bits=ADDRESS_BITS))
        for k, (lanes, banks) in enumerate([(1, 4), (2, 8), (4, 16)])
        for module in MODULES
    ]
    four = Engine(lanes=4, banks=16, address_bits=ADDRESS_BITS)
    one = Engine(lanes=1, banks=4, address_bits=ADDRESS_BITS)
    single = Engine(fp=32, lanes=2, banks=8, address_bits=ADDRESS_BITS)
    return [
        *flat,
        *(Point(names[4], module, four) for module in ("factorization", "linear_solve")),
        *(Point(middle, module, single) for module in MODULES),
        *(Point(middle, module, four, "compressed") for module in MODULES),
        Point(small, "cone_ops", one, "compressed"),
        *(Point(middle, "factorization", four, "in_order", level) for level in (0, 64)),
        *(Point(middle, module, CLUSTERED) for module in MODULES),
    ]


def all_points(names: Sequence[str]) -> list[Point]:
    """V2: every module × problem × lanes 1, 2, 4 × banks 4, 8, 16, and once more with 8 lanes; then V3, four levels of
    fetch gaps, and the compressed format at 1, 2 and 4 lanes."""
    engines = [
        Engine(lanes=lanes, banks=banks, address_bits=ADDRESS_BITS)
        for lanes in (1, 2, 4)
        for banks in (4, 8, 16)
    ]
    eight = Engine(lanes=8, banks=16, address_bits=ADDRESS_BITS)
    static = [
        Point(name, module, engine) for engine in (*engines, eight) for name in names for module in MODULES
    ]
    one, two, four = engines[2::3]
    dynamic = [
        Point(name, module, four, "in_order", level)
        for level in (0, 16, 64, 128, 192)
        for name in names
        for module in MODULES
    ]
    compressed = [
        Point(name, module, engine, "compressed")
        for engine in (one, two, four)
        for name in names
        for module in MODULES
    ]
    return [*static, *dynamic, *compressed]


CLUSTERED = Engine(lanes=4, dividers=2, banks=8, clusters=2, address_bits=ADDRESS_BITS)
_MORE_ENGINES: tuple[tuple[Engine, Format], ...] = (
    (CLUSTERED, "flat"),
    (Engine(lanes=3, dividers=2, banks=8, address_bits=ADDRESS_BITS), "flat"),
    (Engine(lanes=2, dividers=4, banks=2, address_bits=ADDRESS_BITS), "compressed"),
    (Engine(fp=32, lanes=4, banks=16, clusters=4, address_bits=ADDRESS_BITS), "compressed"),
    (Engine(lanes=8, dividers=3, banks=32, clusters=8, address_bits=ADDRESS_BITS), "flat"),
    (Engine(fp=32, lanes=16, dividers=2, banks=32, clusters=8, address_bits=ADDRESS_BITS), "flat"),
)


def engine_points(names: Sequence[str]) -> list[Point]:
    """Engines that no other set has, with clusters, several dividers, few banks: every module of two problems, and
    factorization and two solves as one stream."""
    pairs = [(name, engine, form) for engine, form in _MORE_ENGINES for name in names[1:3]]
    modules = [Point(name, module, engine, form) for name, engine, form in pairs for module in MODULES]
    streams = [Point(name, "factorization", engine, form, stream=KKT_SOLVES) for name, engine, form in pairs]
    return modules + streams


def kkt_points(name: str) -> list[Point]:
    """Factorization and two solves as one stream, without and with residuals: 4 lanes, flat and compressed; 2 lanes,
    compressed; 8 lanes with 32 banks, 2 dividers."""
    two, four = (Engine(lanes=lanes, banks=16, address_bits=ADDRESS_BITS) for lanes in (2, 4))
    eight = Engine(lanes=8, banks=32, dividers=2, address_bits=ADDRESS_BITS)
    runs: list[tuple[Engine, Format]] = [
        (four, "flat"), (four, "compressed"), (two, "compressed"), (eight, "flat"),
    ]  # fmt: skip
    return [
        Point(name, "factorization", engine, form, stream=stream)
        for engine, form in runs
        for stream in (KKT_SOLVES, Stream(KKT_SOLVES.stages))
    ]


def validate(
    folder: Path,
    points: Sequence[Point],
    named: dict[str, Problem],
    watched: set[Path],
    *,
    exact_depth: bool = False,
) -> Iterator[list[Outcome]]:
    """Run the points one by one; programs are scheduled once for all modules, with `exact_depth` for banks of no more rows than
    their schedules need.

    Every harness first runs a program that breaks the rules, and is put into `watched`. Raises RtlError if its checks do
    not assert each of them.
    """
    programs: dict[tuple[str, Engine, Stream | None, int], PlProgram] = {}
    for point in points:
        key = (point.problem, point.engine, point.stream, point.interleaved)
        own, *others = same_pattern(named[point.problem], point.interleaved)
        if key not in programs:
            bits = 53 if point.engine.fp == 64 else 24
            settings = narrow_settings(Settings(), bits)
            made = scheduled(own, settings, point.engine, point.stream, copies=point.interleaved)
            if exact_depth:
                exact = with_exact_depth(made)
                made = scheduled(own, settings, exact, point.stream, copies=point.interleaved)
            programs[key] = made
        point = replace(point, engine=programs[key].engine)  # its rows are known now
        ready = prepared(folder, point, case_of(point, programs[key], others))
        if ready.harness not in watched:
            if silent := silent_checks(folder, ready):
                raise RtlError(f"{point}: broken by a control, and not asserted: {', '.join(silent)}")
            watched.add(ready.harness)
        yield compared(ready)


def summary(outcomes: Sequence[Outcome]) -> dict[str, Any]:
    """Counts and errors over all outcomes, by format."""
    return {
        form: _of_format([outcome for outcome in outcomes if outcome.point.format == form])
        for form in SEQUENCERS
        if any(outcome.point.format == form for outcome in outcomes)
    }


def _of_format(outcomes: Sequence[Outcome]) -> dict[str, Any]:
    errors = [abs(o.model_cycles - o.rtl_cycles) / max(o.rtl_cycles, 1) for o in outcomes]
    return {
        "points": len({outcome.point for outcome in outcomes}),
        "segments": len(outcomes),
        "rtl_cycles": sum(outcome.rtl_cycles for outcome in outcomes),
        "largest_cycle_error": max(errors),
        "mean_cycle_error": float(np.mean(errors)),
        "different_words": sum(outcome.different_words for outcome in outcomes),
        "assertions": sum(outcome.assertions for outcome in outcomes),
        "signals": sum(len(outcome.signals) for outcome in outcomes),
    }
