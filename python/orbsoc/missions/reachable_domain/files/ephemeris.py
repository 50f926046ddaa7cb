"""One point's trajectory as CCSDS messages: an ephemeris of the burn (OEM) and the orbit reached (OPM), key = value.

Source of the formats: CCSDS 502.0-B-3, Orbit Data Messages. Times count from ignition at a given epoch, UTC.

A scenario names neither a date nor where its x axis points among the stars, so its axes are none of the registered frames:
the messages call them SCENARIO_ECI and say in comments what is known of them. A reader who knows the sidereal angle of that
x axis turns states and nodes by it.
"""

from __future__ import annotations

from dataclasses import dataclass
from datetime import UTC, datetime, timedelta

import numpy as np
from numpy.typing import NDArray

from orbsoc.guidance.collocation import legendre_gauss
from orbsoc.guidance.powered_flight import commanded
from orbsoc.orbit import EARTH, elements_from_state, propagate_burn

from ..continuation.boundary import inside_box
from ..continuation.table import PointStatus
from ..query.envelope import is_paper_case
from ..query.results import ReachableDomain

Array = NDArray[np.float64]

ORIGINATOR = "ORBSOC"
DEFAULT_EPOCH = datetime(2025, 1, 1, tzinfo=UTC)
"""Stands for the date that a scenario does not give; the messages say so."""
FRAME = "SCENARIO_ECI"
"""Of REF_FRAME: a name that no registry has, so that no reader takes the axes for others."""
NODES_FROM = "the zero of its nodes"
NODES_FROM_GREENWICH = "the meridian of Greenwich at launch"
"""Where the x axis points, of any scenario and of the paper's case."""


@dataclass(frozen=True, slots=True, eq=False)
class FlownPoint:
    """A reached point flown by DOP853: times (K,) in s, states (K, 6) in ECI, SI, the propellant spent in kg, and what the
    x axis of these ECI axes points to."""

    name: str
    x_axis: str
    times_s: Array
    states: Array
    propellant_kg: float


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

    steering = commanded(legendre_gauss(len(vectors)), vectors, duration_s)
    states = propagate_burn(scenario.initial_eci(), scenario.vehicle.thruster(), steering, times_s)
    name = f"{scenario.name} {inc_deg:g} {raan_deg:g} {perigee_km:g}"
    x_axis = NODES_FROM_GREENWICH if is_paper_case(scenario) else NODES_FROM
    return FlownPoint(name, x_axis, times_s, states, scenario.vehicle.mass_flow_kg_s * duration_s)


def oem(flown: FlownPoint, epoch: datetime = DEFAULT_EPOCH) -> str:
    """The burn as an Orbit Ephemeris Message."""
    start, stop = _stamp(epoch, 0.0), _stamp(epoch, float(flown.times_s[-1]))
    lines = [*_header("CCSDS_OEM_VERS = 3.0", flown, epoch), "", "META_START", *_object(flown.name)]
    lines += [f"START_TIME = {start}", f"STOP_TIME = {stop}", "META_STOP", ""]
    lines += ["COMMENT powered arc; constant thrust, no interpolation is implied across cut-off"]
    for time_s, state in zip(flown.times_s, flown.states / 1e3, strict=True):
        numbers = " ".join(f"{value:.9f}" for value in state)
        lines.append(f"{_stamp(epoch, float(time_s))} {numbers}")
    return "\n".join(lines) + "\n"


def opm(flown: FlownPoint, mass_kg: float, epoch: datetime = DEFAULT_EPOCH) -> str:
    """The state and elements at cut-off as an Orbit Parameter Message; `mass_kg` is the mass at ignition."""
    state = flown.states[-1]
    orbit = elements_from_state(state[:3], state[3:])
    lines = [*_header("CCSDS_OPM_VERS = 3.0", flown, epoch), *_object(flown.name)]
    lines.append(f"EPOCH = {_stamp(epoch, float(flown.times_s[-1]))}")
    for key, value in zip(("X", "Y", "Z", "X_DOT", "Y_DOT", "Z_DOT"), state / 1e3, strict=True):
        lines.append(f"{key} = {value:.9f} [{'km/s' if key.endswith('DOT') else 'km'}]")
    angles = (orbit.inc_rad, orbit.raan_rad, orbit.argp_rad, orbit.true_anomaly_rad)
    inc, raan, argp, anomaly = (float(np.rad2deg(angle)) for angle in angles)
    lines += [
        f"SEMI_MAJOR_AXIS = {orbit.sma_m / 1e3:.9f} [km]",
        f"ECCENTRICITY = {orbit.ecc:.12f}",
        f"INCLINATION = {inc:.10f} [deg]",
        f"RA_OF_ASC_NODE = {raan:.10f} [deg]",
        f"ARG_OF_PERICENTER = {argp:.10f} [deg]",
        f"TRUE_ANOMALY = {anomaly:.10f} [deg]",
        f"GM = {EARTH.mu_m3_s2 / 1e9:.7f} [km**3/s**2]",
        f"MASS = {mass_kg - flown.propellant_kg:.6f} [kg]",
    ]
    return "\n".join(lines) + "\n"


def _header(version: str, flown: FlownPoint, epoch: datetime) -> list[str]:
    lines = [
        version,
        f"COMMENT {FRAME}: the Earth-centred inertial axes of the scenario, z along the pole, x towards",
        f"COMMENT {flown.x_axis}. It is not EME2000 nor any registered frame:",
        "COMMENT the scenario does not say where that x axis points among the stars.",
    ]
    if epoch == DEFAULT_EPOCH:
        lines += [
            "COMMENT Times count from ignition; the scenario gives no date, and the epoch only stands for one."
        ]
    return [*lines, f"CREATION_DATE = {_stamp(epoch, 0.0)}", f"ORIGINATOR = {ORIGINATOR}"]


def _object(name: str) -> list[str]:
    return [
        f"OBJECT_NAME = {name}",
        "OBJECT_ID = UNKNOWN",
        "CENTER_NAME = EARTH",
        f"REF_FRAME = {FRAME}",
        "TIME_SYSTEM = UTC",
    ]


def _stamp(epoch: datetime, seconds: float) -> str:
    return (epoch + timedelta(seconds=seconds)).astimezone(UTC).strftime("%Y-%m-%dT%H:%M:%S.%f")
