"""The drift ellipse: where a chaser goes about a circular orbit when it fires no more."""

from __future__ import annotations

from dataclasses import dataclass
from math import atan2, hypot

import numpy as np
from numpy.typing import ArrayLike

from ..array import Array


@dataclass(frozen=True, slots=True)
class DriftEllipse:
    """In-plane free motion about a circular orbit, t after the state it was made from:

    R = centre_r + minor cos(nt + phase), T = centre_t + drift t − 2 minor sin(nt + phase).

    The 2:1 ellipse moves along T by `drift_m_s` = −(3/2) n centre_r. N swings on its own: amplitude `normal_m`.
    """

    centre_r_m: float
    centre_t_m: float
    drift_m_s: float
    minor_m: float
    phase_rad: float
    normal_m: float
    mean_motion_rad_s: float

    @classmethod
    def of(cls, state: ArrayLike, mean_motion_rad_s: float) -> DriftEllipse:
        """From a state (6,) in the frame (R, T, N)."""
        n = mean_motion_rad_s
        x, y, z, vx, vy, vz = (float(each) for each in np.asarray(state, np.float64))
        centre = 4.0 * x + 2.0 * vy / n
        cosine, sine = x - centre, -vx / n
        return cls(
            centre_r_m=centre,
            centre_t_m=y - 2.0 * vx / n,
            drift_m_s=-1.5 * n * centre,
            minor_m=hypot(cosine, sine),
            phase_rad=atan2(sine, cosine),
            normal_m=hypot(z, vz / n),
            mean_motion_rad_s=n,
        )

    @property
    def drift_per_orbit_m(self) -> float:
        """Along T, in one revolution of the target."""
        return 2.0 * np.pi * self.drift_m_s / self.mean_motion_rad_s

    @property
    def lowest_r_m(self) -> float:
        """Least R over all time; exact."""
        return self.centre_r_m - self.minor_m

    @property
    def highest_r_m(self) -> float:
        """Largest R over all time; exact."""
        return self.centre_r_m + self.minor_m

    def positions(self, times_s: ArrayLike) -> Array:
        """(R, T) in metres, (K, 2), at times after the state."""
        t = np.asarray(times_s, np.float64)
        angle = self.mean_motion_rad_s * t + self.phase_rad
        along = self.centre_t_m + self.drift_m_s * t - 2.0 * self.minor_m * np.sin(angle)
        return np.stack([self.centre_r_m + self.minor_m * np.cos(angle), along], axis=-1)
