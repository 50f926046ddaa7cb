"""What a solve returns, whoever solved it."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from os import PathLike
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Status(enum.Enum):
    """Outcome of a solve. docs/algorithm.md states the numbers that must support each."""

    SOLVED = "solved"
    SOLVED_INACCURATE = "solved, inaccurate"
    PRIMAL_INFEASIBLE = "primal infeasible"
    DUAL_INFEASIBLE = "dual infeasible (unbounded if feasible)"
    MAX_ITERATIONS = "iteration limit reached"
    MAX_TIME = "time limit reached"
    NUMERICAL_LIMIT = "no further progress in this arithmetic"
    INTERRUPTED = "interrupted"


@dataclass(frozen=True, slots=True, eq=False)
class Start:
    """A primal-dual point to start a solve from: x (n,), y (p,), z (m,), s (m,), in the problem's own units.

    Rows whose h is +inf take no part, whatever z and s hold there. A point that is not finite elsewhere is no start.
    """

    x: Array
    y: Array
    z: Array
    s: Array


WarmStart = Literal["none", "used", "fell_back"]
"""What became of the point a solve was to start from: there was none, the solution was reached from it, or it did not
pay and the solve started again from cold."""


@dataclass(frozen=True, slots=True)
class Certificate:
    """Residual ratios recomputed on the original data (1 means exactly at tolerance 1).

    `radius` is the certified radius of an infeasibility claim: no (primal or dual) feasible
    point has an infinity norm below it; NaN for every other status.
    """

    primal_residual: float
    dual_residual: float
    gap: float
    radius: float


@dataclass(frozen=True, slots=True)
class Solution:
    """A primal-dual point of min ½xᵀPx + cᵀx, Ax = b, Gx + s = h, s ∈ K, with its evidence.

    Shapes: x (n,), y (p,), z (m,), s (m,). Times are wall-clock seconds.
    For an infeasibility status (y, z) or x is the certificate, not a solution. `iterations` and `refinements`
    are those of all walks: of a warm start that was given up and of a walk that stalled, too.
    """

    status: Status
    x: Array
    y: Array
    z: Array
    s: Array
    objective: float
    dual_objective: float
    iterations: int
    refinements: int
    setup_s: float
    solve_s: float
    certificate: Certificate
    message: str
    nnz_kkt: int
    nnz_l: int
    warm_start: WarmStart = "none"

    def save(self, path: str | PathLike[str]) -> None:
        """Write the solution to a JSON file of schema `orbsoc.solution/1` (see orbsoc.conic.solution_file)."""
        from .solution_file import write_solution

        write_solution(self, path)

    @staticmethod
    def load(path: str | PathLike[str]) -> Solution:
        """Read a JSON file of schema `orbsoc.solution/1`; every number comes back exactly.

        Raises FileError naming the field that is missing or damaged, OSError if there is no such file.
        """
        from .solution_file import read_solution

        return read_solution(path)
