"""A target by any form of the orbit table, and a chaser beside it: in axes of the target that are named, or on its own orbit."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from datetime import datetime
from math import degrees
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from orbsoc.guidance.scenario_file import ScenarioError, T, Table, checked, refuse, refused
from orbsoc.guidance.vehicle import Vector
from orbsoc.orbit import EARTH, Elements, elements_from_state
from orbsoc.orbit.array import Array
from orbsoc.orbit.relative import LVLH, relative_state

from .checks import vehicle_complaints
from .table import Orbit

AXES = ("RTN", "LVLH")
DATED = ("epoch_utc", "frame", "source")
"""Keys beside the mission's own once a table with a date is read."""
CIRCULAR = 1e-12
"""An eccentricity below it is rounding."""
ROUND = 2e-3
"""Eccentricity up to which a target's orbit is taken for the circle of its semi-major axis: 3 e is below a percent too."""

_LEFT_OUT = "eccentricity of the target that the circle leaves out; written when it is read"
LeftOut = Annotated[float | None, Field(ge=0.0, le=ROUND, description=_LEFT_OUT)]
"""Of a key `ecc_left_out` of a mission that counts about a circular orbit."""


class NamedAxes(Table):
    """A state beside the target. RTN: outward, along the motion, along the angular momentum. LVLH: along the motion,
    against the angular momentum, to the nadir. Both turn with the target."""

    frame: Literal["RTN", "LVLH"]
    position_m: Vector
    velocity_m_s: Vector = (0.0, 0.0, 0.0)


def read_table(name: str, kind: type[T], table: Mapping[str, Any]) -> T:
    """A table of a scenario by itself, checked inside a validator of the whole."""
    from pydantic import create_model

    holder = create_model(name, **{name: (kind, ...)})  # type: ignore[call-overload]
    try:
        return getattr(checked(holder, {name: dict(table)}, source=name), name)  # type: ignore[no-any-return]
    except ScenarioError as error:
        first = error.complaints[0]
        raise refused(first.key, first.value, first.allowed) from error


def named_orbit(name: str, table: Mapping[str, Any], own: Sequence[str]) -> Orbit | None:
    """The orbit that a table names by keys other than the mission's `own`; None where there are none."""
    given = {key: value for key, value in table.items() if value is not None}
    others = [key for key in given if key in Orbit.model_fields and key not in (*own, *DATED)]
    if not others:
        if "epoch_utc" in given and given.get("frame") != "TEME":
            allowed = "with a date must be 'TEME', or the orbit by state, all elements, tle, omm or oem"
            raise refused(f"{name}.frame", repr(given.get("frame")), allowed)
        if "epoch_utc" not in given and "frame" in given:
            raise refused(f"{name}.epoch_utc", "nothing", "is missing; frame needs a date")
        return None
    found = read_table(name, Orbit, given)
    refuse(vehicle_complaints(name, found))
    return found


def polar_elements(name: str, orbit: Orbit) -> Elements:
    """Osculating elements about the Earth's pole: TEME at its own date where it has one. Refuses an escape.

    Of a circular orbit the place counts from the node, and the argument of perigee is 0.
    """
    state = orbit.vector_in("TEME" if orbit.dated else None, orbit.epoch)
    found = elements_from_state(state[:3], state[3:])
    if found.ecc >= 1.0:
        raise refused(name, f"e = {found.ecc:g}", "a target on no closed orbit; must be e < 1")
    if found.ecc >= CIRCULAR:
        return found
    place = float((found.argp_rad + found.true_anomaly_rad) % (2.0 * np.pi))
    return Elements(found.sma_m, 0.0, found.inc_rad, found.raan_rad, 0.0, place)


def circle_keys(name: str, orbit: Orbit) -> dict[str, Any]:
    """Keys of a circular orbit in place of an orbit that is nearly one: its semi-major axis, plane, and place from the node.

    `ecc_left_out` is its eccentricity, None where it is 0. Refuses one above `ROUND`.
    """
    at = polar_elements(name, orbit)
    if at.ecc > ROUND:
        allowed = f"the motion is that about a circular orbit; must be at most {ROUND:g}"
        raise refused(name, f"e = {at.ecc:.6g}", allowed)
    return {
        "altitude_km": height_km(at),
        "inc_deg": degrees(at.inc_rad),
        "raan_deg": degrees(at.raan_rad),
        "latitude_argument_deg": degrees((at.argp_rad + at.true_anomaly_rad) % (2.0 * np.pi)),
        "ecc_left_out": at.ecc or None,
        **dated_keys(orbit),
    }


def circle_words(altitude_km: float, ecc_left_out: float | None) -> list[str]:
    """What `circle_keys` left out, and how far from the circle the target may be; empty where nothing was.

    From the same place at time 0 they part by a e cos M outward and 2 a e (sin M - sin M0) along: by at most 4 a e.
    """
    if not ecc_left_out:
        return []
    away_km = 4.0 * ecc_left_out * (EARTH.earth_radius_m / 1e3 + altitude_km)
    return [
        f"the target's eccentricity {ecc_left_out:.6g} is left out, its orbit is the circle of its semi-major axis;"
        f" by two-body motion the target may be 4 a e = {away_km:.3g} km away"
    ]


def dated_keys(orbit: Orbit) -> dict[str, Any]:
    """Date, frame and source that stand by the mission's own keys of a target; none without a date."""
    if orbit.epoch is None:
        return {}
    return {"epoch_utc": orbit.epoch.isoformat(), "frame": "TEME", "source": orbit.source}


def named_axes(name: str, table: Mapping[str, Any]) -> Array:
    """A state (6,) in (R, T, N) from a table in named axes."""
    found = read_table(name, NamedAxes, {key: value for key, value in table.items() if value is not None})
    rows = np.array([found.position_m, found.velocity_m_s])
    return np.asarray(rows if found.frame == "RTN" else rows @ LVLH).reshape(-1)


def start_beside(
    name: str, table: Mapping[str, Any], own: Sequence[str], target: Array, date: datetime | None
) -> Array | None:
    """A chaser's state (6,) in (R, T, N) beside a target's state (6,), if its table does not use the mission's `own` keys.

    `target` is inertial, in TEME at `date` where there is one.
    """
    given = {key: value for key, value in table.items() if value is not None}
    if given.get("frame") in AXES:
        return named_axes(name, given)
    orbit = named_orbit(name, given, own)
    if orbit is None:
        return None
    if orbit.epoch != date:
        there = "none" if date is None else date.isoformat()
        allowed = f"must be the target's date, {there}; or give position_m with frame = 'RTN' or 'LVLH'"
        raise refused(f"{name}.epoch_utc", str(orbit.epoch_utc), allowed)
    return np.asarray(relative_state(target, orbit.vector_in("TEME" if date else None, date)))


def height_km(elements: Elements, radius_m: float = EARTH.earth_radius_m) -> float:
    """Of the semi-major axis over a radius."""
    return (elements.sma_m - radius_m) / 1e3
