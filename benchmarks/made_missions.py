"""What the constructions of missions share: a mission with the burn that made it, the lowest flight, axes of a state."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orbsoc.missions.reachable_insertion import Scenario

Array = NDArray[np.float64]

STANDARD_GRAVITY_M_S2 = 9.80665
LOWEST_M = 120e3
"""Height that no burn of a construction passes below."""


@dataclass(frozen=True, slots=True)
class Mission:
    """A scenario, its kind, and the burn (s) that its construction took; infinite where no burn can do it."""

    kind: str
    scenario: Scenario
    burn_s: float


def axes_along(state: Array) -> Array:
    """Rows: along the velocity, in the plane across it, along the angular momentum."""
    along = state[3:] / np.linalg.norm(state[3:])
    normal = np.cross(state[:3], state[3:])
    normal /= np.linalg.norm(normal)
    return np.array([along, np.cross(normal, along), normal])
