"""The chaser's flight as CCSDS messages: an ephemeris, and its first state with the manoeuvres."""

from __future__ import annotations

import numpy as np

from orbsoc.guidance.ccsds import InertialManoeuvre, Subject, oem, opm
from orbsoc.guidance.relative_flight import fly, two_body
from orbsoc.orbit import state_from_elements
from orbsoc.orbit.relative import local_frame

from .approach_plan import ApproachPlan

STEPS = 120


def messages(plan: ApproachPlan) -> dict[str, str]:
    """`chaser.oem` and `chaser.opm` of a plan, by two-body motion in the inertial axes of the target's orbit."""
    programme, approach = plan.programme, plan.approach
    if programme is None:
        return {}
    target = np.concatenate(state_from_elements(approach.orbit()))
    times = np.unique(np.concatenate([np.linspace(0.0, approach.duration_s, STEPS + 1), programme.times_s]))
    flown = fly(programme, approach.start, target, times, two_body)
    subject = Subject(f"{plan.scenario.name} chaser", "the node of the target's orbit", "the first impulse")
    burns = []
    for t, dv, (body, _) in zip(programme.times_s, programme.dv_m_s, flown.pairs_after, strict=False):
        x, y, z = (float(each) for each in local_frame(body)[0].T @ dv)
        burns.append(InertialManoeuvre(float(t), (x, y, z)))
    comment = "two-body motion; velocities step at the impulses, whose times have the state before them"
    chaser = flown.pairs[:, 1]
    return {
        "chaser.oem": oem(subject, times, chaser, comment=comment),
        "chaser.opm": opm(subject, 0.0, chaser[0], manoeuvres=burns),
    }
