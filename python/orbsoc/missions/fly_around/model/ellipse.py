"""The path to fly: an ellipse about the target at any attitude, and the acceleration that staying on it would need.

The paper's axes are x along the target's motion, y against its angular momentum, z to the nadir; everything here is in
the frame (R, T, N). Source: the paper, section 2; its eq. (8) drops the curvature that matters here.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, pi, sin

import numpy as np
from numpy.typing import ArrayLike

from orbsoc.orbit.array import Array
from orbsoc.orbit.relative import LVLH


def ellipse_axes(angles_rad: ArrayLike) -> Array:
    """Cₐ = C_y(θ_y) C_x(θ_x) C_z(θ_z), (3, 3): takes the target's x, y, z to the ellipse's axes, from angles x, y, z."""
    (x, y, z) = np.asarray(angles_rad, dtype=np.float64).tolist()
    about_x = np.array([[1.0, 0.0, 0.0], [0.0, cos(x), sin(x)], [0.0, -sin(x), cos(x)]])
    about_y = np.array([[cos(y), 0.0, -sin(y)], [0.0, 1.0, 0.0], [sin(y), 0.0, cos(y)]])
    about_z = np.array([[cos(z), sin(z), 0.0], [-sin(z), cos(z), 0.0], [0.0, 0.0, 1.0]])
    return np.asarray(about_y @ about_x @ about_z)


@dataclass(frozen=True, slots=True, eq=False)
class Ellipse:
    """r(t) = frameᵀ (a cos θ, 0, −b sin θ), θ = start + rate t, about a target with a mean motion.

    `frame` (3, 3) takes (R, T, N) to the ellipse's axes; `rate_rad_s` is negative for the other direction.
    """

    semi_axes_m: tuple[float, float]
    frame: Array
    start_rad: float
    rate_rad_s: float
    mean_motion_rad_s: float

    @classmethod
    def of(
        cls,
        semi_axes_m: tuple[float, float],
        angles_rad: ArrayLike,
        start_rad: float,
        period_s: float,
        direction: int,
        mean_motion_rad_s: float,
    ) -> Ellipse:
        """From the angles between the paper's axes and the ellipse's."""
        frame = ellipse_axes(angles_rad) @ LVLH
        return cls(semi_axes_m, frame, start_rad, direction * 2.0 * pi / period_s, mean_motion_rad_s)

    @property
    def period_s(self) -> float:
        return 2.0 * pi / abs(self.rate_rad_s)

    def position(self, times_s: ArrayLike) -> Array:
        """Where it is, (..., 3), frame (R, T, N)."""
        return self._on_axes(times_s, 0)

    def velocity(self, times_s: ArrayLike) -> Array:
        """How fast it moves in the turning frame, (..., 3)."""
        return self._on_axes(times_s, 1)

    def required_acceleration(self, times_s: ArrayLike, disturbance_m_s2: ArrayLike = 0.0) -> Array:
        """What a thruster would have to give all along, (..., 3): r̈ − 2ω-terms − disturbance, by Clohessy–Wiltshire.

        Zero all along only for the natural ellipse, a = 2b in the orbital plane with the period of the orbit.
        """
        n = self.mean_motion_rad_s
        r, v, a = (self._on_axes(times_s, order) for order in range(3))
        natural = np.stack(
            [3.0 * n**2 * r[..., 0] + 2.0 * n * v[..., 1], -2.0 * n * v[..., 0], -(n**2) * r[..., 2]], axis=-1
        )
        return np.asarray(a - natural - np.asarray(disturbance_m_s2))

    def _on_axes(self, times_s: ArrayLike, order: int) -> Array:
        """The derivative of the position of an order, 0 to 2: the same ellipse a quarter turn on, times the rate."""
        angle = self.start_rad + self.rate_rad_s * np.asarray(times_s, dtype=np.float64) + order * pi / 2.0
        a, b = self.semi_axes_m
        local = np.stack([a * np.cos(angle), np.zeros_like(angle), -b * np.sin(angle)], axis=-1)
        return np.asarray(self.rate_rad_s**order * (local @ self.frame))
