"""One point's trajectory as CCSDS messages: an ephemeris of the burn (OEM) and the orbit reached (OPM), from ignition."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from orbsoc.guidance import ccsds
from orbsoc.guidance.ccsds import Subject
from orbsoc.orbit.array import Array

from ..search.continuation.boundary import inside_box
from ..search.continuation.table import PointStatus
from ..search.query.envelope import is_paper_case
from ..search.query.results import ReachableDomain

NODES_FROM = "the zero of its nodes"
NODES_FROM_GREENWICH = "the meridian of Greenwich at launch"
"""Where the x axis points, of any scenario and of the paper's case."""


@dataclass(frozen=True, slots=True, eq=False)
class FlownPoint:
    """A reached point flown by DOP853: times (K,) in s, states (K, 6) in ECI, SI, and the mass at cut-off."""

    subject: Subject
    times_s: Array
    states: Array
    mass_kg: float


def fly_point(
    domain: ReachableDomain, inc_deg: float, raan_deg: float, perigee_km: float, step_s: float = 10.0
) -> FlownPoint:
    """Fly the attitude programme of a grid point. Raises ValueError when the point is not in the table, or not reached."""
    points = domain.points
    near = np.abs(points["inc_deg"] - inc_deg) < 1e-6
    near &= np.abs(np.mod(points["raan_deg"] - raan_deg + 180.0, 360.0) - 180.0) < 1e-6
    near &= np.abs(points["perigee_bound_km"] - perigee_km) < 1e-6
    rows = np.flatnonzero(near)
    where = f"point ({inc_deg:g} deg, {raan_deg:g} deg, {perigee_km:g} km)"
    if not rows.size:
        inside = bool(inside_box(domain.domain, np.array([inc_deg]), np.array([raan_deg]))[0])
        raise ValueError(f"{where} is {'not on the grid' if inside else PointStatus.OUTSIDE.value}")
    row = int(rows[0])
    if points["commands"][row] is None:
        raise ValueError(
            f"{where}: {points['status'][row]}, so there is nothing to fly: {points['evidence'][row]}"
        )
    vectors = points["commands"][row].reshape(-1, 3)
    scenario, duration_s = domain.scenario, domain.scenario.burn.duration_s
    times_s = np.append(np.arange(0.0, duration_s - 1e-9, step_s), duration_s)
    states = scenario.flown(vectors, times_s)
    name = f"{scenario.name} {inc_deg:g} {raan_deg:g} {perigee_km:g}"
    x_axis = NODES_FROM_GREENWICH if is_paper_case(scenario) else NODES_FROM
    left_kg = scenario.vehicle.mass_kg - scenario.vehicle.mass_flow_kg_s * duration_s
    return FlownPoint(Subject(name, x_axis, "ignition"), times_s, states, left_kg)


def oem(flown: FlownPoint) -> str:
    """The burn as an Orbit Ephemeris Message."""
    comment = "powered arc; constant thrust, no interpolation is implied across cut-off"
    return ccsds.oem(flown.subject, flown.times_s, flown.states, comment=comment)


def opm(flown: FlownPoint) -> str:
    """The state and elements at cut-off as an Orbit Parameter Message."""
    return ccsds.opm(flown.subject, float(flown.times_s[-1]), flown.states[-1], mass_kg=flown.mass_kg)
