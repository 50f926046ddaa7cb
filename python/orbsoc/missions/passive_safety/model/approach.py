"""A scenario in the frame (R, T, N): what every part of the mission computes with."""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, pi, radians, sqrt

import numpy as np

from orbsoc.orbit import Elements
from orbsoc.orbit.array import Array
from orbsoc.orbit.relative import ClohessyWiltshire, LinearMotion, YamanakaAnkersen

from ..scenario import Scenario


@dataclass(frozen=True, slots=True, eq=False)
class Approach:
    """Motion, start (6,), capture position (3,), and on which sides of the target the chaser stays."""

    scenario: Scenario
    motion: LinearMotion
    mean_motion_rad_s: float
    start: Array
    capture: Array
    capture_velocity: Array | None
    axes: tuple[int, ...]
    """Of (R, T, N): (0, 1) where nothing leaves the plane."""
    side: float
    """side · R ≥ keep-out is the safe half-space: −1 below the target, 1 above."""
    ahead: float
    """1 where the target is ahead of the start, −1 where it is behind."""

    @classmethod
    def of(cls, scenario: Scenario) -> Approach:
        start, capture = scenario.start.state(), scenario.capture.position()
        velocity = scenario.capture.velocity()
        normal = [start[2], start[5], capture[2], 0.0 if velocity is None else velocity[2]]
        rate = scenario.target.mean_motion()
        return cls(
            scenario=scenario,
            motion=_motion(scenario),
            mean_motion_rad_s=rate,
            start=start,
            capture=capture,
            capture_velocity=velocity,
            axes=(0, 1, 2) if any(normal) else (0, 1),
            side=1.0 if capture[0] > 0.0 else -1.0,
            ahead=-1.0 if start[1] > 0.0 else 1.0,
        )

    def closed_row(self, at_s: float) -> Array:
        """Row (1, 6) of the state at a time that is zero where its drift closes: about a circular target the ellipse's
        centre, about another what T gains in a revolution."""
        if self.circular:
            return cone_rows(self.mean_motion_rad_s)[:1]
        gained = self.motion.transition(at_s + self.period_s, at_s)[1:2] - np.eye(6)[1:2]
        return np.asarray(gained / (-3.0 * pi))

    @property
    def keep_out_m(self) -> float:
        return self.scenario.keep_out_m

    @property
    def duration_s(self) -> float:
        return self.scenario.duration_s

    @property
    def period_s(self) -> float:
        return 2.0 * pi / self.mean_motion_rad_s

    @property
    def circular(self) -> bool:
        """Whether the motion is that about a circular target."""
        return isinstance(self.motion, ClohessyWiltshire)

    @property
    def guarded(self) -> bool:
        """Whether there is anything to keep out of."""
        return self.keep_out_m > 0.0

    def orbit(self) -> Elements:
        """The target's at the start."""
        return self.scenario.target.elements

    def largest_beyond_m(self, dv_r_m_s: float) -> float:
        """Least distance from the target to the closed ellipse of a radial first impulse that encloses it; negative
        where the target is outside. Exact: 2b − p where p ≥ 1.5 b, else b √(1 − p²/3b²), b = |Δv|/n, p = |T₀ + 2b e|."""
        b = abs(dv_r_m_s) / self.mean_motion_rad_s
        p = abs(abs(float(self.start[1])) - 2.0 * b)
        if p >= 1.5 * b:
            return 2.0 * b - p
        return b * sqrt(1.0 - p**2 / (3.0 * b**2))


def _motion(scenario: Scenario) -> LinearMotion:
    target = scenario.target
    if target.elliptic:
        return YamanakaAnkersen(target.mean_motion(), target.eccentricity, radians(target.true_anomaly_deg))
    return ClohessyWiltshire(target.mean_motion())


def cone_rows(n: float) -> Array:
    """Rows (c, a, b) of a state (6,) with R(t) = c + a cos nt + b sin nt about a circular target, (3, 6)."""
    return np.array(
        [
            [4.0, 0.0, 0.0, 0.0, 2.0 / n, 0.0],
            [-3.0, 0.0, 0.0, 0.0, -2.0 / n, 0.0],
            [0.0, 0.0, 0.0, 1.0 / n, 0.0, 0.0],
        ]
    )


def after_half_orbit(n: float) -> Array:
    """T half an orbit later, about a circular target, as a row of the state (6,): cos nt = −1."""
    return np.array([-6.0 * pi, 1.0, 0.0, 2.0 * (cos(pi) - 1.0) / n, -3.0 * pi / n, 0.0])
