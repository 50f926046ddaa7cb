"""Two impulses that take a server to rest at the target: cost over the time of flight, and every local minimum of it.

The first impulse is at the separation, the second stops the server at the target. For a time t they follow from the
state, so that the cost is a function of t alone. States are in-plane, (R, T) and rates, (4,).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from math import cos, pi, sin
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq, minimize_scalar

from orbsoc.guidance.impulses import ImpulseProgramme
from orbsoc.orbit.array import Array, Index
from orbsoc.orbit.relative import ClohessyWiltshire

Cost = Literal["squares", "norms"]

PLANE = np.array([0, 1, 3, 4])
"""Of a state in (R, T, N) and its rates."""
STEPS = 360
"""Of an orbit, at which the cost is looked at before minima are refined."""
FIRST, EARLY = 0.005, 40
"""Of an orbit, up to which the scan takes `EARLY` steps of one ratio instead, from a thousandth of it on."""
NARROW, CLOSE = 14, 0.3
"""Samples on each side of a singular time, for wells beside it are narrow; by which share a sample may be above the
cost of its minimum."""
PANELS = 8
"""Of an orbit, on each of which the cost is a polynomial to rounding."""
DEGREE = 24


def in_plane(state: ArrayLike) -> Array:
    """(4,) of a state (6,) in (R, T, N)."""
    return np.asarray(np.asarray(state, np.float64)[PLANE])


@dataclass(frozen=True, slots=True)
class Minimum:
    """A local minimum of the cost."""

    time_s: float
    cost: float


@dataclass(frozen=True, slots=True, eq=False)
class Transfers:
    """Flights of up to `times_s[-1]`; the transitions (K, 4, 4) to times_s (K,) serve every state."""

    motion: ClohessyWiltshire
    times_s: Array
    matrices: Array

    @classmethod
    def of(cls, motion: ClohessyWiltshire, longest_s: float) -> Transfers:
        first = min(FIRST * motion.period_s, 0.5 * longest_s)
        steps = max(8, round(STEPS * (longest_s - first) / motion.period_s))
        early = np.geomspace(1e-3 * first, first, EARLY + 1)[:-1]
        poles = np.array(singular_times(motion, longest_s)).reshape(-1, 1)
        beside = motion.period_s * np.geomspace(1e-4, 1.0 / PANELS, NARROW) * np.array([[-1.0], [1.0]])
        near = (poles[:, :, None] + beside).ravel()
        near = near[(near > first) & (near < longest_s)]
        times = np.unique(np.concatenate([early, near, np.linspace(first, longest_s, steps + 1)]))
        return cls(motion, times, _matrices(motion, times))

    def minima(self, state: Array, cost: Cost = "squares") -> tuple[Minimum, ...]:
        """Every local minimum that the scan brackets, by time; the ends count where the cost rises from them."""
        _, low = self._low(state, cost)
        return tuple(self._refined(state, cost, int(k)) for k in low)

    def best(self, state: Array, cost: Cost = "squares") -> Minimum:
        """The cheapest; refines those that may be it by their samples."""
        values, low = self._low(state, cost)
        near = low[values[low] <= (1.0 + CLOSE) * values.min()]
        return min((self._refined(state, cost, int(k)) for k in near), key=lambda each: each.cost)

    def _low(self, state: Array, cost: Cost) -> tuple[Array, Index]:
        """The cost at every time, and which samples are below their neighbours."""
        with np.errstate(all="ignore"):
            values = np.nan_to_num(costs(self.matrices, state, cost), nan=np.inf)
        padded = np.concatenate([[np.inf], values, [np.inf]])
        return values, np.flatnonzero((values <= padded[:-2]) & (values <= padded[2:]) & np.isfinite(values))

    def _refined(self, state: Array, cost: Cost, k: int) -> Minimum:
        ends = self.times_s[max(k - 1, 0)], self.times_s[min(k + 1, len(self.times_s) - 1)]
        value = cost_of(self.motion, state, cost)
        found = minimize_scalar(value, bounds=ends, method="bounded", options={"xatol": 1e-9 * ends[1]})
        options = [Minimum(float(found.x), float(found.fun))]
        options += [Minimum(float(t), value(float(t))) for t in ends]
        return min(options, key=lambda each: each.cost)


def cost_of(motion: ClohessyWiltshire, state: Array, cost: Cost) -> Callable[[float], float]:
    """The cost by the time of flight."""
    return lambda t: float(costs(_matrices(motion, np.array([t])), state, cost)[0])


def costs(matrices: Array, state: Array, cost: Cost) -> Array:
    """(K,), in (m/s)² or m/s; infinite where the time is singular."""
    first, last = impulses(matrices, state)
    a, b = np.sum(first**2, axis=1), np.sum(last**2, axis=1)
    return np.asarray(a + b if cost == "squares" else np.sqrt(a) + np.sqrt(b))


def impulses(matrices: Array, state: Array) -> tuple[Array, Array]:
    """Both velocity changes (K, 2) along R, T, for transitions (K, 4, 4)."""
    r, v = state[:2], state[2:]
    rr, rv, vr, vv = (matrices[:, i : i + 2, j : j + 2] for i in (0, 2) for j in (0, 2))
    determinant = rv[:, 0, 0] * rv[:, 1, 1] - rv[:, 0, 1] * rv[:, 1, 0]
    adjugate = np.stack(
        [np.stack([rv[:, 1, 1], -rv[:, 0, 1]], 1), np.stack([-rv[:, 1, 0], rv[:, 0, 0]], 1)], 1
    )
    after = -np.einsum("kij,kj->ki", adjugate, rr @ r) / determinant[:, None]
    arrival = vr @ r + np.einsum("kij,kj->ki", vv, after)
    return after - v, -arrival


def programme(motion: ClohessyWiltshire, state: Array, time_s: float) -> ImpulseProgramme:
    """The two impulses of a flight."""
    first, last = impulses(_matrices(motion, np.array([time_s])), state)
    dv = np.zeros((2, 3))
    dv[0, :2], dv[1, :2] = first[0], last[0]
    return ImpulseProgramme([0.0, time_s], dv)


def singularity(motion: ClohessyWiltshire, time_s: float) -> float:
    """8(1 − cos τ) − 3τ sin τ with τ = nt, over its size nearby: 0 where two positions do not determine a flight."""
    tau = motion.mean_motion_rad_s * time_s
    return float((8.0 * (1.0 - np.cos(tau)) - 3.0 * tau * np.sin(tau)) / (16.0 + 3.0 * tau))


def singular_times(motion: ClohessyWiltshire, longest_s: float) -> list[float]:
    """Whole revolutions, and the times between with tan(τ/2) = 3τ/8, up to a time."""
    turns = range(1, int(motion.mean_motion_rad_s * longest_s / (2.0 * pi)) + 1)
    between = [
        float(brentq(lambda a: sin(a) - 0.75 * a * cos(a), k * pi + 1e-3, (k + 0.5) * pi)) for k in turns
    ]
    return [2.0 * a / motion.mean_motion_rad_s for a in (*(k * pi for k in turns), *between)]


def stationary_minima(motion: ClohessyWiltshire, state: Array, longest_s: float) -> tuple[float, ...]:
    """Times of all local minima of the sum of squares within (0, longest_s), by polynomials.

    With D = det Φ_rv the cost is N/D², N and D entire: it is stationary where N′D = 2ND′. On an eighth of an orbit N and
    D are polynomials of degree 24 to rounding, so that the roots of that product are all there are.
    """
    chebyshev = np.polynomial.chebyshev
    n = motion.mean_motion_rad_s
    count = max(1, round(PANELS * longest_s / motion.period_s + 0.5))
    edges = np.linspace(0.0, n * longest_s, count + 1)
    scale = float(np.linalg.norm(state[:2]) * n + np.linalg.norm(state[2:]))
    points = chebyshev.chebpts1(DEGREE + 1)
    found = []
    for low, high in pairwise(edges.tolist()):
        tau = 0.5 * (low + high) + 0.5 * (high - low) * points
        matrices = _matrices(motion, tau / n)
        rv = matrices[:, :2, 2:] * n
        determinant = rv[:, 0, 0] * rv[:, 1, 1] - rv[:, 0, 1] * rv[:, 1, 0]
        first, last = impulses(matrices, state / scale)
        cost = (np.sum(first**2, axis=1) + np.sum(last**2, axis=1)) * determinant**2
        over, under = (chebyshev.chebfit(points, each, DEGREE) for each in (cost, determinant))
        slope = chebyshev.chebsub(
            chebyshev.chebmul(chebyshev.chebder(over), under),
            2.0 * chebyshev.chebmul(over, chebyshev.chebder(under)),
        )
        kept = np.flatnonzero(np.abs(slope) > 1e-14 * np.abs(slope).max())[-1] + 1
        roots = chebyshev.chebroots(slope[:kept])
        real = np.real(roots[(np.abs(np.imag(roots)) < 1e-7) & (np.abs(np.real(roots)) <= 1.0)])
        found += [0.5 * (low + high) + 0.5 * (high - low) * float(root) for root in real]
    value = cost_of(motion, state, "squares")
    step = 1e-4 * motion.period_s
    times = sorted(each / n for each in found)
    return tuple(
        t for t in times if step < t < longest_s - step and value(t) < min(value(t - step), value(t + step))
    )


def flat_interval(
    motion: ClohessyWiltshire, state: Array, best: Minimum, share: float = 0.02
) -> tuple[float, float]:
    """Between which times about a minimum the sum of squares is within a share of it, s."""
    value = cost_of(motion, state, "squares")

    def above(t: float) -> float:
        return value(t) - (1.0 + share) * best.cost

    ends = []
    for factor in (0.98, 1.02):
        edge = best.time_s
        while above(edge * factor) < 0.0:
            edge *= factor
        ends.append(float(brentq(above, *sorted((edge, edge * factor)))))
    return ends[0], ends[1]


def _matrices(motion: ClohessyWiltshire, times_s: Array) -> Array:
    """In-plane transitions (K, 4, 4)."""
    return np.array([motion.transition(float(t), 0.0)[np.ix_(PLANE, PLANE)] for t in times_s])
