"""Trajectories and states as CCSDS messages: ephemeris (OEM) and parameters with manoeuvres (OPM), key = value.

Source of the formats: CCSDS 502.0-B-3, Orbit Data Messages. Times count from an epoch, UTC.

A scenario with a date and a frame gives messages with both. One without names neither a date nor where its x axis points among
the stars, so its axes are none of the registered frames: the messages call them SCENARIO_ECI and say in comments what is known
of them. A reader who knows the sidereal angle of that x axis turns states and nodes by it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta

import numpy as np
from numpy.typing import ArrayLike

from orbsoc.orbit import EARTH, ConstantsSet, elements_from_state

ORIGINATOR = "ORBSOC"
DEFAULT_EPOCH = datetime(2025, 1, 1, tzinfo=UTC)
"""Stands for the date that a scenario does not give; the messages say so."""
FRAME = "SCENARIO_ECI"
"""Of REF_FRAME: a name that no registry has, so that no reader takes the axes for others."""


@dataclass(frozen=True, slots=True)
class Subject:
    """The object, where the x axis of its axes points, what times count from, the epoch of that, and the frame."""

    name: str
    x_axis: str
    zero: str
    epoch: datetime = DEFAULT_EPOCH
    frame: str = FRAME
    """A name that is registered, or `FRAME`."""
    center: str = "EARTH"


@dataclass(frozen=True, slots=True)
class InertialManoeuvre:
    """A velocity change (3,), m/s, in the axes of the message: at once, or over a duration from `time_s` on, and the mass it takes."""

    time_s: float
    dv_m_s: tuple[float, float, float]
    duration_s: float = 0.0
    delta_mass_kg: float = 0.0
    """Not above 0; 0 where it is not modelled."""


def oem(subject: Subject, times_s: ArrayLike, states: ArrayLike, *, comment: str) -> str:
    """States (K, 6), ECI, SI, at times (K,) as an Orbit Ephemeris Message; the lines of `comment` stand before them."""
    times = np.asarray(times_s, np.float64)
    start, stop = _stamp(subject.epoch, float(times[0])), _stamp(subject.epoch, float(times[-1]))
    lines = [*_header("CCSDS_OEM_VERS = 3.0", subject), "", "META_START", *_object(subject)]
    lines += [f"START_TIME = {start}", f"STOP_TIME = {stop}", "META_STOP", ""]
    lines += [f"COMMENT {each}" for each in comment.splitlines()]
    for time_s, state in zip(times, np.asarray(states, np.float64) / 1e3, strict=True):
        numbers = " ".join(f"{value:.9f}" for value in state)
        lines.append(f"{_stamp(subject.epoch, float(time_s))} {numbers}")
    return "\n".join(lines) + "\n"


def opm(
    subject: Subject,
    time_s: float,
    state: ArrayLike,
    *,
    mass_kg: float | None = None,
    manoeuvres: Sequence[InertialManoeuvre] = (),
    constants: ConstantsSet = EARTH,
    comment: str = "",
) -> str:
    """A state (6,), ECI, SI, and its elements as an Orbit Parameter Message, with the manoeuvres that follow.

    The lines of `comment` stand before the state.
    """
    vector = np.asarray(state, np.float64)
    orbit = elements_from_state(vector[:3], vector[3:], constants)
    lines = [*_header("CCSDS_OPM_VERS = 3.0", subject), *_object(subject)]
    lines += [f"COMMENT {each}" for each in comment.splitlines()]
    lines.append(f"EPOCH = {_stamp(subject.epoch, time_s)}")
    for key, value in zip(("X", "Y", "Z", "X_DOT", "Y_DOT", "Z_DOT"), vector / 1e3, strict=True):
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
        f"GM = {constants.mu_m3_s2 / 1e9:.7f} [km**3/s**2]",
    ]
    if mass_kg is not None:
        lines.append(f"MASS = {mass_kg:.6f} [kg]")
    for each in manoeuvres:
        if not each.delta_mass_kg:
            lines.append("COMMENT an impulse; the mass it takes is not modelled")
        lines += [
            f"MAN_EPOCH_IGNITION = {_stamp(subject.epoch, each.time_s)}",
            f"MAN_DURATION = {each.duration_s!r} [s]",
            f"MAN_DELTA_MASS = {each.delta_mass_kg!r} [kg]",
            f"MAN_REF_FRAME = {subject.frame}",
            *(f"MAN_DV_{k} = {value / 1e3:.12f} [km/s]" for k, value in enumerate(each.dv_m_s, 1)),
        ]
    return "\n".join(lines) + "\n"


def _header(version: str, subject: Subject) -> list[str]:
    named, comments = subject.frame != FRAME, list[str]()
    if not named:
        comments = [
            f"{FRAME}: the inertial axes of the scenario, centred on the body, z along the pole, x towards",
            f"{subject.x_axis}. It is not EME2000 nor any registered frame:",
            "the scenario does not say where that x axis points among the stars.",
        ]
    if subject.epoch == DEFAULT_EPOCH:
        end = "." if named else ", and the epoch only stands for one."
        comments.append(f"Times count from {subject.zero}; the scenario gives no date{end}")
    created = f"CREATION_DATE = {_stamp(subject.epoch, 0.0)}"
    return [version, *(f"COMMENT {each}" for each in comments), created, f"ORIGINATOR = {ORIGINATOR}"]


def _object(subject: Subject) -> list[str]:
    return [
        f"OBJECT_NAME = {subject.name}",
        "OBJECT_ID = UNKNOWN",
        f"CENTER_NAME = {subject.center}",
        f"REF_FRAME = {subject.frame}",
        "TIME_SYSTEM = UTC",
    ]


def _stamp(epoch: datetime, seconds: float) -> str:
    return (epoch + timedelta(seconds=seconds)).astimezone(UTC).strftime("%Y-%m-%dT%H:%M:%S.%f")
