"""Six burns from one state with different steering laws, to compare the integrators with SciPy."""

from __future__ import annotations

import numpy as np

from orbsoc.orbit import CanonicalUnits, Thruster

UNITS = CanonicalUnits.of()
START_SI = np.array([-4780421.0, 4388673.2, 1069366.2, -4944.1088, -4692.4264, -3389.3615])
VEHICLE = Thruster(160000.0, 270000.0, 60.0)
DURATION_S = 1200.0
RATES = np.random.default_rng(7).normal(size=(2, 3, 6)) * [[[1.0]], [[0.1]]]


def direction(time_s: float) -> np.ndarray:
    """Six steering laws, (3, 6)."""
    swing = RATES[0] + RATES[1] * np.sin(time_s / 600.0)
    return swing / np.linalg.norm(swing, axis=0)


def push(times_s: np.ndarray) -> np.ndarray:
    """Thrust acceleration in canonical units at each time, (times, 3, 6)."""
    size = UNITS.acceleration_m_s2
    return np.array([direction(t) * VEHICLE.acceleration_m_s2(t) / size for t in times_s])
