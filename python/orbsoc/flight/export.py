"""A problem's pattern as a folder of C99: tables, the fixed library, a self-test, bounds, and how to build it."""

from __future__ import annotations

import shutil
import tempfile
from dataclasses import replace
from pathlib import Path

from orbsoc import _core
from orbsoc.conic.problem import Problem
from orbsoc.conic.settings import Settings

from .bounds import bounds_page
from .c_source import pattern_header, pattern_source
from .selftest import Recorded, record, selftest_source
from .tables import Tables, tables_of

PRECISIONS = (64, 32)


class FlightError(ValueError):
    """What cannot be exported, or where."""


def export_c(
    problem: Problem, folder: str | Path, *, settings: Settings | None = None, fp: int = 64
) -> tuple[Path, ...]:
    """Write the program for a problem's pattern into `folder`, which must not exist; the files written.

    `fp` is the arithmetic of the iteration, 64 or 32; without `settings` they are the defaults of that precision. The
    self-test holds this problem's own data and the bits of `Engine::exact`'s solutions, cold and warm.
    Raises FlightError on a folder that exists, a precision that is none, or a pattern beyond 32-bit indices.
    """
    place = Path(folder)
    check_place(place)
    if fp not in PRECISIONS:
        raise FlightError(f"fp = {fp!r}: allowed is 64 or 32")
    used = settings if settings is not None else default_settings(fp)
    if used.max_time_s != float("inf"):
        used = replace(used, max_time_s=float("inf"))  # the caller's `ask` watches the clock on board
    try:
        tables = tables_of(problem, used)
    except _core.CoreError as error:
        raise FlightError(f"the pattern cannot be exported: {error}") from error
    texts = _texts(problem, used, fp, tables, record(problem, used, fp))
    return _write(place, texts)


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
    problem: Problem, settings: Settings, fp: int, tables: Tables, recorded: list[Recorded]
) -> dict[str, str]:
    own = {
        "pattern.h": pattern_header(tables, fp),
        "pattern.c": pattern_source(tables, settings),
        "selftest.c": selftest_source(problem, recorded),
        "CMakeLists.txt": _cmake(tables, fp),
        "README.md": _readme(tables, fp),
        "BOUNDS.md": bounds_page(problem, settings, tables, fp),
    }
    return own | {f"flight/{name}": text for name, text in _core.flight_sources().items()}


def _write(place: Path, texts: dict[str, str]) -> tuple[Path, ...]:
    """All files or none: beside their place first."""
    place = place.absolute()
    place.parent.mkdir(parents=True, exist_ok=True)
    temporary = Path(tempfile.mkdtemp(prefix=f".{place.name}.", dir=place.parent))
    try:
        (temporary / "flight").mkdir()
        for name, text in texts.items():
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


def _readme(tables: Tables, fp: int) -> str:
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
"""
