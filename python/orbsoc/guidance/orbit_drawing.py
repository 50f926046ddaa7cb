"""Orbits drawn flat, in the plane of one of them, about the Earth's disc."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from orbsoc.orbit import EARTH, ConstantsSet, Elements, state_from_elements
from orbsoc.orbit.array import Array
from orbsoc.orbit.elements import at_true_anomaly

if TYPE_CHECKING:
    from matplotlib.axes import Axes

ASYMPTOTE = 0.9
"""Of the anomaly of a hyperbola's asymptote, to which it is drawn at most."""


def plane_of(state: Array) -> Array:
    """Rows: along the position, ahead of it in the orbit's plane, along the angular momentum."""
    outwards = state[:3] / np.linalg.norm(state[:3])
    normal = np.cross(state[:3], state[3:])
    normal /= np.linalg.norm(normal)
    return np.array([outwards, np.cross(normal, outwards), normal])


def draw_orbit(orbit: Elements, axes: Array, reach_km: float) -> tuple[Array, Array]:
    """The orbit's points in a plane's axes, km; of a hyperbola, or beyond `reach_km`, what lies within."""
    widest = np.pi if orbit.ecc < 1.0 else ASYMPTOTE * float(np.arccos(-1.0 / orbit.ecc))
    anomalies = np.linspace(-widest, widest, 721)
    points = np.array([state_from_elements(at_true_anomaly(orbit, nu))[0] for nu in anomalies]) / 1e3
    if orbit.ecc >= 1.0:
        points[np.linalg.norm(points, axis=1) > reach_km] = np.nan
    flat = points @ axes.T
    return flat[:, 0], flat[:, 1]


def draw_earth(panel: Axes, about: ConstantsSet = EARTH) -> None:
    from matplotlib.patches import Circle

    panel.add_patch(
        Circle((0.0, 0.0), about.earth_radius_m / 1e3, facecolor="#e8eef4", edgecolor="#9fb3c8", zorder=0)
    )
