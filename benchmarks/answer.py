"""What every solver of a comparison is turned into: one call, one kind of answer."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orbsoc.problem import Problem

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Answer:
    """A primal-dual point in orbsoc's signs, x (n,), y (p,), z (m,), and what the solver says of itself.

    Px + c + Aᵀy + Gᵀz = 0 with z ∈ K. Times are seconds on the solver's own clock, without Python's conversions.
    """

    x: Array
    y: Array
    z: Array
    status: str
    iterations: int
    setup_s: float
    solve_s: float


Solve = Callable[[Problem, float], Answer]
"""Solves one problem at one tolerance with a fresh solver object."""


@dataclass(frozen=True, slots=True)
class Variant:
    """A solver with certain settings; `label` is empty for its defaults and names what differs otherwise."""

    label: str
    solve: Solve


@dataclass(frozen=True, slots=True)
class Solver:
    """A solver of the comparison. Of its variants, the first whose answer verifies is the one that is timed."""

    name: str
    version: str
    variants: tuple[Variant, ...]
