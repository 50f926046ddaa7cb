"""The flight of a chaser beside a target as CCSDS messages: an ephemeris, and its first state with the manoeuvres."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import timedelta

import numpy as np

from orbsoc.orbit import EARTH, ConstantsSet, Elements, rotate_state, state_from_elements
from orbsoc.orbit.array import Array
from orbsoc.orbit.reference_frames import frame_rotation
from orbsoc.orbit.relative import local_frame

from .ccsds import InertialManoeuvre, Subject, oem, opm
from .impulses import ImpulseProgramme
from .orbit_input.catalogue import parse_utc
from .relative_flight import RelativeFlight, fly, two_body


def chaser_messages(
    name: str,
    programme: ImpulseProgramme,
    flown: RelativeFlight,
    *,
    comment: str,
    constants: ConstantsSet = EARTH,
    x_axis: str = "the node of the target's orbit",
    epoch_utc: str | None = None,
    assumptions: Sequence[str] = (),
) -> dict[str, str]:
    """`chaser.oem` and `chaser.opm` of a programme as it was flown, in the inertial axes of the target's orbit.

    x points to `x_axis`; times count from the first of the flight. An impulse's time has the state before
    it, and its velocity change is turned from the target's (R, T, N) as they are then.
    With `epoch_utc` the first time has that date, the flight's axes are TEME at it, and the messages are in EME2000.
    Each of `assumptions` is a comment of both.
    """
    subject = Subject(f"{name} chaser", x_axis, "the first state")
    turn = np.eye(3)
    if epoch_utc is not None:
        date = parse_utc(epoch_utc)
        zero = date - timedelta(seconds=float(flown.times_s[0]))
        subject = Subject(subject.name, x_axis, "the first state", zero, "EME2000")
        turn = frame_rotation("TEME", date, "EME2000")
    burns = []
    for t, dv, (target, _) in zip(programme.times_s, programme.dv_m_s, flown.pairs_after, strict=False):
        x, y, z = (float(each) for each in turn @ local_frame(target)[0].T @ dv)
        burns.append(InertialManoeuvre(float(t), (x, y, z)))
    chaser = rotate_state(turn, flown.pairs[:, 1])
    steps = "velocities step at the impulses, whose times have the state before them"
    return {
        "chaser.oem": oem(subject, flown.times_s, chaser, comment="\n".join((f"{comment}; {steps}", *assumptions))),
        "chaser.opm": opm(
            subject, float(flown.times_s[0]), chaser[0], manoeuvres=burns, constants=constants,
            comment="\n".join(assumptions),
        ),
    }  # fmt: skip


def two_body_messages(
    name: str,
    programme: ImpulseProgramme | None,
    start: Array,
    target: Elements,
    *,
    duration_s: float,
    steps: int,
    epoch_utc: str | None,
) -> dict[str, str]:
    """The same of a programme flown by two-body motion from `start` (6,) in (R, T, N), m and m/s; empty without a programme."""
    if programme is None:
        return {}
    inertial = np.concatenate(state_from_elements(target))
    times = np.unique(np.concatenate([np.linspace(0.0, duration_s, steps + 1), programme.times_s]))
    flown = fly(programme, start, inertial, times, two_body)
    return chaser_messages(name, programme, flown, comment="two-body motion", epoch_utc=epoch_utc)
