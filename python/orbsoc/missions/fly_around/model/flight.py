"""Free flight beside the path: ballistic arcs under a constant disturbance, and how far they stray from the ellipse."""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, hypot, pi, sin

import numpy as np
from numpy.typing import ArrayLike

from orbsoc.guidance.impulses import ImpulseProgramme
from orbsoc.orbit.array import Array
from orbsoc.orbit.relative import ClohessyWiltshire, DriftEllipse

from .ellipse import Ellipse

SAMPLES = 64
"""Intervals of an arc at which its error is looked at; a parabola finds the largest between them."""
FINE = 2048
"""The same, of the bound above it."""


@dataclass(frozen=True, slots=True, eq=False)
class Flight:
    """Motion beside an ellipse, frame (R, T, N): Clohessy–Wiltshire, and a constant acceleration a_c (3,), m/s²."""

    ellipse: Ellipse
    disturbance_m_s2: Array

    @property
    def motion(self) -> ClohessyWiltshire:
        return ClohessyWiltshire(self.ellipse.mean_motion_rad_s)

    @property
    def longest_transfer_s(self) -> float:
        """π/ω: from there on, two positions and a time do not determine the velocity out of the plane."""
        return pi / self.ellipse.mean_motion_rad_s

    def forced(self, dt_s: float) -> Array:
        """The state (6,) that the disturbance alone makes of 0 in a time; its velocity is Φ_rv a_c. The paper, eq. (2)."""
        n, a = self.ellipse.mean_motion_rad_s, self.disturbance_m_s2
        if not a.any():
            return np.zeros(6)
        s, c = sin(n * dt_s), cos(n * dt_s)
        straight, cross = (1.0 - c) / n**2, 2.0 * (n * dt_s - s) / n**2
        along = 4.0 * straight - 1.5 * dt_s**2
        position = [straight * a[0] + cross * a[1], along * a[1] - cross * a[0], straight * a[2]]
        return np.concatenate([position, self.motion.transition(dt_s, 0.0)[:3, 3:] @ a])

    def state_after(self, state: Array, dt_s: float) -> Array:
        """The state (6,) that a state becomes in a time."""
        return np.asarray(self.motion.transition(dt_s, 0.0) @ state + self.forced(dt_s))

    def arc(self, state: Array, dt_s: float, samples: int = SAMPLES) -> Array:
        """States (samples + 1, 6) at equal intervals of the flight from a state."""
        step, kick = self.motion.transition(dt_s / samples, 0.0), self.forced(dt_s / samples)
        found = np.empty((samples + 1, 6))
        found[0] = state
        for k in range(samples):
            found[k + 1] = step @ found[k] + kick
        return found

    def transfer(self, from_m: Array, to_m: Array, dt_s: float) -> Array:
        """The velocity (3,) that flies from a position to another in a time; the paper, eq. (6). Needs dt_s < π/ω."""
        matrix = self.motion.transition(dt_s, 0.0)
        coasted = matrix[:3, :3] @ from_m + self.forced(dt_s)[:3]
        return np.asarray(np.linalg.solve(matrix[:3, 3:], to_m - coasted))

    def largest_error(self, states: Array, start_s: float, dt_s: float) -> tuple[float, float]:
        """Of an arc's states at equal intervals, the largest distance from the path, m, and when, s.

        Between samples it is the top of a parabola through the squared distances at every local maximum: with `SAMPLES`
        intervals to 1e-6 of the distance.
        """
        times = start_s + np.linspace(0.0, dt_s, len(states))
        squares = np.sum((states[:, :3] - self.ellipse.position(times)) ** 2, axis=1)
        low, middle, high = squares[:-2], squares[1:-1], squares[2:]
        bend = 2.0 * middle - low - high
        peak = (middle >= low) & (middle >= high) & (bend > 0.0)
        shift = np.where(peak, 0.5 * (high - low), 0.0) / np.where(peak, bend, 1.0)
        tops = np.concatenate([squares[:1], middle + 0.25 * (high - low) * shift, squares[-1:]])
        at = times + np.concatenate([[0.0], shift, [0.0]]) * dt_s / (len(states) - 1)
        k = int(np.argmax(tops))
        return float(np.sqrt(tops[k])), float(at[k])

    def error_at_most(self, after: Array, start_s: float, dt_s: float) -> float:
        """Above the distance from the path on the whole arc of a state (6,), m.

        Between samples w apart a vector is within w²/8 max|ë| of its chord, and a chord no longer than its longer end.
        Free motion turns on its ellipse, the disturbance's on Φ_vv, the path on its own.
        """
        path, n = self.ellipse, self.ellipse.mean_motion_rad_s
        turning = DriftEllipse.of(after, n)
        bend = n**2 * hypot(2.0 * turning.minor_m, turning.normal_m)
        bend += 9.0 * float(np.linalg.norm(self.disturbance_m_s2)) + path.rate_rad_s**2 * max(
            path.semi_axes_m
        )
        times = start_s + np.linspace(0.0, dt_s, FINE + 1)
        apart = np.linalg.norm(self.arc(after, dt_s, FINE)[:, :3] - path.position(times), axis=1)
        return float(apart.max() + 0.125 * (dt_s / FINE) ** 2 * bend)


@dataclass(frozen=True, slots=True, eq=False)
class Flown:
    """A programme flown by the model: at each impulse the state before it, of each arc its largest error and when."""

    programme: ImpulseProgramme
    end_s: float
    before: Array
    """States before each impulse and at the end, (N + 1, 6)."""
    errors_m: Array
    """(N,), of the arc after each impulse."""
    errors_at_s: Array

    @property
    def largest_error_m(self) -> float:
        return float(self.errors_m.max())

    @property
    def post_burn_speeds_m_s(self) -> float:
        """Σ|v⁺|: what the paper seems to have summed for its "11.1" and "12.2 m/s"; no velocity change."""
        return float(np.linalg.norm(self.before[:-1, 3:] + self.programme.dv_m_s, axis=1).sum())


def fly(
    flight: Flight, start: ArrayLike, programme: ImpulseProgramme, end_s: float, samples: int = SAMPLES
) -> Flown:
    """Fly a programme from a state (6,) at its first impulse to `end_s`, by the model."""
    times = np.append(programme.times_s, end_s)
    before = np.empty((len(times), 6))
    before[0] = start
    errors = np.empty((len(programme), 2))
    for k, dv in enumerate(programme.dv_m_s):
        after = before[k] + np.concatenate([np.zeros(3), dv])
        states = flight.arc(after, times[k + 1] - times[k], samples)
        errors[k] = flight.largest_error(states, times[k], times[k + 1] - times[k])
        before[k + 1] = states[-1]
    return Flown(programme, end_s, before, errors[:, 0], errors[:, 1])
