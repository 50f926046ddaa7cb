"""A problem's pattern as a folder of C99: tables, the fixed library, a self-test, bounds, and how to build it."""

from __future__ import annotations

import shutil
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from orbsoc import _core
from orbsoc.conic.problem import Problem
from orbsoc.conic.settings import Settings
from orbsoc.ps.registers import WORD_MASK

from .bounds import bounds_page, ram_bytes
from .c_source import pattern_header, pattern_source
from .instructions import SETS, bounds_of, counted, varied
from .mission import OnBoard, mission_bounds, mission_texts
from .partitioned import FlightError, partition_texts
from .selftest import Recorded, record, selftest_source
from .tables import Tables, tables_of

if TYPE_CHECKING:
    from hw_model.platform.partition import Partition
    from orbsoc.hw.schedules import Engine
    from orbsoc.rtl.validation import Format

PRECISIONS = (64, 32)
MISSION_PRECISION = 64
"""Tolerances of a mission's sequence are below the resolution of binary32."""


def export_c(
    problem: Problem,
    folder: str | Path,
    *,
    settings: Settings | None = None,
    fp: int = 64,
    partition: Partition | str | None = None,
    engine: Engine | None = None,
    form: Format = "flat",
    limit_clocks: int | None = None,
    instructions: bool = False,
    mission: OnBoard | None = None,
) -> tuple[Path, ...]:
    """Write the program for a problem's pattern into `folder`, which must not exist; the files written.

    `fp` is the arithmetic of the iteration, 64 or 32; without `settings` they are the defaults of that precision. The
    self-test holds this problem's own data and the bits of `Engine::exact`'s solutions, cold and warm. With a `partition`
    (one of hw_model's, or its name) the folder has the program of its modules for an `engine` on the PL, whose
    precision is `fp`, in microcode of a `form`, and the driver that launches them; the PL stops a launch that is busy for more than
    `limit_clocks`, 1 to 2³² − 1, by default the most that the settings can take. With `instructions` BOUNDS.md has the
    instructions of each stage as well, counted under QEMU on data near the problem's, which takes seconds. With a
    `mission` whose subproblem this is the folder has its outer loop, tables and self-test, in binary64 alone.
    Raises FlightError on a folder that exists, a precision that is none, a pattern beyond 32-bit indices, a partition
    that has no program in C, an engine that cannot hold the pattern, a limit that is none or has nothing on the PL to stop, or tools
    for counting that are missing.
    """
    place = Path(folder)
    check_place(place)
    if fp not in PRECISIONS:
        raise FlightError(f"fp = {fp!r}: allowed is 64 or 32")
    if mission is not None and fp != MISSION_PRECISION:
        raise FlightError(f"fp = {fp}: a whole mission is exported in {MISSION_PRECISION} alone")
    used = settings if settings is not None else default_settings(fp)
    if used.max_time_s != float("inf"):
        used = replace(used, max_time_s=float("inf"))  # the caller's `ask` watches the clock on board
    try:
        tables = tables_of(problem, used)
    except _core.CoreError as error:
        raise FlightError(f"the pattern cannot be exported: {error}") from error
    beside = _on_pl(problem, used, fp, partition, engine, form, limit_clocks)
    texts = _texts(problem, used, fp, tables, record(problem, used, fp), with_pl=bool(beside))
    texts["BOUNDS.md"] = bounds_page(
        problem, used, tables, fp, _counted(problem, used, fp) if instructions else None
    )
    if mission is not None:
        texts |= mission_texts(mission)
        texts["BOUNDS.md"] += mission_bounds(mission, ram_bytes(tables, fp))
        texts["README.md"] += _WHOLE_MISSION.format(flags=_flags(tables, fp))
        texts["CMakeLists.txt"] += _CMAKE_MISSION
    return _write(place, texts | beside)


def _counted(problem: Problem, settings: Settings, fp: int) -> dict[str, int]:
    with tempfile.TemporaryDirectory() as folder:
        return bounds_of(counted(Path(folder), varied(problem, SETS), settings, fp, "stages"))


def _on_pl(
    problem: Problem,
    settings: Settings,
    fp: int,
    partition: Partition | str | None,
    engine: Engine | None,
    form: Format,
    limit_clocks: int | None,
) -> dict[str, str]:
    """The files of a partition with modules on the PL; none without."""
    from hw_model import HwModelError, load_partition
    from orbsoc.hw.schedules import Engine

    if limit_clocks is not None and not 1 <= limit_clocks <= WORD_MASK:
        raise FlightError(f"limit_clocks = {limit_clocks}: allowed is a whole number from 1 to {WORD_MASK}")
    try:
        split = load_partition(partition) if isinstance(partition, str) else partition
        if split is None or not split.uses_pl:
            if limit_clocks is not None:
                raise FlightError(
                    f"limit_clocks = {limit_clocks}: the partition has nothing on the PL to stop; leave it out"
                )
            return {}
        chosen = replace(engine or Engine(), fp=64 if fp == 64 else 32)
        return partition_texts(problem, settings, split, chosen, form, limit_clocks)
    except HwModelError as error:
        raise FlightError(str(error)) from error


def default_settings(fp: int) -> Settings:
    """The settings without any given: in binary32, where 1e-8 is below the resolution, looser ones."""
    if fp == 64:
        return Settings()
    return Settings(
        tol=1e-4,
        tol_inaccurate=1e-2,
        static_regularization=2e-5,
        pivot_floor=1e-7,
        dynamic_regularization=1e-4,
        refinement_tol=1e-6,
    )


def check_place(folder: Path) -> None:
    """Raise FlightError where a folder exists already."""
    if folder.exists() or folder.is_symlink():
        raise FlightError(f"--out = {folder}: exists already; give a new path")


def _texts(
    problem: Problem,
    settings: Settings,
    fp: int,
    tables: Tables,
    recorded: list[Recorded],
    *,
    with_pl: bool,
) -> dict[str, str]:
    own = {
        "pattern.h": pattern_header(tables, fp),
        "pattern.c": pattern_source(tables, settings),
        "selftest.c": selftest_source(problem, recorded),
        "CMakeLists.txt": _cmake(tables, fp),
        "README.md": _readme(tables, fp, with_pl=with_pl),
    }
    return own | {f"flight/{name}": text for name, text in _core.flight_sources().items()}


def _write(place: Path, texts: dict[str, str]) -> tuple[Path, ...]:
    """All files or none: beside their place first."""
    place = place.absolute()
    place.parent.mkdir(parents=True, exist_ok=True)
    temporary = Path(tempfile.mkdtemp(prefix=f".{place.name}.", dir=place.parent))
    try:
        for name, text in texts.items():
            (temporary / name).parent.mkdir(parents=True, exist_ok=True)
            (temporary / name).write_text(text, encoding="utf-8")
        temporary.chmod(0o755)
        temporary.rename(place)
    finally:
        shutil.rmtree(temporary, ignore_errors=True)
    return tuple(place / name for name in texts)


def _flags(tables: Tables, fp: int) -> str:
    return f"-std=c99 -O2 -ffp-contract=off -DORBSOC_FP={fp} -DORBSOC_INDEX_BITS={tables.index_bits}"


def _cmake(tables: Tables, fp: int) -> str:
    return f"""cmake_minimum_required(VERSION 3.13)
project(orbsoc_flight C)
set(CMAKE_C_STANDARD 99)
set(CMAKE_C_EXTENSIONS OFF)
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release)
endif()
file(GLOB LIBRARY ${{CMAKE_CURRENT_SOURCE_DIR}}/flight/*.c)
add_library(orbsoc_flight STATIC ${{LIBRARY}} pattern.c)
target_include_directories(orbsoc_flight PUBLIC flight ${{CMAKE_CURRENT_SOURCE_DIR}})
target_compile_definitions(orbsoc_flight PUBLIC ORBSOC_FP={fp} ORBSOC_INDEX_BITS={tables.index_bits})
# No operation may be fused or reordered: bits are part of the contract.
target_compile_options(orbsoc_flight PUBLIC -ffp-contract=off)
target_link_libraries(orbsoc_flight PUBLIC m)
add_executable(selftest selftest.c)
target_link_libraries(selftest PRIVATE orbsoc_flight)
"""


def _readme(tables: Tables, fp: int, *, with_pl: bool) -> str:
    return f"""# A solver in C99 for one pattern

Build and run the self-test, which compares the bits of recorded solves:

    cc {_flags(tables, fp)} -Iflight -I. flight/*.c pattern.c selftest.c -lm -o selftest && ./selftest

Use it:

    static orbsoc_arena arena;
    static orbsoc_solver solver;
    orbsoc_open(&solver, &orbsoc_tables, &orbsoc_defaults, arena.work, ORBSOC_WORK_WORDS,
                arena.numbers, ORBSOC_NUMBER_WORDS);
    orbsoc_set_p(&solver, p);  /* upper triangle of P, by columns; not needed where it has no entries */
    orbsoc_set_a(&solver, a);  /* entries of A, by columns */
    orbsoc_set_g(&solver, g);
    orbsoc_set_c(&solver, c);
    orbsoc_set_b(&solver, b);
    orbsoc_set_h(&solver, h);
    orbsoc_solve(&solver);     /* the outcome is solver.solution */

Every call returns ORBSOC_OK or what it refused. Memory and operations are in BOUNDS.md.
""" + (_WITH_PL.format(flags=_flags(tables, fp)) if with_pl else "")


_WITH_PL = """
Some modules run on the PL, by `driver/` and `pl_program.c`. With the addresses of its two ports the self-test uses it, too:

    cc {flags} -Iflight -Idriver -I. -DORBSOC_PL_REGISTERS=0xA0000000u -DORBSOC_PL_MEMORIES=0xB0000000u \\
      flight/*.c driver/*.c pattern.c pl_program.c selftest.c -lm -o selftest

In a program, once after orbsoc_open:

    static orbsoc_pl_device device;
    orbsoc_pl_attach(&solver, &device, &orbsoc_pl_program, 0xA0000000u, 0xB0000000u);

Every solve then launches them there. After an error, a timeout or an answer that the certificate refuses it tries once more
with the program loaded afresh, and then solves on the core alone; solver.solution.place and .event say which.
Call orbsoc_pl_on_bus_error(&device.pl) in the handler of an abort that an access to the PL raised, and go on behind it.
"""

_WHOLE_MISSION = """
The whole mission, from a state to an attitude programme. Its self-test compares plans that the host made:

    cc {flags} -Iflight -I. flight/*.c flight/missions/*.c pattern.c mission.c mission_selftest.c \\
      -lm -o mission_selftest && ./mission_selftest

Use it, once the solver is open on `arena.solver` of a static orbsoc_mission_arena:

    static orbsoc_planner planner;
    orbsoc_insertion_open(&planner, &orbsoc_mission, &solver, arena.plan, ORBSOC_PLAN_WORDS);
    orbsoc_insertion_plan(&planner, position_m, velocity_m_s);  /* the outcome is planner.plan */
    orbsoc_insertion_direction(&planner, elapsed_s, direction);

Fly on `plan.objections == 0` only: the sequence converged, and a flight of the programme ends on the target orbit.
"""

_CMAKE_MISSION = """file(GLOB MISSION ${CMAKE_CURRENT_SOURCE_DIR}/flight/missions/*.c)
add_library(orbsoc_mission STATIC ${MISSION} mission.c)
target_link_libraries(orbsoc_mission PUBLIC orbsoc_flight)
add_executable(mission_selftest mission_selftest.c)
target_link_libraries(mission_selftest PRIVATE orbsoc_mission)
"""
