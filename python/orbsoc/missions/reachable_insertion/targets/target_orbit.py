"""The target orbit as the terminal constraints see it: its angular momentum and Laplace vectors, canonical."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from orbsoc.orbit import (
    EARTH,
    CanonicalUnits,
    ConstantsSet,
    Elements,
    angular_momentum,
    angular_momentum_jacobian,
    laplace_jacobian,
    laplace_vector,
)
from orbsoc.orbit.array import Array
from orbsoc.orbit.planes import cross

from .rows import PLANE_ROWS, TERMINAL_ROWS, Row

CIRCULAR = 1e-9
"""Eccentricity below which a target has no usable perigee direction."""


@dataclass(frozen=True, slots=True, eq=False)
class TargetOrbit:
    """Orthonormal directions and sizes of a target orbit, μ = 1.

    `normal` = H/|H|, `perigee` = L/|L| (any in-plane direction on a circular orbit), `ahead` = normal × perigee;
    `momentum` = |H|, `eccentricity` = |L|.
    """

    normal: Array
    perigee: Array
    ahead: Array
    momentum: float
    eccentricity: float
    constants: ConstantsSet = field(default=EARTH, kw_only=True)

    @classmethod
    def through(cls, state: Array, constants: ConstantsSet = EARTH) -> TargetOrbit:
        """The orbit through a canonical state (6,). Raises ValueError if r and v are parallel."""
        h = angular_momentum(state[:3], state[3:])
        laplace = laplace_vector(state[:3], state[3:], 1.0)
        momentum, eccentricity = float(np.linalg.norm(h)), float(np.linalg.norm(laplace))
        if not momentum > 1e-9:
            raise ValueError("r × v = 0: position and velocity must not be parallel")
        perigee = (
            laplace / eccentricity if eccentricity >= CIRCULAR else state[:3] / np.linalg.norm(state[:3])
        )
        normal = h / momentum
        return cls(normal, perigee, np.cross(normal, perigee), momentum, eccentricity, constants=constants)

    def velocity_along(self, position: Array) -> Array:
        """Canonical velocity (3,) on the orbit where it passes nearest to the direction of a position (3,)."""
        in_plane = position - (position @ self.normal) * self.normal
        size = float(np.linalg.norm(in_plane))
        outwards = in_plane / size if size > 1e-9 else self.perigee
        return np.cross(self.normal, self.eccentricity * self.perigee + outwards) / self.momentum

    @property
    def is_circular(self) -> bool:
        return self.eccentricity < CIRCULAR

    @property
    def rows(self) -> tuple[Row, ...]:
        return TERMINAL_ROWS

    @property
    def energy(self) -> float | None:
        return -0.5 * (1.0 - self.eccentricity**2) / self.momentum**2

    def conditions(self, ends: Array) -> Array:
        """l·H, q·H, n·H − h, l·L − e, q·L of end states (B, 6) → (B, 5), angular momenta in units of the target's."""
        r, v = ends[:, :3], ends[:, 3:]
        h = cross(r, v)
        laplace = cross(v, h) - r / np.linalg.norm(r, axis=1, keepdims=True)
        return np.column_stack([
            h @ self.perigee / self.momentum,
            h @ self.ahead / self.momentum,
            h @ self.normal / self.momentum - 1.0,
            laplace @ self.perigee - self.eccentricity,
            laplace @ self.ahead,
        ])  # fmt: skip

    def linear_rows(self, end: Array) -> tuple[Array, Array]:
        block, rhs = self.scaled_rows(end)
        return block, rhs + np.array([0.0, 0.0, self.momentum, self.eccentricity, 0.0])

    def scaled_rows(self, end: Array) -> tuple[Array, Array]:
        """The same for S_H = S_L = 0."""
        linear = LinearVectors.about(end)
        for_h, for_l = np.array([self.perigee, self.ahead, self.normal]), np.array([self.perigee, self.ahead])
        block = np.vstack([times(for_h, linear.momentum_jacobian), times(for_l, linear.laplace_jacobian)])
        known = (times(for_h, linear.momentum_value), times(for_l, linear.laplace_value))
        return block, -np.concatenate(known)

    def misses(self, end: Array) -> tuple[tuple[Row, float], ...]:
        rows = self.conditions(end[None])[0]
        rows[:3] *= self.momentum
        return tuple(zip(TERMINAL_ROWS, rows.tolist(), strict=True))

    def words(self, row: Row, value: float, end: Array, scales: tuple[float, float] = (1.0, 1.0)) -> str:
        momentum, speed_m_s = scales[0] * self.momentum, CanonicalUnits.of(self.constants).speed_m_s
        side = "small" if value < 0 else "large"
        if row in PLANE_ROWS:
            angle = abs(value) / momentum
            across_m_s = angle * float(np.linalg.norm(end[3:])) * speed_m_s
            axis = "line of apsides" if row is Row.LEAN_ACROSS else "in-plane normal of the line of apsides"
            return (
                f"the orbit plane tilted by {np.rad2deg(angle):.4f}° about the {axis} (some {across_m_s:.1f} m/s of"
                " velocity out of the plane)"
            )
        if row is Row.MOMENTUM:
            level_m_s = abs(value) / float(np.linalg.norm(end[:3])) * speed_m_s
            return (
                f"the angular momentum too {side} by {abs(value) / momentum:.2e} of itself"
                f" (about {level_m_s:.1f} m/s of horizontal velocity)"
            )
        if row is Row.ECCENTRICITY:
            return f"the eccentricity too {side} by {abs(value):.2e}"
        eccentricity = max(scales[1] * self.eccentricity, abs(value))
        return f"the perigee direction off by {np.rad2deg(np.arctan2(abs(value), eccentricity)):.3f}°"

    def promised(self, _end: Array, scales: tuple[float, float] = (1.0, 1.0)) -> tuple[Array, Array]:
        return (scales[0] * self.momentum * self.normal, scales[1] * self.eccentricity * self.perigee)

    def impulse(self, state: Array) -> Array:
        return self.velocity_along(state[:3]) - state[3:]

    def there(self, states: Array) -> tuple[Array, Array]:
        r = states[:, :3]
        flat = r - np.outer(r @ self.normal, self.normal)
        outwards = flat / np.linalg.norm(flat, axis=1, keepdims=True)
        along = 1.0 + self.eccentricity * (outwards @ self.perigee)
        radius = self.momentum**2 / np.where(along > 1e-9, along, 1e-9)
        velocity = np.cross(self.normal, self.eccentricity * self.perigee + outwards) / self.momentum
        return radius[:, None] * outwards, velocity

    def plane_error(self, momentum: Array) -> float:
        return float(np.arctan2(np.linalg.norm(np.cross(momentum, self.normal)), momentum @ self.normal))

    def momentum_gap(self, momentum: Array) -> float:
        return float(np.linalg.norm(self.momentum * self.normal - momentum))

    def errors(self, _orbit: Elements) -> list[tuple[str, float, str]]:
        return []


@dataclass(frozen=True, slots=True, eq=False)
class LargestOrbit(TargetOrbit):
    """The plane and the perigee direction of an orbit, and a perigee height: all else is as large as it gets."""

    perigee_height_m: float
    is_direction_free: bool

    @classmethod
    def about(
        cls,
        state: Array,
        perigee_height_m: float,
        *,
        is_direction_free: bool,
        constants: ConstantsSet = EARTH,
    ) -> LargestOrbit:
        """The plane and direction of the orbit through a canonical state (6,)."""
        orbit = TargetOrbit.through(state)
        vectors = (orbit.normal, orbit.perigee, orbit.ahead, orbit.momentum, orbit.eccentricity)
        return cls(*vectors, perigee_height_m, is_direction_free, constants=constants)

    @property
    def perigee_radius(self) -> float:
        return 1.0 + self.perigee_height_m / self.constants.earth_radius_m

    @property
    def energy(self) -> float | None:
        return None

    def promised(self, end: Array, scales: tuple[float, float] = (1.0, 1.0)) -> tuple[Array, Array]:
        if self.is_direction_free:
            return angular_momentum(end[:3], end[3:]), laplace_vector(end[:3], end[3:], 1.0)
        return TargetOrbit.promised(self, end, scales)

    def momentum_gap(self, momentum: Array) -> float:
        ahead = momentum @ self.normal > 0.0
        return float(np.linalg.norm(np.cross(momentum, self.normal) if ahead else momentum))

    def perigee_error_m(self, orbit: Elements) -> float:
        """Reached less required."""
        return orbit.perigee_height_m() - self.perigee_height_m

    def errors(self, orbit: Elements) -> list[tuple[str, float, str]]:
        error_m = self.perigee_error_m(orbit)
        shortfall_m = max(0.0, -error_m) if self.is_direction_free else abs(error_m)
        return [("perigee error in m", shortfall_m, "perigee_m")]

    def words(self, row: Row, value: float, end: Array, scales: tuple[float, float] = (1.0, 1.0)) -> str:
        if row is not Row.PERIGEE_RADIUS:
            return TargetOrbit.words(self, row, value, end, scales)
        # slack s in e ≤ p/r_p − 1 + s lets the perigee sink by about r_p s/(1 + e)
        return f"the perigee too low by {abs(value) * (self.constants.earth_radius_m + self.perigee_height_m) / 1e3:.2f} km"


@dataclass(frozen=True, slots=True, eq=False)
class LinearVectors:
    """H and L of the end state to first order about a reference: value + jacobian · x, shapes (3,), (3, 6).

    The constant term is Ĥ − J x̂; the paper's eqs. 16–17 leave −J x̂ out.
    """

    momentum_value: Array
    momentum_jacobian: Array
    laplace_value: Array
    laplace_jacobian: Array

    @classmethod
    def about(cls, end: Array) -> LinearVectors:
        r, v = end[:3], end[3:]
        by_h, by_l = angular_momentum_jacobian(r, v), laplace_jacobian(r, v, 1.0)
        known = angular_momentum(r, v) - times(by_h, end), laplace_vector(r, v, 1.0) - times(by_l, end)
        return cls(known[0], by_h, known[1], by_l)


def times(matrix: Array, by: Array) -> Array:
    """Their product, term after term: `flight/missions/linearise.c` makes the same bits on every machine."""
    return np.asarray(sum(np.multiply.outer(matrix[:, k], by[k]) for k in range(len(by))))
