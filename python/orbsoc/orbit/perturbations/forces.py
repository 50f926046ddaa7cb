"""Forces on states about the Earth: accelerations and their Jacobians, many states at once. SI, ECI."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Protocol

import numpy as np
from numpy.typing import ArrayLike

from ..array import Array
from ..constants import EARTH, EARTH_J2, ConstantsSet
from ..vectors import cross_matrix
from .atmosphere import density_kg_m3

EARTH_RATE_RAD_S: Final = 7.292115e-5
"""Rotation of the Earth and its air (NIMA TR8350.2, table 3.1)."""
FLATTENING: Final = 1.0 / 298.257
"""Of the ellipsoid that heights of the air are counted from."""


class Force(Protocol):
    """An acceleration that depends on position and velocity."""

    def acceleration(self, states: Array) -> Array:
        """m/s², (B, 3), at states [r_m, v_m_s] (B, 6)."""
        ...

    def jacobian(self, states: Array) -> Array:
        """Derivatives by position and velocity, (B, 3, 6)."""
        ...


@dataclass(frozen=True, slots=True)
class PointMass:
    """−μ r/|r|³."""

    constants: ConstantsSet = EARTH

    def acceleration(self, states: Array) -> Array:
        r = states[:, :3]
        radius = np.sqrt(np.einsum("bi,bi->b", r, r))
        return np.asarray(r * (-self.constants.mu_m3_s2 / radius**3)[:, None])

    def jacobian(self, states: Array) -> Array:
        r = states[:, :3]
        radius = np.sqrt(np.einsum("bi,bi->b", r, r))
        unit = r / radius[:, None]
        found = np.zeros((len(states), 3, 6))
        shape = 3.0 * unit[:, :, None] * unit[:, None, :] - np.eye(3)
        found[:, :, :3] = (self.constants.mu_m3_s2 / radius**3)[:, None, None] * shape
        return found


@dataclass(frozen=True, slots=True)
class J2:
    """Oblateness: the gradient of −(μ J₂ R²/2r³)(3 sin²φ − 1). Source: Vallado, 4th ed., section 8.6."""

    constants: ConstantsSet = EARTH
    j2: float = EARTH_J2

    def acceleration(self, states: Array) -> Array:
        r, (k, _, ratio) = states[:, :3], self._parts(states)
        shape = np.stack([5.0 * ratio - 1.0, 5.0 * ratio - 1.0, 5.0 * ratio - 3.0], axis=1)
        return np.asarray(k[:, None] * r * shape)

    def jacobian(self, states: Array) -> Array:
        r, (k, square, ratio) = states[:, :3], self._parts(states)
        scale = np.array([1.0, 1.0, 3.0])
        found = np.zeros((len(states), 3, 6))
        pole = np.zeros_like(r)
        pole[:, 2] = r[:, 2]
        # a = k [(5ρ − 1) r − 2 z ẑ], ρ = z²/r², ∇k = −5 k r/r², ∇ρ = 2 (z ẑ − ρ r)/r²
        gradient = 2.0 * (pole - ratio[:, None] * r) / square[:, None]
        field = (5.0 * ratio - 1.0)[:, None] * r - 2.0 * pole
        block = 5.0 * r[:, :, None] * gradient[:, None, :]
        block += (5.0 * ratio)[:, None, None] * np.eye(3) - np.diag(scale)
        block -= 5.0 * field[:, :, None] * (r / square[:, None])[:, None, :]
        found[:, :, :3] = k[:, None, None] * block
        return found

    def _parts(self, states: Array) -> tuple[Array, Array, Array]:
        """k = (3/2) μ J₂ R²/r⁵, r², z²/r²."""
        r = states[:, :3]
        square = np.einsum("bi,bi->b", r, r)
        mu, radius = self.constants.mu_m3_s2, self.constants.earth_radius_m
        return 1.5 * mu * self.j2 * radius**2 / square**2.5, square, r[:, 2] ** 2 / square


@dataclass(frozen=True, slots=True, eq=False)
class Drag:
    """−½ ρ B |u| u with u = v − ω_E × r, the velocity through air that turns with the Earth.

    `ballistic_m2_kg` is B = C_D A/m: one number, or one a state (B,). Heights are r − R(1 − f sin²φ).
    """

    ballistic_m2_kg: ArrayLike
    constants: ConstantsSet = EARTH

    def acceleration(self, states: Array) -> Array:
        half, wind, speed, _ = self._parts(states)
        return np.asarray(-(half * speed)[:, None] * wind)

    def jacobian(self, states: Array) -> Array:
        half, wind, speed, by_height = self._parts(states)
        r = states[:, :3]
        radius = np.sqrt(np.einsum("bi,bi->b", r, r))
        sine = r[:, 2] / radius
        along = wind[:, :, None] * (wind / np.maximum(speed, 1e-300)[:, None])[:, None, :]
        by_velocity = -half[:, None, None] * (speed[:, None, None] * np.eye(3) + along)
        # height = r − R(1 − f sin²φ): ∇ = r̂ + 2 R f sinφ (ẑ − sinφ r̂)/r
        unit = r / radius[:, None]
        pole = np.array([0.0, 0.0, 1.0]) - sine[:, None] * unit
        slope = unit + (2.0 * self.constants.earth_radius_m * FLATTENING * sine / radius)[:, None] * pole
        found = np.zeros((len(states), 3, 6))
        found[:, :, :3] = -(by_height * speed)[:, None, None] * wind[:, :, None] * slope[:, None, :]
        found[:, :, :3] -= by_velocity @ cross_matrix([0.0, 0.0, EARTH_RATE_RAD_S])
        found[:, :, 3:] = by_velocity
        return found

    def _parts(self, states: Array) -> tuple[Array, Array, Array, Array]:
        """½ρB, the wind u, |u|, and the derivative of ½ρB by height."""
        r = states[:, :3]
        radius = np.sqrt(np.einsum("bi,bi->b", r, r))
        flat = 1.0 - FLATTENING * (r[:, 2] / radius) ** 2
        density, slope = density_kg_m3(radius - self.constants.earth_radius_m * flat)
        wind = states[:, 3:].copy()
        wind[:, 0] += EARTH_RATE_RAD_S * r[:, 1]
        wind[:, 1] -= EARTH_RATE_RAD_S * r[:, 0]
        half = 0.5 * np.broadcast_to(np.asarray(self.ballistic_m2_kg, np.float64), radius.shape)
        speed = np.sqrt(np.einsum("bi,bi->b", wind, wind))
        return half * density, wind, speed, half * slope
