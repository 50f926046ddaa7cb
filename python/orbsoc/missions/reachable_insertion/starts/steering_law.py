"""Burns whose thrust turns smoothly, corrected by Gauss–Newton until they end on the target orbit.

The direction is a polynomial of low degree in time, normalised. A correction is the smallest one to first order, with
the roughness of the law as its measure, so that of all laws that reach the orbit a smooth one is found. No optimality is
claimed: the result starts the sequence of convex problems where it knows where to go, and it is a plan where the shortest burn
swings around faster than any grid follows.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from orbsoc.guidance.collocation import LegendreGauss, legendre_gauss
from orbsoc.guidance.powered_flight import Burn
from orbsoc.orbit.array import Array
from orbsoc.orbit.runge_kutta import force_times, integrate_explicitly

from .. import tuning
from ..targets.target import Target


@dataclass(frozen=True, slots=True, eq=False)
class Law:
    """Thrust along Σ c_k P_k(τ), normalised, Legendre polynomials of τ ∈ [−1, 1]: `coefficients` (d + 1, 3); `duration`
    canonical."""

    coefficients: Array
    duration: float

    def vectors(self, tau: Array) -> Array:
        """The polynomial itself (K, 3)."""
        return np.asarray(np.polynomial.legendre.legval(tau, self.coefficients).T, dtype=np.float64)

    def directions(self, tau: Array) -> Array:
        """Unit vectors (K, 3)."""
        raw = self.vectors(tau)
        return np.asarray(raw / np.linalg.norm(raw, axis=1, keepdims=True))

    def of_degree(self, degree: int) -> Law:
        """The same law with coefficients up to a degree that is not lower than its own."""
        found = np.zeros((degree + 1, 3))
        found[: len(self.coefficients)] = self.coefficients
        return replace(self, coefficients=found)


def through(grid: LegendreGauss, controls: Array, duration: float) -> Law:
    """The law that interpolates nodal controls (N, 3), of degree N − 1; Gauss quadrature makes the projection exact."""
    basis = np.polynomial.legendre.legvander(grid.nodes, grid.size - 1)
    norms = 2.0 / (2.0 * np.arange(grid.size) + 1.0)
    return Law((basis * grid.weights[:, None]).T @ controls / norms[:, None], duration)


def constant(direction: Array, duration: float) -> Law:
    """Thrust along one inertial direction."""
    return Law((direction / np.linalg.norm(direction))[None], duration)


def longest_of(burn: Burn) -> float:
    """Canonical duration of the longest flight: to the dry mass, and not to no mass at all."""
    return min(burn.longest, tuning.NEARLY_ALL / burn.flow)


def ends_of(burn: Burn, laws: Array, durations: Array, steps: int) -> Array:
    """End states (B, 6) of laws (B, d + 1, 3), flown together in steps that are equal in each."""
    times = force_times(np.linspace(0.0, 1.0, steps + 1))
    basis = np.polynomial.legendre.legvander(2.0 * times - 1.0, laws.shape[1] - 1)
    raw = np.einsum("kd,bdi->kib", basis, laws)
    size = np.linalg.norm(raw, axis=1, keepdims=True)
    left = np.maximum(1.0 - burn.flow * times[:, None, None] * durations, 1e-3)
    thrust = burn.acceleration / left * raw / np.maximum(size, 1e-12)
    square = durations**2
    thrust *= square

    def force(k: int, position: Array) -> Array:
        radius_2 = np.maximum(np.einsum("ib,ib->b", position, position), 0.01)
        return np.asarray(thrust[k] - position * (square / (radius_2 * np.sqrt(radius_2))))

    count = len(durations)
    r = np.repeat(burn.start[:3, None], count, axis=1)
    v = burn.start[3:, None] * durations
    arc = integrate_explicitly(np.linspace(0.0, 1.0, steps + 1), r, v, force)
    return np.column_stack([arc.positions[-1].T, (arc.velocities[-1] / durations).T])


def steps_for(law: Law) -> int:
    """Steps of a flight: for the arc that gravity bends, and for the turn of the thrust."""
    return int(np.clip(np.ceil(4.0 * law.duration), max(4, len(law.coefficients)), tuning.MOST_STEPS))


def corrected(
    burn: Burn,
    target: Target,
    law: Law,
    *,
    free_duration: bool = True,
    iterations: int = 40,
    steps: int | None = None,
) -> tuple[Law, float]:
    """The law corrected onto the orbit, and what it still misses it by (largest of the five conditions).

    Gauss–Newton steps that are smallest with the higher coefficients weighted by their degree. `steps` of each flight are those
    of `steps_for` by default.
    """
    degree = len(law.coefficients) - 1
    steps = steps or steps_for(law)
    weights = tuning.ROUGHNESS * np.repeat(np.arange(degree + 1.0), 3)
    count = weights.size
    x = np.append(law.coefficients.ravel(), np.log(law.duration))
    shape = (-1, degree + 1, 3)
    longest = np.log(longest_of(burn))

    def rows(points: Array) -> Array:
        durations = np.exp(np.minimum(points[:, -1], longest))
        return target.conditions(ends_of(burn, points[:, :-1].reshape(shape), durations, steps))

    found = rows(x[None])[0]
    size = np.linalg.norm(law.coefficients)  # of the law only the direction counts, and its size is kept
    unknowns = count + int(free_duration)
    scale = np.ones(unknowns)
    scale[:count] += weights
    sides = np.vstack([np.eye(count + 1)[:unknowns], -np.eye(count + 1)[:unknowns]])
    for _ in range(iterations):
        if np.abs(found).max() < tuning.MISS:
            break
        both = rows(x + tuning.STEP * sides)
        jacobian = (both[:unknowns] - both[unknowns:]).T / (2.0 * tuning.STEP)
        left, sizes, right = np.linalg.svd(jacobian / scale, full_matrices=False)
        if not sizes[0] > 0.0:
            break  # no step moves any condition
        inverse = right.T @ (left / np.maximum(sizes, 1e-12 * sizes[0])).T
        step = -inverse @ found / scale
        step /= max(1.0, float(np.abs(step).max()) / tuning.LONGEST_STEP)
        tried = np.repeat(x[None], len(tuning.SHARES), axis=0)
        tried[:, :unknowns] += tuning.SHARES[:, None] * step
        tried[:, -1] = np.minimum(tried[:, -1], longest)
        tried[:, :-1] *= size / np.linalg.norm(tried[:, :-1], axis=1, keepdims=True)
        new = rows(tried)
        levels = np.nan_to_num(np.linalg.norm(new @ inverse.T, axis=1), nan=np.inf)
        best = int(levels.argmin())
        if not levels[best] < np.linalg.norm(inverse @ found):
            break
        x, found = tried[best], new[best]
    return Law(x[:-1].reshape(degree + 1, 3), float(np.exp(x[-1]))), float(np.abs(found).max())


def turn_of(law: Law) -> float:
    """The fastest turn, rad per canonical time, between `tuning.SAMPLES` directions."""
    units = law.directions(np.linspace(-1.0, 1.0, tuning.SAMPLES))
    return float(np.linalg.norm(np.diff(units, axis=0), axis=1).max()) * (tuning.SAMPLES - 1) / law.duration


def unit_on(
    burn: Burn, target: Target, law: Law, nodes: int, within: float, *, steps: int | None = None
) -> Law | None:
    """The interpolant of the law's directions at the nodes of a grid, corrected onto the orbit and made of unit length by turns;
    None where it misses the orbit by more than `within`."""
    grid = legendre_gauss(nodes)
    for _ in range(tuning.MADE_UNIT):
        drawn = through(grid, law.directions(grid.nodes), law.duration)
        law, miss = corrected(burn, target, drawn, iterations=8, steps=steps)
        if miss > within:
            return None
    return law


def grid_resolves(law: Law, nodes: int, too_long: float = tuning.TOO_LONG) -> bool:
    """Whether the interpolant of the law's directions at the nodes of a grid is nowhere longer than they are by more."""
    grid = legendre_gauss(nodes)
    between = grid.interpolate(law.directions(grid.nodes), np.linspace(-1.0, 1.0, tuning.SAMPLES))
    return bool(np.linalg.norm(between, axis=1).max() <= 1.0 + too_long)


def smoothed(
    burn: Burn,
    target: Target,
    law: Law,
    most_nodes: int,
    too_long: float = tuning.TOO_LONG,
    shares: tuple[float, ...] = tuning.SHORTENED,
) -> Law | None:
    """A law about as short as a grid of `most_nodes` allows, from one that need not be smooth; None where that fails.

    At each duration the smoothest law is taken: longer until a grid follows it, then shorter by `shares` as long as one does.
    """
    law = law.of_degree(max(tuning.DEGREE, len(law.coefficients) - 1))
    for _ in range(tuning.MOST_LONGER):
        found = smoothest(burn, target, law)
        if found is not None and grid_resolves(found, most_nodes, too_long):
            break
        duration = law.duration * (1.0 + tuning.LENGTHENED)
        if duration > longest_of(burn):
            return None
        law = replace(found or law, duration=duration)
    else:
        return None
    for share in shares:
        for _ in range(tuning.MOST_SHORTER):
            shorter = smoothest(burn, target, replace(found, duration=found.duration * (1.0 - share)))
            if shorter is None or not grid_resolves(shorter, most_nodes, too_long):
                break
            found = shorter
    return found


def smoothest(burn: Burn, target: Target, law: Law) -> Law | None:
    """The law of the same duration and degree that ends on the orbit and turns least, ∫|du/dτ|² dτ; None for none found.

    Gauss–Newton on the turn within the null space of the conditions' Jacobian.
    """
    law, miss = corrected(burn, target, law, free_duration=False, iterations=15)
    for _ in range(tuning.TURNS):
        if miss > tuning.MISS:
            return None
        x = law.coefficients.ravel()
        sides = tuning.STEP * np.vstack([np.eye(x.size), -np.eye(x.size)])
        points = (x + sides).reshape(-1, *law.coefficients.shape)
        rows = target.conditions(ends_of(burn, points, np.full(len(points), law.duration), steps_for(law)))
        turns = _turns(points)
        jacobian, slope = (
            (each[: x.size] - each[x.size :]).T / (2.0 * tuning.STEP) for each in (rows, turns)
        )
        free = np.linalg.svd(jacobian)[2][len(rows[0]) :].T
        free = np.linalg.qr(np.column_stack([x, free]))[0][:, 1:]  # the size of a law turns nothing
        now = _turns(law.coefficients[None])[0]
        step = -free @ np.linalg.lstsq(slope @ free, now, rcond=1e-8)[0]
        size = float(np.linalg.norm(x))
        step /= max(1.0, float(np.abs(step).max()) / (tuning.LONGEST_STEP * size))
        for share in (1.0, 0.3, 0.1):
            moved = replace(law, coefficients=(x + share * step).reshape(law.coefficients.shape))
            moved, missed = corrected(burn, target, moved, free_duration=False, iterations=8)
            new = _turns(moved.coefficients[None])[0]
            if missed <= tuning.MISS and new @ new < now @ now:
                break
        else:
            return law
        gain = 1.0 - (new @ new) / (now @ now)
        law, miss = moved, missed
        if gain < 0.01:
            break
    return law


def _turns(laws: Array) -> Array:
    """Differences (B, 3K) of neighbouring directions of laws (B, d + 1, 3)."""
    basis = np.polynomial.legendre.legvander(
        np.linspace(-1.0, 1.0, tuning.SAMPLES // 4 + 1), laws.shape[1] - 1
    )
    raw = np.einsum("kd,bdi->bki", basis, laws)
    units = raw / np.linalg.norm(raw, axis=2, keepdims=True)
    return np.asarray(np.diff(units, axis=1).reshape(len(laws), -1))
