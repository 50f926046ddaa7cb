"""Many burns at once by the explicit Runge–Kutta method DOP853, in common steps, with an estimate of each one's error.

r̈ = f(t, r), f of no velocity: the method's stages (matrix A, weights b, nodes c) then need positions only,
r_i = r₀ + hc_i v₀ + h²(A²f)_i, r₁ = r₀ + hv₀ + h²bᵀA f, v₁ = v₀ + hbᵀf, which is DOP853 to rounding. It is of order 8, and
its embedded formulas of orders 5 and 3 estimate the error of every step. Shares nothing with `orbsoc.orbit.gauss` (implicit,
another order, other nodes) nor with the optimiser's collocation, so that it can judge both. Source of the coefficients:
Hairer, Nørsett & Wanner, Solving Ordinary Differential Equations I, II.5, as SciPy publishes them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .array import Array

ORDER = 7
"""By which power of its length the estimated error of a step falls, at least."""

Force = Callable[[int, Array], Array]
"""Acceleration (d, B) at the k-th of `force_times`, at positions (d, B)."""


@dataclass(frozen=True, slots=True, eq=False)
class Tableau:
    """The method for one step length h: `rows` (stages + 1, stages + 2) takes [r₀, v₀, f] to the positions of the stages
    and of the end, `rate` (stages,) takes f to v₁ − v₀, and `errors` (4, stages + 1) takes f, the end's included, to the
    errors of order 5 of position and velocity, then of order 3."""

    nodes: Array
    rows: Array
    rate: Array
    errors: Array


@cache
def tableau(length: float) -> Tableau:
    """For steps of `length`."""
    from scipy.integrate import DOP853

    published: Any = cast(Any, DOP853)
    matrix, weights, nodes = (np.asarray(published.__dict__[name], np.float64) for name in ("A", "B", "C"))
    stages, h = len(weights), length
    extended = np.vstack([matrix[:stages, :stages], weights])  # the last row is the end itself
    rows = np.zeros((stages + 1, stages + 2))
    rows[:, 0], rows[:, 1] = 1.0, h * np.append(nodes[:stages], 1.0)
    rows[:, 2:] = h**2 * extended @ matrix[:stages, :stages]
    errors = np.zeros((2, 2, stages + 1))
    for order, name in enumerate(("E5", "E3")):
        estimate = np.asarray(published.__dict__[name], np.float64)
        errors[order, 0, :stages] = h**2 * estimate @ extended
        errors[order, 1] = h * estimate
    return Tableau(nodes[:stages], rows, h * weights, errors.reshape(4, -1))


def force_times(ends: ArrayLike) -> Array:
    """Times at which the force is evaluated in steps between `ends` (K + 1,): at the start, at the stages of every step after its
    first, and at the end; (11 K + 2,), for the first stage of a step is the end of the one before."""
    at = np.asarray(ends, np.float64)
    within = at[:-1, None] + np.diff(at)[:, None] * tableau(1.0).nodes[1:]
    return np.concatenate([at[:1], within.ravel(), at[-1:]])


@dataclass(frozen=True, slots=True, eq=False)
class RungeKuttaArc:
    """What K steps produced: `ends` (K + 1,), position, velocity and acceleration there, each (K + 1, d, B), and the
    estimated error of every step (K, B), a distance and a speed alike."""

    ends: Array
    positions: Array
    velocities: Array
    accelerations: Array
    errors: Array


def integrate_explicitly(ends: ArrayLike, position: Array, velocity: Array, force: Force) -> RungeKuttaArc:
    """Advance B motions in d dimensions from (d, B) positions and velocities, in steps between times `ends` (K + 1,).

    Raises ValueError unless the times increase.
    """
    at = np.asarray(ends, np.float64)
    if at.ndim != 1 or at.size < 2 or not (np.diff(at) > 0.0).all():
        raise ValueError(f"ends = {at!r}: must be at least two times, each after the one before")
    shape, stages = position.shape, len(tableau(1.0).rate)
    state = np.empty((stages + 3, position.size))  # r₀, v₀, the stages' f, the end's f
    state[0], state[1] = position.ravel(), velocity.ravel()
    state[2] = force(0, position).ravel()
    found = np.empty((3, at.size, position.size))
    found[:, 0] = state[:3]
    errors = np.empty((at.size - 1, shape[1]))
    for step, length in enumerate(np.diff(at)):
        scheme, first = tableau(float(length)), step * (stages - 1)
        for stage in range(1, stages):
            there = (scheme.rows[stage, : stage + 2] @ state[: stage + 2]).reshape(shape)
            state[stage + 2] = force(first + stage, there).ravel()
        end = scheme.rows[stages] @ state[:-1]
        last = first + stages - (step < at.size - 2)
        state[-1] = force(last, end.reshape(shape)).ravel()
        errors[step] = _estimated(scheme, state[2:], shape)
        state[1] += scheme.rate @ state[2:-1]
        state[0], state[2] = end, state[-1]
        found[:, step + 1] = state[:3]
    r, v, a = found.reshape(3, at.size, *shape)
    return RungeKuttaArc(at, r, v, a, errors)


def refined(arc: RungeKuttaArc, which: NDArray[np.intp], tolerance: float, most: int) -> Array:
    """Ends of steps in which the motions `which` of an arc keep the sum of their errors within a tolerance, as far as
    errors fall with the seventh power; no step is cut into more than `most`."""
    worst = np.nan_to_num(arc.errors[:, which], nan=np.inf).max(axis=1)
    share = 0.5 * tolerance / len(worst)
    pieces = np.clip(np.ceil((worst / share) ** (1.0 / ORDER)), 1, most).astype(int)
    cut = [np.linspace(a, b, n + 1)[:-1] for a, b, n in zip(arc.ends, arc.ends[1:], pieces, strict=False)]
    return np.concatenate([*cut, arc.ends[-1:]])


def _estimated(scheme: Tableau, forces: Array, shape: tuple[int, ...]) -> Array:
    """The error of a step, (B,): ε₅²/√(ε₅² + ε₃²/100), the larger of position's and velocity's."""
    parts = (scheme.errors @ forces).reshape(2, 2, *shape)
    fifth, third = np.einsum("opdb,opdb->opb", parts, parts)
    return np.asarray((fifth / np.sqrt(fifth + 0.01 * third + 1e-300)).max(axis=0))
