"""Fly plans: propagate their attitude programmes, many at once, to the orbits that they reach.

The commanded direction is the degree N − 1 interpolant of the programme's vectors, normalised, at constant thrust
(docs/algorithm.md). Integrated by DOP853 (`orbsoc.orbit.runge_kutta`) with the force written down here: neither the
collocation that predicts a plan nor the Gauss integrator that polishes it takes part, and the interpolant is evaluated as
a sum of Legendre polynomials, not by the collocation's formula. Where a flight's estimated error is
too large, its steps are cut and it is flown again.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.polynomial.legendre import leggauss, legvander

from orbsoc.guidance.powered_flight import Burn
from orbsoc.orbit.array import Array, Flags, Index
from orbsoc.orbit.runge_kutta import RungeKuttaArc, force_times, integrate_explicitly, refined

from ..batch import Batch, column
from .lowest_point import lowest_radius

FIRST_STEPS, MOST_STEPS = 8, 2048
"""Steps of a flight, and those beyond which it is given up: what it reached then is NaN, and confirms no plan."""
MOST_PIECES = 8
"""Into which a step is cut at once."""
ERROR = 2e-8
"""Largest estimated error of a flight, canonical: 13 cm, or 0.16 mm/s."""
RAW_SAMPLES = 201
"""Times at which the raw interpolant's length is sampled."""
BLOCK = 512
"""Burns in a block: what fits in a core's cache."""


@dataclass(slots=True, eq=False)
class Flights(Batch):
    """B propagated burns, canonical: end states (B, 6), smallest radius (B,) on the way, the extremes of the raw
    interpolant's length (B,), and the estimated error (B,) of the propagation."""

    ends: Array = column(np.nan, 6)
    lowest: Array = column()
    raw_most: Array = column()
    raw_least: Array = column()
    error: Array = column()


GivenUp = Callable[[Index, Flights], Flags]
"""Which of some flights, named by their numbers, need no better accuracy."""


def fly(
    burn: Burn,
    duration: float,
    programmes: Array,
    *,
    steps: int = FIRST_STEPS,
    give_up: GivenUp | None = None,
) -> Flights:
    """Propagate the burns that programmes (B, N, 3) on N Legendre–Gauss nodes command for `duration` (canonical), in
    `steps` steps, cut where they are too long for some until its error is small enough, or it is given up."""
    count = len(programmes)
    out = Flights.blank(count)
    equal = np.linspace(0.0, duration, steps + 1)
    for first in range(0, count, BLOCK):
        left, ends = np.arange(first, min(first + BLOCK, count)), equal
        while left.size:
            found, arc = _flown(burn, ends, programmes[left])
            out.put(left, found)
            rough = ~(found.error <= ERROR)  # True for NaN
            if give_up is not None:
                rough &= ~give_up(left, found)
            again = np.flatnonzero(rough)
            if again.size:
                ends = refined(arc, again, ERROR, MOST_PIECES)
            left = left[again]
            if len(ends) > MOST_STEPS:
                out.ends[left], out.lowest[left] = np.nan, np.nan
                break
    return out


def _flown(burn: Burn, ends: Array, programmes: Array) -> tuple[Flights, RungeKuttaArc]:
    count, nodes, _ = programmes.shape
    times = force_times(ends)
    at = 2.0 * times / times[-1] - 1.0
    stacked = programmes.transpose(1, 2, 0).reshape(nodes, 3 * count)
    push = (_sampling(nodes, at) @ stacked).reshape(-1, 3, count)
    push *= (burn.thrust_acceleration(times)[:, None] / _lengths(push))[:, None]
    raw = _lengths((_raw_sampling(nodes) @ stacked).reshape(-1, 3, count))

    def force(k: int, position: Array) -> Array:
        square = position * position
        square = square[0] + square[1] + square[2]
        square *= np.sqrt(square)
        return np.asarray(push[k] - position / square)

    start = np.repeat(burn.start[:, None], count, axis=1)
    arc = integrate_explicitly(ends, start[:3], start[3:], force)
    reached = np.concatenate([arc.positions[-1], arc.velocities[-1]]).T
    error = arc.errors.sum(axis=0)
    return Flights(reached, lowest_radius(arc), raw.max(axis=0), raw.min(axis=0), error), arc


def _sampling(nodes: int, at: Array) -> Array:
    """From values at Legendre–Gauss nodes to their interpolant at τ: Σ P_k(τ) (2k + 1)/2 Σᵢ wᵢ P_k(τᵢ) uᵢ, whose inner sums
    are exact."""
    return np.asarray(legvander(at, nodes - 1) @ _moments(nodes))


@cache
def _moments(nodes: int) -> Array:
    points, weights = leggauss(nodes)
    return np.asarray((np.arange(nodes) + 0.5)[:, None] * (legvander(points, nodes - 1) * weights[:, None]).T)


@cache
def _raw_sampling(nodes: int) -> Array:
    return _sampling(nodes, np.linspace(-1.0, 1.0, RAW_SAMPLES))


def _lengths(vectors: Array) -> Array:
    """Of vectors (K, 3, B), (K, B)."""
    return np.asarray(np.sqrt(np.einsum("kdb,kdb->kb", vectors, vectors)))
