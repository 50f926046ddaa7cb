"""Steer a burn onto an orbit: the smallest change of an attitude programme, and of its duration, whose flight ends there.

The shortest burn onto an orbit may turn around within seconds where its primer vector passes near zero, which no
grid's interpolant holds: its flight misses by some thousandths. Newton's method on the flight
itself removes such a miss: five conditions (angular momentum, and the Laplace vector in the orbit's plane), one unknown for every
component of the programme's vectors and one for the duration, the step of least norm. What comes out is a little longer
than the shortest burn and is on the orbit.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from orbsoc.guidance.powered_flight import Burn
from orbsoc.orbit.array import Array
from orbsoc.orbit.planes import cross, in_plane_axes

from ...model.flight.propagation import fly

MET = 1e-7
"""Of the conditions, canonical: the flights themselves are known to a fifth of this."""
MOST_STEPS = 12
MOST_HALVINGS = 6
DIFFERENCE = 1e-4
"""Change of an unknown from which derivatives are formed."""
DURATION_WEIGHT = 5.0
"""How much easier the duration, in units of the first one, moves than a component of a vector."""


@dataclass(frozen=True, slots=True, eq=False)
class Programme:
    """Vectors (N, 3) in ECI on N Legendre–Gauss nodes, of any length, and the burn's duration, canonical."""

    vectors: Array
    duration: float


@dataclass(frozen=True, slots=True, eq=False)
class OrbitConditions:
    """What is zero on an orbit: H − H* (3) and L − L* along two axes of its plane (2), canonical."""

    momentum: Array
    laplace: Array
    axes: Array

    @classmethod
    def through(cls, state: Array) -> OrbitConditions:
        """Of the orbit through a state (6,), canonical."""
        momentum, laplace = _vectors(state[None])
        axes = np.stack(in_plane_axes(momentum[0] / np.linalg.norm(momentum[0])))
        return cls(momentum[0], laplace[0], axes)

    def __call__(self, states: Array) -> Array:
        """Values (B, 5) at states (B, 6)."""
        momentum, laplace = _vectors(states)
        return np.concatenate([momentum - self.momentum, (laplace - self.laplace) @ self.axes.T], axis=1)

    def miss(self, state: Array) -> float:
        """How far a state (6,) is from the orbit: the larger of |ΔH|/|H| and |ΔL|."""
        momentum, laplace = _vectors(state[None])
        off = np.linalg.norm(momentum[0] - self.momentum) / np.linalg.norm(self.momentum)
        return float(max(off, np.linalg.norm(laplace[0] - self.laplace)))


def steered_onto(burn: Burn, orbit: OrbitConditions, start: Programme) -> Programme | None:
    """A programme near `start` whose flight meets the orbit; None where Newton's method does not get there."""

    def values(unknowns: Array) -> Array:
        """Conditions (5, B) of unknowns (B, 3N + 1) of one duration."""
        ends = fly(burn, start.duration * float(unknowns[0, -1]), unknowns[:, :-1].reshape(-1, n, 3)).ends
        return orbit(ends).T

    n = len(start.vectors)
    x = np.append(start.vectors.ravel(), 1.0)
    here = values(x[None])
    for _ in range(MOST_STEPS):
        if not np.isfinite(here).all():
            return None
        if np.abs(here).max() <= MET:
            return Programme(x[:-1].reshape(n, 3), start.duration * float(x[-1]))
        moved = x + DIFFERENCE * np.eye(x.size)
        slopes = np.hstack([values(moved[:-1]), values(moved[-1:])]) - here
        slopes[:, -1] *= DURATION_WEIGHT
        if not np.isfinite(slopes).all():
            return None
        step = -DIFFERENCE * np.linalg.lstsq(slopes, here[:, 0], rcond=None)[0]
        step[-1] *= DURATION_WEIGHT
        for halvings in range(MOST_HALVINGS):
            trial = x + 0.5**halvings * step
            there = values(trial[None]) if trial[-1] > 0.0 else np.full_like(here, np.inf)
            if np.linalg.norm(there) < np.linalg.norm(here):
                break
        else:
            return None
        x, here = trial, there
    return None


def _vectors(states: Array) -> tuple[Array, Array]:
    """Angular momentum and Laplace vector (B, 3) of states (B, 6), canonical."""
    r, v = states[:, :3], states[:, 3:]
    momentum = cross(r, v)
    return momentum, cross(v, momentum) - r / np.linalg.norm(r, axis=1, keepdims=True)
