"""The chaser's flight as CCSDS messages."""

from __future__ import annotations

import numpy as np

from orbsoc.guidance.chaser_messages import chaser_messages
from orbsoc.guidance.relative_flight import fly, two_body
from orbsoc.orbit import state_from_elements

from .plan import ApproachPlan

STEPS = 120


def messages(plan: ApproachPlan) -> dict[str, str]:
    """`chaser.oem` and `chaser.opm` of a plan, by two-body motion; empty without a programme."""
    programme, approach = plan.programme, plan.approach
    if programme is None:
        return {}
    target = np.concatenate(state_from_elements(approach.orbit()))
    times = np.unique(np.concatenate([np.linspace(0.0, approach.duration_s, STEPS + 1), programme.times_s]))
    flown = fly(programme, approach.start, target, times, two_body)
    return chaser_messages(plan.scenario.name, programme, flown, comment="two-body motion")
