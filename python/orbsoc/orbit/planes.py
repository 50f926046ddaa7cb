"""Orbital planes: by inclination and node, and as tilt and azimuth about the current plane.

A plane is its unit normal n. About the current normal n₀ every other one is
n(δ, β) = cos δ n₀ + sin δ (cos β e₁ + sin β e₂), where e₁ = ∂n/∂i points to higher inclination and e₂ = n₀ × e₁.
All functions work on leading batch dimensions; angles in radians, inertial axes whose z axis is the pole.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


def normals(inc_rad: ArrayLike, raan_rad: ArrayLike) -> Array:
    """Unit normals (…, 3) of planes of the given inclination and right ascension of the node."""
    inc, raan = np.broadcast_arrays(np.asarray(inc_rad, np.float64), np.asarray(raan_rad, np.float64))
    return np.stack([np.sin(inc) * np.sin(raan), -np.sin(inc) * np.cos(raan), np.cos(inc)], axis=-1)


def inclination_and_node(normal: ArrayLike) -> tuple[Array, Array]:
    """Inclination in [0, π] and node in [0, 2π) of normals (…, 3); the node of an equatorial plane is 0."""
    n = np.asarray(normal, np.float64)
    across = np.hypot(n[..., 0], n[..., 1])
    node = np.where(across > 0.0, np.arctan2(n[..., 0], -n[..., 1]), 0.0)
    return np.arctan2(across, n[..., 2]), np.mod(node, 2.0 * np.pi)


def in_plane_axes(normal: ArrayLike) -> tuple[Array, Array]:
    """Two unit vectors (…, 3) that make a right-handed triad with the normal; the first towards the node."""
    n = np.asarray(normal, np.float64)
    pole = np.where(np.abs(n[..., 2:]) < 0.999, [0.0, 0.0, 1.0], [1.0, 0.0, 0.0])
    first = cross(pole, n)
    first /= np.linalg.norm(first, axis=-1, keepdims=True)
    return first, cross(n, first)


@dataclass(frozen=True, slots=True, eq=False)
class TiltFrame:
    """The current normal and the directions from which azimuths count, each (3,)."""

    normal: Array
    towards_inclination: Array
    across: Array

    @classmethod
    def about(cls, normal: ArrayLike) -> TiltFrame:
        """The frame of a plane's normal (3,)."""
        n = np.asarray(normal, np.float64)
        inc, raan = inclination_and_node(n)
        e1 = np.array([np.cos(inc) * np.sin(raan), -np.cos(inc) * np.cos(raan), -np.sin(inc)])
        return cls(n, e1, cross(n, e1))

    def directions(self, azimuth_rad: ArrayLike) -> Array:
        """Where normals go when they tilt at the azimuths: cos β e₁ + sin β e₂, (…, 3)."""
        beta = np.asarray(azimuth_rad, np.float64)[..., None]
        return np.asarray(np.cos(beta) * self.towards_inclination + np.sin(beta) * self.across)

    def tilted(self, tilt_rad: ArrayLike, azimuth_rad: ArrayLike) -> Array:
        """Normals (…, 3) at the tilts and azimuths."""
        delta = np.asarray(tilt_rad, np.float64)[..., None]
        return np.asarray(np.cos(delta) * self.normal + np.sin(delta) * self.directions(azimuth_rad))

    def tilt_and_azimuth(self, normal: ArrayLike) -> tuple[Array, Array]:
        """Tilt in [0, π] and azimuth in [0, 2π) of normals (…, 3)."""
        n = np.asarray(normal, np.float64)
        x, y = n @ self.towards_inclination, n @ self.across
        return np.arctan2(np.hypot(x, y), n @ self.normal), np.mod(np.arctan2(y, x), 2.0 * np.pi)


def cross(a: NDArray[Any], b: NDArray[Any]) -> NDArray[Any]:
    """a × b along the last axis; broadcasts, and takes complex arrays. Several times faster than `np.cross`."""
    shape = a.shape if a.shape == b.shape else np.broadcast_shapes(a.shape, b.shape)
    out = np.empty(shape, a.dtype if a.dtype == b.dtype else np.result_type(a, b))
    of_a, of_b = [a[..., i] for i in range(3)], [b[..., i] for i in range(3)]
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        np.subtract(of_a[j] * of_b[k], of_a[k] * of_b[j], out=out[..., i])
    return out


def orbit_normal(states: ArrayLike) -> Array:
    """Unit normals (…, 3) of the planes that states (…, 6) move in: along r × v."""
    x = np.asarray(states, np.float64)
    momentum = cross(x[..., :3], x[..., 3:])
    return np.asarray(momentum / np.linalg.norm(momentum, axis=-1, keepdims=True))


def plane_error(states: ArrayLike, normal: ArrayLike) -> Array:
    """Angle between r × v of states (…, 6) and the normals (…, 3), in [0, π]."""
    x, n = np.asarray(states, np.float64), np.asarray(normal, np.float64)
    momentum = cross(x[..., :3], x[..., 3:])
    sine = np.linalg.norm(cross(momentum, n), axis=-1)
    return np.asarray(np.arctan2(sine, (momentum * n).sum(axis=-1)))
