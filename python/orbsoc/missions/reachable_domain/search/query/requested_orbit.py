"""The requested orbit: an ellipse above the ground, every number finite, angles in radians."""

from __future__ import annotations

import math

from orbsoc.orbit import Elements

TURN = 2.0 * math.pi
HALF = math.pi * (1.0 + 1e-12)


class OrbitError(ValueError):
    """An orbit that cannot be asked about: the field, its value, what is allowed."""

    def __init__(self, field: str, value: float, allowed: str) -> None:
        self.field, self.value, self.allowed = field, value, allowed
        super().__init__(f"orbit.{field} = {value:.9g}: {allowed}")


def check_orbit(orbit: Elements) -> None:
    """Raises OrbitError for the first field that is wrong, most basic first."""
    for field in ("sma_m", "ecc", "inc_rad", "raan_rad", "argp_rad", "true_anomaly_rad"):
        value = float(getattr(orbit, field))
        if not math.isfinite(value):
            raise OrbitError(field, value, "must be a finite number")
    if orbit.sma_m <= 0.0:
        raise OrbitError("sma_m", orbit.sma_m, "must be an ellipse, above 0")
    if not 0.0 <= orbit.ecc < 1.0:
        raise OrbitError("ecc", orbit.ecc, "must be an ellipse, within 0…1, 1 not included")
    height_km = orbit.perigee_height_m() / 1e3
    if height_km <= 0.0:
        raise OrbitError(
            "sma_m", orbit.sma_m, f"its perigee lies {-height_km:.3f} km below the surface; must be above it"
        )
    if not 0.0 <= orbit.inc_rad <= HALF:
        raise OrbitError("inc_rad", orbit.inc_rad, "must be within 0…π (radians, not degrees)")
    for field in ("raan_rad", "argp_rad"):
        if abs(getattr(orbit, field)) > TURN * (1.0 + 1e-12):
            raise OrbitError(field, getattr(orbit, field), "must be within ±2π (radians, not degrees)")
