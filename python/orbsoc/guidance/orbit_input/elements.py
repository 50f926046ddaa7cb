"""From keys of an orbit table to osculating elements: two numbers of the shape, three angles, and any anomaly."""

from __future__ import annotations

from collections.abc import Mapping
from math import pi, radians
from typing import Any

import numpy as np

from orbsoc.orbit import EARTH, ConstantsSet, Elements
from orbsoc.orbit.anomalies import true_from_eccentric, true_from_mean

Keys = Mapping[str, Any]
"""An orbit table by key, numbers that are not given as None."""

SHAPE = (
    "sma_km", "ecc", "perigee_height_km", "apogee_height_km", "c3_km2_s2", "v_infinity_m_s", "mean_motion_rad_s",
    "period_s",
)  # fmt: skip
SIZES = ("sma_km", "c3_km2_s2", "v_infinity_m_s", "mean_motion_rad_s", "period_s")
"""Keys that give the energy: one of them at most."""
ANGLES = ("inc_deg", "raan_deg", "argp_deg")
ANOMALIES = ("true_anomaly_deg", "mean_anomaly_deg", "eccentric_anomaly_deg", "latitude_argument_deg")
ELEMENTS = (*SHAPE, *ANGLES, *ANOMALIES)


def semi_major_axis_m(keys: Keys, constants: ConstantsSet = EARTH) -> float | None:
    """From the key that gives the energy, if one does."""
    mu = constants.mu_m3_s2
    if (speed_m_s := keys.get("v_infinity_m_s")) is not None:
        return float(-mu / speed_m_s**2)
    if (c3_km2_s2 := keys.get("c3_km2_s2")) is not None:
        return float(-mu / (1e6 * c3_km2_s2))
    if (motion := keys.get("mean_motion_rad_s")) is not None:
        return float(np.cbrt(mu / motion**2))
    if (period_s := keys.get("period_s")) is not None:
        return float(np.cbrt(mu * (period_s / (2.0 * pi)) ** 2))
    sma_km = keys.get("sma_km")
    return sma_km and 1e3 * sma_km


def shape(keys: Keys, constants: ConstantsSet = EARTH) -> tuple[float, float]:
    """Semi-major axis (m) and eccentricity from the two keys that are given."""

    def radius(key: str) -> Any:
        return None if keys.get(key) is None else constants.earth_radius_m + 1e3 * keys[key]

    sma, ecc = semi_major_axis_m(keys, constants), keys.get("ecc")
    perigee, apogee = radius("perigee_height_km"), radius("apogee_height_km")
    if perigee is not None and apogee is not None:
        return 0.5 * (perigee + apogee), (apogee - perigee) / (apogee + perigee)
    if ecc is None:
        assert sma is not None
        return sma, apogee / sma - 1.0 if perigee is None else 1.0 - perigee / sma
    if sma is None:
        sma = apogee / (1.0 + ecc) if perigee is None else perigee / (1.0 - ecc)
    return sma, ecc


def elements_of(keys: Keys, constants: ConstantsSet = EARTH) -> Elements:
    """Osculating elements of a table that gives them; angles that are not given are 0, so is the anomaly."""
    sma, ecc = shape(keys, constants)
    inc, raan, argp = (radians(keys.get(key) or 0.0) for key in ANGLES)
    return Elements(sma, ecc, inc, raan, argp, _true_anomaly_rad(keys, ecc), constants=constants)


def _true_anomaly_rad(keys: Keys, ecc: float) -> float:
    if (mean_deg := keys.get("mean_anomaly_deg")) is not None:
        return true_from_mean(radians(mean_deg), ecc)
    if (eccentric_deg := keys.get("eccentric_anomaly_deg")) is not None:
        return true_from_eccentric(radians(eccentric_deg), ecc)
    if (latitude_deg := keys.get("latitude_argument_deg")) is not None:
        return radians(latitude_deg - (keys.get("argp_deg") or 0.0))
    return radians(keys.get("true_anomaly_deg") or 0.0)
