"""Canonical units: lengths in Earth radii, and time such that the gravitational parameter is 1."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .array import Array
from .constants import EARTH, ConstantsSet


@dataclass(frozen=True, slots=True)
class CanonicalUnits:
    """Conversion factors between SI and units in which μ = 1 and the Earth radius is 1.

    `length_m`, `speed_m_s`, `time_s` and `acceleration_m_s2` are one canonical unit in SI.
    """

    length_m: float
    speed_m_s: float
    time_s: float
    acceleration_m_s2: float

    @classmethod
    def of(cls, constants: ConstantsSet = EARTH) -> CanonicalUnits:
        """LU = Earth radius, VU = √(μ/LU), TU = LU/VU, AU = VU/TU."""
        length_m = constants.earth_radius_m
        speed_m_s = float(np.sqrt(constants.mu_m3_s2 / length_m))
        time_s = length_m / speed_m_s
        return cls(length_m, speed_m_s, time_s, speed_m_s / time_s)

    def state_from_si(self, state_si: Array) -> Array:
        """Canonical [r, v], last axis 6, from [r_m, v_m_s]."""
        return np.asarray(state_si, dtype=np.float64) / self._scale()

    def state_to_si(self, state: Array) -> Array:
        """[r_m, v_m_s], last axis 6, from canonical [r, v]."""
        return np.asarray(state, dtype=np.float64) * self._scale()

    def _scale(self) -> Array:
        return np.repeat([self.length_m, self.speed_m_s], 3)
