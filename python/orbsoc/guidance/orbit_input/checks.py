"""What an orbit table must not say: no orbit, two orbits, or what no vehicle's state can be."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from orbsoc.guidance.scenario_file import Complaint
from orbsoc.guidance.vehicle import State, state_complaints

from .elements import ANGLES, ANOMALIES, ELEMENTS, SHAPE, SIZES
from .table import FORMS, STATE, Orbit

LEAST_C3 = 1e-6
"""km²/s², from a parabola, which has no semi-major axis."""


def given_keys(orbit: Orbit, keys: Sequence[str]) -> list[str]:
    """Those of the keys that the table gives."""
    return [key for key in keys if getattr(orbit, key) is not None]


def orbit_complaints(key: str, orbit: Orbit, *, beside: Sequence[str] = ()) -> Iterator[Complaint]:
    """Of a table that must give an orbit and a place on it; `beside` names keys of the shape that may stand by a state."""
    yield from frame_complaints(key, orbit)
    states = given_keys(orbit, STATE)
    if states:
        yield from beside_a_state(key, orbit, states, beside)
        return
    if not given_keys(orbit, ELEMENTS):
        yield Complaint(key, "", f"is missing what names an orbit; must be {FORMS}")
        return
    yield from shape_count_complaints(key, orbit)
    for each in ANGLES:
        if getattr(orbit, each) is None and not (each == "argp_deg" and orbit.ecc == 0.0):
            allowed = f"is missing; an orbit by elements needs it; or give {FORMS}"
            yield Complaint(f"{key}.{each}", "", allowed)
    anomalies = given_keys(orbit, ANOMALIES)
    if len(anomalies) != 1:
        allowed = f"must be one of {', '.join(ANOMALIES)}"
        yield Complaint(key, ", ".join(anomalies) or "no anomaly", allowed)
    yield from shape_complaints(key, orbit)


def vehicle_complaints(key: str, orbit: Orbit) -> Iterator[Complaint]:
    """Of a table that is the state of a vehicle above the ground."""
    yield from orbit_complaints(key, orbit)
    if orbit.position_m is not None and orbit.velocity_m_s is not None:
        state = State(position_m=orbit.position_m, velocity_m_s=orbit.velocity_m_s)
        yield from state_complaints(key, state, orbit._about)
        return
    radius = float(np.linalg.norm(orbit.vector()[:3]))
    if radius < orbit._about.earth_radius_m:
        allowed = f"lies below the ground; must be at least {orbit._about.earth_radius_m / 1e3:.3f}"
        yield Complaint(key, f"{radius / 1e3:.6g} km from the centre", allowed)


def frame_complaints(key: str, orbit: Orbit) -> Iterator[Complaint]:
    """TEME turns with the date."""
    if orbit.frame == "TEME" and not orbit.dated:
        yield Complaint(f"{key}.epoch_utc", "", "is missing; frame = 'TEME' are axes of a date, and needs it")


def beside_a_state(
    key: str, orbit: Orbit, states: Sequence[str], beside: Sequence[str] = ()
) -> Iterator[Complaint]:
    """Half a state, or elements beside one."""
    extra = [each for each in given_keys(orbit, ELEMENTS) if each not in beside]
    if extra:
        allowed = "there is a state already; must be one of the two"
        yield Complaint(f"{key}.{extra[0]}", f"{getattr(orbit, extra[0])}", allowed)
    for each in STATE:
        if each not in states:
            yield Complaint(f"{key}.{each}", "", f"is missing, and {key}.{states[0]} needs it")


def shape_count_complaints(key: str, orbit: Orbit) -> Iterator[Complaint]:
    """Not two numbers of the shape, or two that say the same."""
    found = given_keys(orbit, SHAPE)
    if len(found) != 2 or len(set(SIZES) & set(found)) > 1:
        allowed = f"must be two of {', '.join(SHAPE)}, and only one of those that give the energy"
        yield Complaint(key, f"{', '.join(found) or 'no shape'}", allowed)


def parabola_complaints(key: str, orbit: Orbit) -> Iterator[Complaint]:
    """A C3 of a parabola."""
    if orbit.c3_km2_s2 is not None and abs(orbit.c3_km2_s2) < LEAST_C3:
        allowed = f"a parabola; must be {LEAST_C3:g} or more from 0"
        yield Complaint(f"{key}.c3_km2_s2", f"{orbit.c3_km2_s2:g}", allowed)


def shape_complaints(key: str, orbit: Orbit) -> Iterator[Complaint]:
    """Numbers that no orbit has."""
    yield from parabola_complaints(key, orbit)
    try:
        orbit.vector()
    except (ValueError, ZeroDivisionError) as error:
        yield Complaint(key, "its elements", f"name no orbit: {error}")
        return
    sma, ecc = orbit.shape()
    if sma * (1.0 - ecc) <= 0.0 or ecc < 0.0:
        allowed = "name no orbit; must have e ≥ 0 and a perigee above 0"
        yield Complaint(key, f"a = {sma / 1e3:g} km, e = {ecc:g}", allowed)
