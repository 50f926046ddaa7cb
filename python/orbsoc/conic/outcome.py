"""The outcome of a solve: status, residuals of the certificate, and points to start from."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import Literal

from .csc import Array


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
"""What became of the point a solve was to start from: there was none, the solution was reached from it, or it was
rejected and the solve restarted from cold."""


@dataclass(frozen=True, slots=True)
class Certificate:
    """Residual ratios recomputed on the original data (1 means exactly at tolerance 1).

    `radius` is the certified radius of an infeasibility status: no (primal or dual) feasible
    point has an infinity norm below it; NaN for every other status.
    """

    primal_residual: float
    dual_residual: float
    gap: float
    radius: float
