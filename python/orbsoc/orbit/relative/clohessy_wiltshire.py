"""Relative motion about a circular orbit."""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, isfinite, sin, sqrt
from typing import Any

import numpy as np

from ..array import Array
from ..constants import EARTH, ConstantsSet


@dataclass(frozen=True, slots=True)
class ClohessyWiltshire:
    """Motion relative to a target on a circular orbit, to first order in the distance over the radius.

    R̈ = 2nṪ + 3n²R, T̈ = −2nṘ, N̈ = −n²N. Source: Clohessy & Wiltshire, J. Aerospace Sciences 27(9), 1960.
    Raises ValueError unless the mean motion is positive and finite.

    >>> ClohessyWiltshire(1e-3).transition(600.0, 0.0)[0, 0].round(6)  # 4 − 3 cos nt
    np.float64(1.523993)
    """

    mean_motion_rad_s: float

    def __post_init__(self) -> None:
        if not (self.mean_motion_rad_s > 0.0 and isfinite(self.mean_motion_rad_s)):
            raise ValueError(f"mean_motion_rad_s = {self.mean_motion_rad_s!r}: must be positive and finite")

    @classmethod
    def at_altitude(cls, altitude_m: float, constants: ConstantsSet = EARTH) -> ClohessyWiltshire:
        """About a circular orbit at a height over the equatorial radius."""
        radius = constants.earth_radius_m + altitude_m
        if not radius > 0.0:
            raise ValueError(f"altitude_m = {altitude_m!r}: must lie above the Earth's centre")
        return cls(sqrt(constants.mu_m3_s2 / radius**3))

    @property
    def period_s(self) -> float:
        return 2.0 * np.pi / self.mean_motion_rad_s

    def transition(self, t1_s: float, t0_s: float) -> Array:
        """The state transition matrix (6, 6) from t0_s to t1_s, frame (R, T, N)."""
        n, dt = self.mean_motion_rad_s, t1_s - t0_s
        return np.array(_rows(n, dt, sin(n * dt), cos(n * dt)))

    def transitions(self, dt_s: Array) -> Array:
        """Those by times (...,): (..., 6, 6)."""
        n, one = self.mean_motion_rad_s, np.ones_like(dt_s)
        rows = _rows(n, dt_s, np.sin(n * dt_s), np.cos(n * dt_s))
        return np.moveaxis(np.array([[entry * one for entry in row] for row in rows]), (0, 1), (-2, -1))

    def held(self, dt_s: Array) -> Array:
        """What a unit of acceleration held for times (...,) has made of a state at rest: (..., 6, 3), frame (R, T, N)."""
        n, t, angle = self.mean_motion_rad_s, np.asarray(dt_s, np.float64), self.mean_motion_rad_s * dt_s
        # 1 − cos and angle − sin lose their digits for small angles
        versed, late = 2.0 * np.sin(0.5 * angle) ** 2 / n**2, _late(angle) / n**2
        found = np.zeros((*t.shape, 6, 3))
        found[..., 0, 0] = found[..., 2, 2] = versed
        found[..., 0, 1], found[..., 1, 0] = 2.0 * late, -2.0 * late
        found[..., 1, 1] = 4.0 * versed - 1.5 * t**2
        found[..., 3:, :] = self.transitions(t)[..., :3, 3:]
        return found


def _late(angle: Array) -> Array:
    """angle − sin(angle)."""
    series = angle**3 / 6.0 * (1.0 - angle**2 / 20.0 * (1.0 - angle**2 / 42.0 * (1.0 - angle**2 / 72.0)))
    return np.asarray(np.where(np.abs(angle) < 0.1, series, angle - np.sin(angle)))


def _rows(n: float, dt: Any, s: Any, c: Any) -> list[list[Any]]:
    """By a time, or by many at once, with sine and cosine of its angle."""
    return [
        [4.0 - 3.0 * c, 0.0, 0.0, s / n, 2.0 * (1.0 - c) / n, 0.0],
        [6.0 * (s - n * dt), 1.0, 0.0, 2.0 * (c - 1.0) / n, 4.0 * s / n - 3.0 * dt, 0.0],
        [0.0, 0.0, c, 0.0, 0.0, s / n],
        [3.0 * n * s, 0.0, 0.0, c, 2.0 * s, 0.0],
        [6.0 * n * (c - 1.0), 0.0, 0.0, -2.0 * s, 4.0 * c - 3.0, 0.0],
        [0.0, 0.0, -n * s, 0.0, 0.0, c],
    ]
