"""What every solver of a comparison is turned into: one call, one kind of answer."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orbsoc.conic.problem import Problem

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Answer:
    """A primal-dual point in orbsoc's signs, x (n,), y (p,), z (m,), and what the solver says of itself.

    Px + c + Aᵀy + Gᵀz = 0 with z ∈ K. Times are seconds on the solver's own clock, without Python's conversions.
    `claim` is the status as orbsoc names it: SOLVED, PRIMAL_INFEASIBLE, DUAL_INFEASIBLE, or empty for no claim;
    `message` is what the solver adds.
    """

    x: Array
    y: Array
    z: Array
    status: str
    iterations: int
    setup_s: float
    solve_s: float
    claim: str = ""
    message: str = ""


Solve = Callable[[Problem, float], Answer]
"""Solves one problem at one tolerance with a fresh solver object."""


@dataclass(frozen=True, slots=True)
class Variant:
    """A solver with certain settings; `label` is empty for its defaults and names what differs otherwise."""

    label: str
    solve: Solve


def every_problem(_: Problem) -> bool:
    """A solver of all conic problems with quadratic cost."""
    return True


def no_cones(problem: Problem) -> bool:
    """A solver of linear and quadratic programmes."""
    return not problem.cones.q


@dataclass(frozen=True, slots=True)
class Solver:
    """A solver of the comparison. Of its variants, the first whose answer verifies is the one that is timed."""

    name: str
    version: str
    variants: tuple[Variant, ...]
    applies: Callable[[Problem], bool] = every_problem
    """Whether it is made for this problem; where it is not, it does not take part."""
    timed: Callable[[Problem], bool] = every_problem
    """Whether to time it here: false where a solve takes so long that there is nothing to compare."""
    sampled: bool = False
    """Timed on the first problem of each group only: a solver shown for scale."""
