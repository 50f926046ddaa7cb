"""Random data for law tests: cones, problems and points, sizes 1 … 16."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from hypothesis import strategies as st
from numpy.typing import NDArray

from orbsoc.conic.problem import Cones, Problem
from orbsoc.conic.solution import Status

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Point:
    """What `verify` and `check_certificate` look at."""

    x: Array
    y: Array
    z: Array
    s: Array
    status: Status = Status.SOLVED


def point(
    problem: Problem, x: object, y: object = (), z: object = (), status: Status = Status.SOLVED
) -> Point:
    """A point with s = h − Gx; y or z left out are zeros."""
    primal = np.asarray(x, dtype=np.float64)
    multipliers = np.asarray(y, dtype=np.float64) if np.size(np.asarray(y)) else np.zeros(problem.p)
    cone = np.asarray(z, dtype=np.float64) if np.size(np.asarray(z)) else np.zeros(problem.m)
    return Point(primal, multipliers, cone, problem.h - problem.G @ primal, status)


@st.composite
def cones(draw: st.DrawFn) -> Cones:
    """Up to 6 R₊ rows and up to 3 second-order cones of sizes 1 … 6."""
    return Cones(draw(st.integers(0, 6)), draw(st.lists(st.integers(1, 6), max_size=3)))


@st.composite
def problems(draw: st.DrawFn) -> Problem:
    """Problems with entries over 16 decades, absent blocks, and infinite bounds."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    n, p, kind = draw(st.integers(1, 16)), draw(st.integers(0, 6)), draw(cones())

    def numbers(*shape: int) -> Array:
        values = rng.normal(size=shape) * 10.0 ** rng.uniform(-8, 8, shape)
        return values * (rng.random(shape) < 0.6)

    P = np.diag(np.abs(numbers(n))) if draw(st.booleans()) else None
    h = numbers(kind.m)
    h[: kind.l][rng.random(kind.l) < 0.2] = np.inf
    return Problem(P=P, c=numbers(n), A=numbers(p, n), b=numbers(p), G=numbers(kind.m, n), h=h, cones=kind)
