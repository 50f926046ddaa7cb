"""Launch-inertial and Earth-centred inertial frames.

The launch-inertial frame of Li et al. 2025 has its origin at the Earth's centre; its axes are those of the
launch pad, frozen at launch: x along the launch azimuth, y up, z to the right. The paper does not say so; read
as ECI, its table 1 gives i = 175.2° instead of the printed 28.18°.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from .array import Array


@dataclass(frozen=True, slots=True)
class LaunchFrame:
    """Where the launch-inertial axes point: geocentric latitude, azimuth (from north over east) and inertial
    longitude of the pad at launch, in radians. With the longitude counted from Greenwich at launch, so is Ω.
    """

    latitude_rad: float
    azimuth_rad: float
    inertial_longitude_rad: float


def eci_from_launch_inertial(frame: LaunchFrame) -> Array:
    """Rotation matrix, shape (3, 3), that takes launch-inertial components to ECI ones.

    Columns: x = cos A · north + sin A · east, y = up, z = x × y.
    """
    cos_lat, sin_lat = np.cos(frame.latitude_rad), np.sin(frame.latitude_rad)
    cos_lon, sin_lon = np.cos(frame.inertial_longitude_rad), np.sin(frame.inertial_longitude_rad)
    north = np.array([-sin_lat * cos_lon, -sin_lat * sin_lon, cos_lat])
    east = np.array([-sin_lon, cos_lon, 0.0])
    up = np.array([cos_lat * cos_lon, cos_lat * sin_lon, sin_lat])
    downrange = np.cos(frame.azimuth_rad) * north + np.sin(frame.azimuth_rad) * east
    return np.column_stack([downrange, up, np.cross(downrange, up)])


def rotate_state(rotation: ArrayLike, state: ArrayLike) -> Array:
    """[R r, R v], last axis 6, of states with last axis 6 (both frames inertial and concentric)."""
    matrix, states = np.asarray(rotation, dtype=np.float64), np.asarray(state, dtype=np.float64)
    return np.concatenate([states[..., :3] @ matrix.T, states[..., 3:] @ matrix.T], axis=-1)
