"""The target orbit as the terminal constraints see it: its angular momentum and Laplace vectors, canonical."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orbsoc.orbit import angular_momentum, angular_momentum_jacobian, laplace_jacobian, laplace_vector

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
