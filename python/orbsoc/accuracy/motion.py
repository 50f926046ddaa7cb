"""Orbital mechanics against worked examples that are in print."""

from __future__ import annotations

from collections.abc import Iterator
from datetime import UTC, datetime

import numpy as np

from orbsoc.orbit import elements_from_state
from orbsoc.orbit.reference_frames import frame_rotation
from orbsoc.orbit.relative.clohessy_wiltshire import ClohessyWiltshire

from .number import Number

VALLADO = "Vallado, Fundamentals of Astrodynamics and Applications, 4th ed., example 2-5"
TUDAT = "Vallado's HILLSR, as Tudat's test of Clohessy and Wiltshire's motion prints it"
REPORT = "Vallado et al., AIAA 2006-6753, appendix C"


def numbers() -> Iterator[Number]:
    """Elements of a state, a relative motion, and a state in two frames."""
    orbit = elements_from_state(
        np.array([6524.834e3, 6862.875e3, 6448.296e3]), np.array([4901.327, 5533.756, -1976.341])
    )
    yield Number("elements of a state: semi-major axis", VALLADO, "36127.343", orbit.sma_m / 1e3, 0.05, "km",
                 "the state is printed to 1 m and 1 mm/s")  # fmt: skip
    yield Number("elements of a state: eccentricity", VALLADO, "0.832853", orbit.ecc, 1e-6)
    angles = {"inclination": orbit.inc_rad, "node": orbit.raan_rad, "argument of perigee": orbit.argp_rad, "true anomaly": orbit.true_anomaly_rad}  # fmt: skip
    for (name, angle), printed in zip(angles.items(), ("87.870", "227.898", "53.38", "92.335"), strict=True):
        yield Number(f"elements of a state: {name}", VALLADO, printed, float(np.rad2deg(angle)), 6e-3, "deg")
    motion = ClohessyWiltshire(np.sqrt(3.986004418e14 / 6.778137e6**3))
    found = motion.transition(1800.0, 0.0) @ [45.0, 37.0, 12.0, 0.08, 0.03, 0.01]
    printed_state = ("380.6450080201250", "-543.7424675454679", "2.509547637285142", "0.1541620605755606", "-0.7294751390499470", "-0.01662099488431618")  # fmt: skip
    for name, printed, ours in zip(("x", "y", "z", "vx", "vy", "vz"), printed_state, found, strict=True):
        unit = "m/s" if name.startswith("v") else "m"
        yield Number(
            f"relative motion after 1800 s: {name}",
            TUDAT,
            printed,
            float(ours),
            1e-12 * abs(float(printed)),
            unit,
        )
    at = datetime(2004, 4, 6, 7, 51, 28, 386009, tzinfo=UTC)
    gcrf = frame_rotation("TEME", at, "GCRF") @ np.array([5094.18016210, 6127.64465950, 6380.34453270])
    for name, printed, ours in zip("xyz", ("5102.508959", "6123.011403", "6378.136925"), gcrf, strict=True):
        yield Number(
            f"TEME to GCRF: {name}", REPORT, printed, float(ours), 2e-6, "km", "the page prints 1 mm"
        )
