"""A mission in C compiled for this machine, called from Python."""

from __future__ import annotations

import ctypes
import subprocess
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tests.flight.c_library import FLIGHT, ROOT, STRICT, need, objects

Array = NDArray[np.float64]
EXITS = (
    "CONVERGED", "INFEASIBLE", "SUBPROBLEM_INFEASIBLE", "SUBPROBLEM_FAILED", "MAX_ITERATIONS", "INTERRUPTED",
    "NOTHING_TO_BURN",
)  # fmt: skip


@dataclass(frozen=True)
class CPlan:
    """What a planner in C came to; `error` is that of the call."""

    error: int
    exit: str
    objections: int
    subproblems: int
    iterations: int
    numbers: Array
    controls: Array
    states: Array

    @property
    def duration_s(self) -> float:
        return float(self.numbers[0])

    @property
    def bits(self) -> bytes:
        return self.numbers.tobytes() + self.controls.tobytes() + self.states.tobytes()


class CMission:
    """A planner on the tables of an exported folder, with `beside` it more sources and macros."""

    def __init__(
        self, folder: Path, made: Path, compiler: str = "gcc", *options: str, beside: Sequence[str] = ()
    ) -> None:
        need(compiler)
        source = (folder / "pattern.h").read_text()
        bits = 16 if "ORBSOC_INDEX_BITS != 16" in source else 32
        library = objects(64, bits, compiler, options or ("-O2",))
        missions = sorted((FLIGHT / "missions").glob("*.c"))
        own = [folder / "pattern.c", folder / "mission.c", ROOT / "tests" / "flight" / "mission_harness.c"]
        command = [compiler, *STRICT, *(options or ("-O2",)), "-DORBSOC_FP=64", f"-DORBSOC_INDEX_BITS={bits}", f"-I{FLIGHT}",
                   f"-I{FLIGHT / 'missions'}", f"-I{folder}", "-shared", "-fPIC",
                   *beside, *map(str, (*missions, *own, *library)), "-lm", "-o", str(made)]  # fmt: skip
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        self.library = ctypes.CDLL(str(made))
        self.library.mission_solver.restype = ctypes.c_void_p
        self.library.mission_direction.argtypes = [ctypes.c_double, ctypes.c_void_p]
        self.nodes = int((folder / "mission.h").read_text().split("ORBSOC_NODES = ")[1].split(",")[0])
        assert self.library.mission_open() == 0

    @property
    def solver(self) -> ctypes.c_void_p:
        return ctypes.c_void_p(self.library.mission_solver())

    def plan(self, start_si: Array) -> CPlan:
        counts = np.zeros(4, np.int32)
        numbers, controls, states = np.zeros(13), np.zeros((self.nodes, 3)), np.zeros((self.nodes, 6))
        error = self.library.mission_plan(*map(_at, (start_si, counts, numbers, controls, states)))
        return CPlan(error, EXITS[counts[0]], *map(int, counts[1:]), numbers, controls, states)

    def data(self, start: Array, reference: Array, sizes: tuple[int, int, int]) -> tuple[Array, Array, Array]:
        """A's entries, b and h of the subproblem about a reference, canonical."""
        a, b, h = (np.zeros(size) for size in sizes)
        self.library.mission_data(*map(_at, (start, reference, a, b, h)))
        return a, b, h

    def guess(self, start: Array) -> Array:
        """States, controls, end and duration of the first reference from a canonical state."""
        reference = np.zeros(9 * self.nodes + 7)
        self.library.mission_guess(_at(start), _at(reference))
        return reference

    def direction(self, elapsed_s: float) -> tuple[int, Array]:
        """The error, and the thrust direction after a time."""
        found = np.zeros(3)
        return self.library.mission_direction(elapsed_s, _at(found)), found


def _at(values: NDArray[Any]) -> Any:
    return np.ascontiguousarray(values).ctypes.data_as(ctypes.c_void_p)
