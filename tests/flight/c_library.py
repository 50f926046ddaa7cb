"""The library compiled for this machine with one problem's tables, called from Python."""

from __future__ import annotations

import atexit
import ctypes
import os
import shutil
import subprocess
import tempfile
from functools import cache
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from orbsoc import _core
from orbsoc.conic.problem import Problem
from orbsoc.conic.settings import Settings
from orbsoc.flight.c_source import pattern_header, pattern_source
from orbsoc.flight.selftest import STATUSES, given_data
from orbsoc.flight.tables import Tables, tables_of

ROOT = Path(__file__).resolve().parents[2]
FLIGHT = ROOT / "flight"
STRICT = (
    "-std=c99",
    "-Wall",
    "-Wextra",
    "-Wconversion",
    "-Wshadow",
    "-pedantic",
    "-Werror",
    "-ffp-contract=off",
)
NUMBERS = 11
"""Numbers before x in `harness_numbers`."""
_NUMBER = count()
WARM = ("none", "used", "fell_back")


def sources() -> list[Path]:
    return sorted(FLIGHT.glob("*.c"))


def write_pattern(folder: Path, problem: Problem, settings: Settings, fp: int) -> Tables:
    """pattern.h and pattern.c of a problem."""
    tables = tables_of(problem, settings)
    (folder / "pattern.h").write_text(pattern_header(tables, fp))
    (folder / "pattern.c").write_text(pattern_source(tables, settings))
    return tables


@cache
def objects(fp: int, index_bits: int, compiler: str, options: tuple[str, ...]) -> tuple[Path, ...]:
    """The library's objects, compiled once for all problems of a test run."""
    folder = Path(tempfile.mkdtemp(prefix="flight-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    macros = [f"-DORBSOC_FP={fp}", f"-DORBSOC_INDEX_BITS={index_bits}"]
    command = [compiler, *STRICT, *options, *macros, f"-I{FLIGHT}", "-fPIC", "-c", *map(str, sources())]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return tuple(sorted(folder.glob("*.o")))


def need(*tools: str) -> None:
    """Skip where a tool is missing; fail there in continuous integration."""
    missing = [tool for tool in tools if shutil.which(tool) is None]
    if missing:
        reason = f"no {', '.join(missing)}: see the packages in .ci/run"
        if "ORBSOC_REQUIRE_FLIGHT" in os.environ:
            pytest.fail(reason)
        pytest.skip(reason)


def compiled(
    folder: Path, problem: Problem, settings: Settings, fp: int, compiler: str = "gcc", *options: str
) -> CSolver:
    """A solver for this problem's pattern."""
    need(compiler)
    tables = write_pattern(folder, problem, settings, fp)
    made = folder / f"flight{next(_NUMBER)}.so"  # a library that is loaded is not loaded again under its name
    macros = [f"-DORBSOC_FP={fp}", f"-DORBSOC_INDEX_BITS={tables.index_bits}"]
    own = [folder / "pattern.c", ROOT / "tests" / "flight" / "harness.c"]
    library = objects(fp, tables.index_bits, compiler, options or ("-O2",))
    command = [compiler, *STRICT, "-O0", *macros, f"-I{FLIGHT}", f"-I{folder}", "-shared", "-fPIC",
               *map(str, (*own, *library)), "-lm", "-o", str(made)]  # fmt: skip
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return CSolver(made, problem, tables, fp)


class CSolver:
    """A solver in C, with the data of a problem."""

    def __init__(self, made: Path, problem: Problem, tables: Tables, fp: int) -> None:
        self.library, self.tables, self.fp = ctypes.CDLL(str(made)), tables, fp
        self.library.harness_solver.restype = ctypes.c_void_p
        self.library.harness_words.restype = ctypes.c_void_p
        self.problem = problem
        assert self.library.harness_open() == 0
        self.set(problem)

    def set(self, problem: Problem) -> None:
        """Take the data of a problem of the same pattern."""
        for name, values in given_data(problem).items():
            setter = getattr(self.library, f"orbsoc_set_{name}")
            assert setter(ctypes.c_void_p(self.library.harness_solver()), _pointer(values)) == 0, name

    def begin(self) -> None:
        self.library.orbsoc_begin(ctypes.c_void_p(self.library.harness_solver()), 1)

    def run(self, stage: str) -> int:
        return int(self.library.harness_run(list(_core.stages()).index(stage)))

    def words(self, buffer: int, count: int) -> NDArray[Any]:
        """Bits of a buffer's words."""
        kind = np.uint64 if self.fp == 64 else np.uint32
        at = self.library.harness_words(buffer)
        return np.frombuffer(ctypes.string_at(at, count * self.fp // 8), kind).astype(np.uint64)

    def solve(self, start: Any = None) -> dict[str, Any]:
        """The outcome: status, counts, and the bits of all its numbers."""
        solver = ctypes.c_void_p(self.library.harness_solver())
        if start is None:
            assert self.library.orbsoc_solve(solver) == 0
        else:
            assert self.library.orbsoc_solve_from(solver, *map(_pointer, start)) == 0
        sizes = self.tables.sizes
        out = np.zeros(NUMBERS + sizes["n"] + sizes["p"] + 2 * sizes["given_m"])
        self.library.harness_numbers(_pointer(out))
        return {
            "status": STATUSES[int(out[0])], "warm_start": WARM[int(out[1])], "iterations": int(out[2]),
            "refinements": int(out[3]), "attempts": int(out[4]), "numbers": bits(out[5:]),
        }  # fmt: skip


def expected(raw: Any) -> dict[str, Any]:
    """The same of the exact engine's solution."""
    scalars = [raw.objective, raw.dual_objective, raw.primal_residual, raw.dual_residual, raw.gap, raw.radius]
    return {
        "status": raw.status, "warm_start": raw.warm_start, "iterations": raw.iterations,
        "refinements": raw.refinements, "attempts": raw.attempts,
        "numbers": bits(np.concatenate([scalars, raw.x, raw.y, raw.z, raw.s])),
    }  # fmt: skip


def bits(numbers: NDArray[np.float64]) -> list[int]:
    """Their bits; NaN counts as one number: its sign and payload are the machine's, not the arithmetic's."""
    numbers = np.where(np.isnan(numbers), np.nan, numbers)
    found: list[int] = numbers.view(np.uint64).tolist()
    return found


def _pointer(values: NDArray[np.float64]) -> Any:
    return np.ascontiguousarray(values).ctypes.data_as(ctypes.POINTER(ctypes.c_double))
