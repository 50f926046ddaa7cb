"""The target orbit as the terminal constraints see it: its angular momentum and Laplace vectors, canonical."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orbsoc.orbit import (
    Elements,
    angular_momentum,
    angular_momentum_jacobian,
    laplace_jacobian,
    laplace_vector,
)
from orbsoc.orbit.planes import cross

from .rows import TERMINAL_ROWS, Row

Array = NDArray[np.float64]

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

    @classmethod
    def through(cls, state: Array) -> TargetOrbit:
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
        return cls(normal, perigee, np.cross(normal, perigee), momentum, eccentricity)

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
        """The name of each condition, in their order."""
        return TERMINAL_ROWS

    @property
    def energy(self) -> float:
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
        """Block (5, 6) and right-hand side (5,) of the rows to first order about an end state (6,)."""
        block, rhs = self.scaled_rows(end)
        return block, rhs + np.array([0.0, 0.0, self.momentum, self.eccentricity, 0.0])

    def scaled_rows(self, end: Array) -> tuple[Array, Array]:
        """The same for S_H = S_L = 0."""
        linear = LinearVectors.about(end)
        for_h = np.vstack([self.perigee, self.ahead, self.normal])
        for_l = np.vstack([self.perigee, self.ahead])
        block = np.vstack([for_h @ linear.momentum_jacobian, for_l @ linear.laplace_jacobian])
        return block, -np.concatenate([for_h @ linear.momentum_value, for_l @ linear.laplace_value])

    def misses(self, end: Array) -> tuple[tuple[Row, float], ...]:
        """Each row at an end state (6,), as the sequence's slack has it: momenta not scaled."""
        rows = self.conditions(end[None])[0]
        rows[:3] *= self.momentum
        return tuple(zip(TERMINAL_ROWS, rows.tolist(), strict=True))

    def impulse(self, state: Array) -> Array:
        """Velocity of the orbit less the vehicle's (3,), at a state (6,)."""
        return self.velocity_along(state[:3]) - state[3:]

    def there(self, states: Array) -> tuple[Array, Array]:
        """Positions and velocities (K, 3) on the orbit where it passes nearest to the directions of states (K, 6)."""
        r = states[:, :3]
        flat = r - np.outer(r @ self.normal, self.normal)
        outwards = flat / np.linalg.norm(flat, axis=1, keepdims=True)
        along = 1.0 + self.eccentricity * (outwards @ self.perigee)
        radius = self.momentum**2 / np.where(along > 1e-9, along, 1e-9)
        velocity = np.cross(self.normal, self.eccentricity * self.perigee + outwards) / self.momentum
        return radius[:, None] * outwards, velocity

    def plane_error(self, momentum: Array) -> float:
        """Angle (rad) between an angular momentum (3,) and the orbit's."""
        return float(np.arctan2(np.linalg.norm(np.cross(momentum, self.normal)), momentum @ self.normal))

    def momentum_gap(self, momentum: Array) -> float:
        """|ΔH| from an angular momentum (3,)."""
        return float(np.linalg.norm(self.momentum * self.normal - momentum))

    def errors(self, _orbit: Elements) -> list[tuple[str, float, str]]:
        """Nothing: H and L say it all."""
        return []


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
        return cls(angular_momentum(r, v) - by_h @ end, by_h, laplace_vector(r, v, 1.0) - by_l @ end, by_l)
