"""Many burns at once by the Gauss–Legendre method of order 2s, for forces that do not depend on velocity.

r̈ = f(t, r) is advanced in steps of length h through s Gauss nodes c: with the Butcher matrix A and weights b,
r(c) = r₀ + hc v₀ + h²A²f, r₁ = r₀ + hv₀ + h²bᵀA f, v₁ = v₀ + hbᵀf. The nodes' f is found by fixed-point iteration,
which contracts by about h²/r³ on an orbit; it starts from the f of the step before, extrapolated. A few motions are
iterated over all steps at once instead, which finds the same nodes in fewer and larger operations. Shares nothing with the
optimiser's collocation, which is global and first order. Source: Hairer, Nørsett & Wanner, Solving Ordinary
Differential Equations I, II.7 and II.14.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np

from .array import Array

MAX_ITERATIONS = 40
"""Limit of fixed-point iterations; a step that needs more is far too long, and reports NaN."""
TOLERANCE = 1e-13
"""Change of a node's position, in canonical units, at which they have converged: what is left is the contraction's share of it."""
FEW = 3072
"""Motions times nodes up to which an iteration covers all steps: beyond, its matrix product costs more than it saves."""
EXTRAPOLATED = 5
"""Degree of the polynomial through a step's f that starts the iterations of the next."""

Force = Callable[[slice, Array], Array]
"""Acceleration (s, d, B) at positions (s, d, B) of the nodes that a slice of the node times names."""


@dataclass(frozen=True, slots=True)
class GaussSteps:
    """Equal steps over [0, duration]; `times` (steps · s,) are all nodes in order.

    `double` (s, s) is h²A², `offsets` (s,) is hc, `weights` (s,) is hb and `lever` (s,) is h²bᵀA.
    """

    duration: float
    steps: int
    stages: int
    length: float
    times: Array
    offsets: Array
    double: Array
    weights: Array
    lever: Array


@cache
def gauss_steps(duration: float, steps: int, stages: int = 8) -> GaussSteps:
    """The scheme for `duration` in canonical time. Raises ValueError unless all three are positive."""
    if not (duration > 0.0 and steps >= 1 and stages >= 1):
        raise ValueError(f"duration = {duration}, steps = {steps}, stages = {stages}: all must be positive")
    nodes, weights = np.polynomial.legendre.leggauss(stages)
    c, b = 0.5 * (nodes + 1.0), 0.5 * weights
    # A integrates the Lagrange basis from 0 to each c: fit it to the moments in Legendre polynomials.
    basis = np.polynomial.legendre.legvander(nodes, stages - 1)
    integrals = np.column_stack(
        [
            0.5 * np.polynomial.legendre.legval(nodes, np.polynomial.legendre.legint(unit, lbnd=-1))
            for unit in np.eye(stages)
        ]
    )
    butcher = np.linalg.solve(basis.T, integrals.T).T
    h = duration / steps
    times = (h * (np.arange(steps)[:, None] + c)).ravel()
    return GaussSteps(
        duration=duration,
        steps=steps,
        stages=stages,
        length=h,
        times=times,
        offsets=h * c,
        double=h**2 * butcher @ butcher,
        weights=h * b,
        lever=h**2 * b @ butcher,
    )


@dataclass(frozen=True, slots=True, eq=False)
class GaussArc:
    """What the steps produced: positions at all nodes (steps · s, d, B), and both ends' position and velocity (d, B)."""

    positions: Array
    end_position: Array
    end_velocity: Array


def integrate(scheme: GaussSteps, position: Array, velocity: Array, force: Force) -> GaussArc:
    """Advance B motions in d dimensions from (d, B) positions and velocities; columns that diverge become NaN."""
    if scheme.steps > 1 and len(scheme.times) * position.shape[1] <= FEW:
        arc = _at_once(scheme, position, velocity, force)
        if arc is not None:
            return arc
    return _step_by_step(scheme, position, velocity, force)


def _step_by_step(scheme: GaussSteps, position: Array, velocity: Array, force: Force) -> GaussArc:
    """A step after the other."""
    stages, count = scheme.stages, position.size
    r, v = position, velocity
    square = 0.5 * scheme.offsets[:, None, None] ** 2  # the first iteration starts from a parabola
    ahead = extrapolation(scheme)
    acceleration = np.empty((0, count))
    found = np.empty((scheme.steps * stages, *position.shape))
    for step in range(scheme.steps):
        window = slice(step * stages, (step + 1) * stages)
        drift = r + scheme.offsets[:, None, None] * v
        if step:
            nodes = drift + (ahead @ acceleration).reshape(drift.shape)
        else:
            nodes = drift + square * force(window, drift)[:1]
        for _ in range(MAX_ITERATIONS):
            acceleration = force(window, nodes).reshape(stages, count)
            moved = drift + (scheme.double @ acceleration).reshape(drift.shape)
            change, nodes = np.abs(moved - nodes), moved
            if not (change > TOLERANCE).any():  # a motion that is NaN holds up none of the others
                break
        else:
            nodes = np.where(change.max(axis=(0, 1)) > TOLERANCE, np.nan, nodes)
            acceleration = force(window, nodes).reshape(stages, count)
        found[window] = nodes
        r = r + scheme.length * v + (scheme.lever @ acceleration).reshape(r.shape)
        v = v + (scheme.weights @ acceleration).reshape(v.shape)
    return GaussArc(found, r, v)


def _at_once(scheme: GaussSteps, position: Array, velocity: Array, force: Force) -> GaussArc | None:
    """All steps in each iteration; None where they do not converge."""
    whole, window, count = _whole(scheme), slice(0, len(scheme.times)), position.size
    drift = position + scheme.times[:, None, None] * velocity
    nodes = drift + 0.5 * scheme.times[:, None, None] ** 2 * force(window, drift)[:1]
    for _ in range(MAX_ITERATIONS):
        acceleration = force(window, nodes).reshape(-1, count)
        moved = drift + (whole.double @ acceleration).reshape(drift.shape)
        change, nodes = np.abs(moved - nodes), moved
        if not (change > TOLERANCE).any():
            break
    else:
        return None
    end = position + scheme.duration * velocity + (whole.lever @ acceleration).reshape(position.shape)
    return GaussArc(nodes, end, velocity + (whole.weights @ acceleration).reshape(position.shape))


@dataclass(frozen=True, slots=True)
class _WholeArc:
    """All steps as one: `double` (K, K), `weights` (K,) and `lever` (K,) take the K nodes' f as those of a step do."""

    double: Array
    weights: Array
    lever: Array


@cache
def _gauss_whole(duration: float, steps: int, stages: int) -> _WholeArc:
    scheme = gauss_steps(duration, steps, stages)
    count = steps * stages
    double = np.zeros((count, count))
    after = duration - scheme.length * np.arange(1, steps + 1)
    for step in range(steps):
        own = slice(step * stages, (step + 1) * stages)
        double[own, own] = scheme.double
        since = scheme.times[own.stop :] - (step + 1) * scheme.length
        double[own.stop :, own] = scheme.lever + since[:, None] * scheme.weights
    lever = (scheme.lever + after[:, None] * scheme.weights).ravel()
    return _WholeArc(double, np.tile(scheme.weights, steps), lever)


def _whole(scheme: GaussSteps) -> _WholeArc:
    return _gauss_whole(scheme.duration, scheme.steps, scheme.stages)


def extrapolation(scheme: GaussSteps) -> Array:
    """`double` times the values, at a step's nodes, of the polynomial fitted to f at those of the step before, (s, s)."""
    return _extrapolation(scheme.duration, scheme.steps, scheme.stages)


@cache
def _extrapolation(duration: float, steps: int, stages: int) -> Array:
    scheme = gauss_steps(duration, steps, stages)
    at = 2.0 * scheme.offsets / scheme.length - 1.0
    degree = min(EXTRAPOLATED, stages - 1)
    root = np.sqrt(scheme.weights)
    fit = np.linalg.pinv(np.polynomial.legendre.legvander(at, degree) * root[:, None]) * root
    return np.asarray(scheme.double @ np.polynomial.legendre.legvander(at + 2.0, degree) @ fit)
