"""Burns whose thrust turns smoothly, corrected by Gauss–Newton until they end on the target orbit.

The direction is a polynomial of low degree in time, normalised. A correction is the smallest one to first order, with
the roughness of the law as its measure, so that of all laws that reach the orbit a smooth one is found. No optimality is
claimed: the result starts the sequence of convex problems where it knows where to go, and it is a plan where the shortest burn
swings around faster than any grid follows.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from orbsoc.guidance.collocation import LegendreGauss
from orbsoc.guidance.powered_flight import Burn
from orbsoc.orbit.planes import cross
from orbsoc.orbit.runge_kutta import force_times, integrate_explicitly

from .target import TargetOrbit

Array = NDArray[np.float64]

SAMPLES = 200
"""Of a law, to see how fast it turns."""
MOST_STEPS = 48
STEP = 1e-6
"""Of the finite differences, canonical and of a law of unit size."""
SHARES = np.array([1.0, 0.7, 0.5, 0.35, 0.2, 0.1, 0.03, 0.01])
"""Of a Gauss–Newton step; all are tried at once, and the one with the smallest next step is taken (Deuflhard's natural level
function: it does not depend on how the conditions are scaled, and those of a short burn are badly so)."""
ROUGHNESS = 0.3
"""By how much more a coefficient weighs than that of one degree lower."""
LONGEST_STEP = 0.5
"""Of a coefficient or of the logarithm of the duration, in one step."""
MISS = 1e-10
"""Of the five conditions, canonical, within which a law has reached the orbit."""


@dataclass(frozen=True, slots=True, eq=False)
class Law:
    """Thrust along Σ c_k P_k(τ), normalised, Legendre polynomials of τ ∈ [−1, 1]: `coefficients` (d + 1, 3); `duration`
    canonical."""

    coefficients: Array
    duration: float

    def directions(self, tau: Array) -> Array:
        """Unit vectors (K, 3)."""
        raw = np.polynomial.legendre.legval(tau, self.coefficients).T
        return np.asarray(raw / np.linalg.norm(raw, axis=1, keepdims=True))

    def of_degree(self, degree: int) -> Law:
        """The same law with coefficients up to a degree that is not lower than its own."""
        found = np.zeros((degree + 1, 3))
        found[: len(self.coefficients)] = self.coefficients
        return replace(self, coefficients=found)

    @property
    def fastest_turn(self) -> float:
        """Largest angle between directions that are 1/`SAMPLES` of the burn apart, times `SAMPLES`: rad per burn."""
        u = self.directions(np.linspace(-1.0, 1.0, SAMPLES + 1))
        chords = np.linalg.norm(np.diff(u, axis=0), axis=1)
        return float(SAMPLES * 2.0 * np.arcsin(np.minimum(1.0, 0.5 * chords)).max())


def through(grid: LegendreGauss, controls: Array, duration: float) -> Law:
    """The law that interpolates nodal controls (N, 3), of degree N − 1; Gauss quadrature makes the projection exact."""
    basis = np.polynomial.legendre.legvander(grid.nodes, grid.size - 1)
    norms = 2.0 / (2.0 * np.arange(grid.size) + 1.0)
    return Law((basis * grid.weights[:, None]).T @ controls / norms[:, None], duration)


def constant(direction: Array, duration: float) -> Law:
    """Thrust along one inertial direction."""
    return Law((direction / np.linalg.norm(direction))[None], duration)


def conditions(target: TargetOrbit, ends: Array) -> Array:
    """l·H, q·H, n·H − h, l·L − e, q·L of end states (B, 6) → (B, 5), angular momenta in units of the target's."""
    r, v = ends[:, :3], ends[:, 3:]
    h = cross(r, v)
    laplace = cross(v, h) - r / np.linalg.norm(r, axis=1, keepdims=True)
    return np.column_stack([
        h @ target.perigee / target.momentum,
        h @ target.ahead / target.momentum,
        h @ target.normal / target.momentum - 1.0,
        laplace @ target.perigee - target.eccentricity,
        laplace @ target.ahead,
    ])  # fmt: skip


def ends_of(burn: Burn, laws: Array, durations: Array, steps: int) -> Array:
    """End states (B, 6) of laws (B, d + 1, 3), flown together in steps that are equal in each."""
    times = force_times(np.linspace(0.0, 1.0, steps + 1))
    basis = np.polynomial.legendre.legvander(2.0 * times - 1.0, laws.shape[1] - 1)
    raw = np.einsum("kd,bdi->kib", basis, laws)
    size = np.linalg.norm(raw, axis=1, keepdims=True)
    left = np.maximum(1.0 - burn.flow * times[:, None, None] * durations, 1e-3)
    thrust = burn.acceleration / left * raw / np.maximum(size, 1e-12)
    square = durations**2

    def force(k: int, position: Array) -> Array:
        radius = np.sqrt(np.maximum(np.einsum("ib,ib->b", position, position), 0.01))
        return np.asarray(square * (thrust[k] - position / radius**3))

    count = len(durations)
    r = np.repeat(burn.start[:3, None], count, axis=1)
    v = burn.start[3:, None] * durations
    arc = integrate_explicitly(np.linspace(0.0, 1.0, steps + 1), r, v, force)
    return np.column_stack([arc.positions[-1].T, (arc.velocities[-1] / durations).T])


def steps_for(law: Law) -> int:
    """Steps of a flight: for the arc that gravity bends, and for the turn of the thrust."""
    return int(np.clip(np.ceil(4.0 * law.duration), max(4, len(law.coefficients)), MOST_STEPS))


def corrected(
    burn: Burn,
    target: TargetOrbit,
    law: Law,
    *,
    free_duration: bool = True,
    iterations: int = 40,
) -> tuple[Law, float]:
    """The law corrected onto the orbit, and what it still misses it by (largest of the five conditions).

    Gauss–Newton steps that are smallest with the higher coefficients weighted by their degree.
    """
    degree = len(law.coefficients) - 1
    steps = steps_for(law)
    weights = ROUGHNESS * np.repeat(np.arange(degree + 1.0), 3)
    count = weights.size
    x = np.append(law.coefficients.ravel(), np.log(law.duration))
    shape = (-1, degree + 1, 3)
    longest = np.log(burn.longest)

    def rows(points: Array) -> Array:
        durations = np.exp(np.minimum(points[:, -1], longest))
        return conditions(target, ends_of(burn, points[:, :-1].reshape(shape), durations, steps))

    found = rows(x[None])[0]
    size = np.linalg.norm(law.coefficients)  # of the law only the direction counts, and its size is kept
    unknowns = count + int(free_duration)
    scale = np.ones(unknowns)
    scale[:count] += weights
    sides = np.vstack([np.eye(count + 1)[:unknowns], -np.eye(count + 1)[:unknowns]])
    for _ in range(iterations):
        if np.abs(found).max() < MISS:
            break
        both = rows(x + STEP * sides)
        jacobian = (both[:unknowns] - both[unknowns:]).T / (2.0 * STEP)
        left, sizes, right = np.linalg.svd(jacobian / scale, full_matrices=False)
        inverse = right.T @ (left / np.maximum(sizes, 1e-12 * sizes[0])).T
        step = -inverse @ found / scale
        step /= max(1.0, float(np.abs(step).max()) / LONGEST_STEP)
        tried = np.repeat(x[None], len(SHARES), axis=0)
        tried[:, :unknowns] += SHARES[:, None] * step
        tried[:, -1] = np.minimum(tried[:, -1], longest)
        tried[:, :-1] *= size / np.linalg.norm(tried[:, :-1], axis=1, keepdims=True)
        new = rows(tried)
        levels = np.nan_to_num(np.linalg.norm(new @ inverse.T, axis=1), nan=np.inf)
        best = int(levels.argmin())
        if not levels[best] < np.linalg.norm(inverse @ found):
            break
        x, found = tried[best], new[best]
    return Law(x[:-1].reshape(degree + 1, 3), float(np.exp(x[-1]))), float(np.abs(found).max())


NODES_PER_TURN = 7.5
"""Per rad/burn of the fastest turn, on which the interpolant of nodal directions follows a law.

A straight law p₀ + p₁τ turns at 2/ε rad/burn at most, where ε is the distance of its complex poles from the burn; the error
of N nodes falls with (1 + ε)^−N, and 15/ε of them leave e^−15 of it.
"""
SHORTENED = (0.03, 0.01, 3e-3, 1e-3, 3e-4)
"""Shares of its duration by which a law is shortened, step by step."""


def nodes_for(law: Law) -> int:
    """Nodes of a grid that follows the law."""
    return int(np.ceil(NODES_PER_TURN * law.fastest_turn))


def shortened(burn: Burn, target: TargetOrbit, law: Law, most_nodes: int) -> Law:
    """A law that has reached the orbit, of ever shorter duration as long as it still does and a grid follows it."""
    for share in SHORTENED:
        while True:
            shorter = replace(law, duration=law.duration * (1.0 - share))
            found, miss = corrected(burn, target, shorter, free_duration=False, iterations=12)
            if miss > MISS or nodes_for(found) > most_nodes:
                break
            law = found
    return law
