"""The chaser's flight as CCSDS messages."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from orbsoc.guidance.ccsds import InertialManoeuvre, Subject, oem, opm
from orbsoc.guidance.impulses import ImpulseProgramme
from orbsoc.guidance.orbit_input.catalogue import parse_utc
from orbsoc.orbit import rotate_state
from orbsoc.orbit.reference_frames import frame_rotation

from ..scenario import Scenario, zero_utc
from ..verification.flight import Flight


def messages(scenario: Scenario, programme: ImpulseProgramme, flight: Flight) -> dict[str, str]:
    """`chaser.oem` and `chaser.opm`; times count from the scenario's zero, an impulse's has the state before it."""
    subject = Subject(
        f"{scenario.name} chaser", "the direction from which the scenario counts nodes", "the scenario's zero"
    )
    about = scenario.constants
    subject = replace(subject, center=about.center)
    turn, date = np.eye(3), scenario.chaser.epoch_utc
    if date is not None:
        zero = zero_utc(date, scenario.chaser.epoch_s)
        subject = Subject(subject.name, subject.x_axis, subject.zero, zero, "EME2000")
        turn = frame_rotation("TEME", parse_utc(date), "EME2000")
    chaser = rotate_state(turn, flight.chaser)
    burns = []
    for t, dv in zip(programme.times_s, flight.dv_m_s, strict=False):
        x, y, z = map(float, turn @ dv)
        burns.append(InertialManoeuvre(float(t), (x, y, z)))
    forces = " and ".join({"j2": "J2", "drag": "drag"}[each] for each in scenario.forces) or "two-body motion"
    comment = f"{forces}; velocities step at the impulses, whose times have the state before them"
    return {
        "chaser.oem": oem(subject, flight.times_s, chaser, comment=comment),
        "chaser.opm": opm(subject, float(flight.times_s[0]), chaser[0], manoeuvres=burns, constants=about),
    }
