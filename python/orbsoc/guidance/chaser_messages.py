"""The flight of a chaser beside a target as CCSDS messages: an ephemeris, and its first state with the manoeuvres."""

from __future__ import annotations

from orbsoc.orbit import EARTH, ConstantsSet
from orbsoc.orbit.relative import local_frame

from .ccsds import InertialManoeuvre, Subject, oem, opm
from .impulses import ImpulseProgramme
from .relative_flight import RelativeFlight


def chaser_messages(
    name: str,
    programme: ImpulseProgramme,
    flown: RelativeFlight,
    *,
    comment: str,
    constants: ConstantsSet = EARTH,
    x_axis: str = "the node of the target's orbit",
) -> dict[str, str]:
    """`chaser.oem` and `chaser.opm` of a programme as it was flown, in the inertial axes of the target's orbit.

    x points to `x_axis`; times count from the first of the flight. An impulse's time has the state before
    it, and its velocity change is turned from the target's (R, T, N) as they are then.
    """
    subject = Subject(f"{name} chaser", x_axis, "the first state")
    burns = []
    for t, dv, (target, _) in zip(programme.times_s, programme.dv_m_s, flown.pairs_after, strict=False):
        x, y, z = (float(each) for each in local_frame(target)[0].T @ dv)
        burns.append(InertialManoeuvre(float(t), (x, y, z)))
    chaser = flown.pairs[:, 1]
    steps = "velocities step at the impulses, whose times have the state before them"
    return {
        "chaser.oem": oem(subject, flown.times_s, chaser, comment=f"{comment}; {steps}"),
        "chaser.opm": opm(subject, float(flown.times_s[0]), chaser[0], manoeuvres=burns, constants=constants),
    }
