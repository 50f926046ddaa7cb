"""Pitch and yaw programme of a thrust direction in the launch-inertial frame (Li et al. 2025, eq. 21)."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from .array import Array


def pitch_yaw(direction: ArrayLike) -> tuple[Array, Array]:
    """Pitch atan2(u_y, u_x) and yaw −asin(u_z), rad, of thrust directions, shape (..., 3) → (...).

    The directions are normalised first. Pitch is unwrapped along the last axis, so that a programme that
    turns through the vertical twice has no jump of 2π.
    """
    u = np.asarray(direction, dtype=np.float64)
    u = u / np.linalg.norm(u, axis=-1, keepdims=True)
    pitch = np.arctan2(u[..., 1], u[..., 0])
    return (np.unwrap(pitch) if pitch.ndim else pitch), -np.arcsin(np.clip(u[..., 2], -1.0, 1.0))


def thrust_direction(pitch_rad: ArrayLike, yaw_rad: ArrayLike) -> Array:
    """Unit thrust direction, shape (..., 3), of pitch and yaw in rad: the inverse of `pitch_yaw`."""
    pitch, yaw = np.asarray(pitch_rad, dtype=np.float64), np.asarray(yaw_rad, dtype=np.float64)
    return np.stack([np.cos(yaw) * np.cos(pitch), np.cos(yaw) * np.sin(pitch), -np.sin(yaw)], axis=-1)
