"""What happens without the pulses to come: the engine stops after a pulse, or within it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from orbsoc.guidance.safety import CutBurn, audit_cut_burns, drift_clearance, states_after

from .model.flight import Flown
from .scenario import Scenario

ORBITS = 2.0
"""For so long after the last pulse, the time in which an engine is repaired or the operator acts."""


@dataclass(frozen=True, slots=True)
class EngineOut:
    """Pulses stop after pulse `number`, counted from 1: how near the target the drift comes, m, and how long after, s."""

    number: int
    time_s: float
    distance_m: float
    after_s: float
    all_time_m: float
    """For all time, by the linear model."""

    def to_dict(self) -> dict[str, Any]:
        return {name: getattr(self, name) for name in self.__dataclass_fields__}


def inner_radius_m(scenario: Scenario) -> float:
    """The least distance from the target that the tube allows."""
    return min(scenario.ellipse.semi_axes_m) - scenario.tolerance_m


def engine_out(scenario: Scenario, flown: Flown) -> tuple[EngineOut, ...]:
    """Each pulse as the last, by the linear model without the disturbance."""
    motion, programme = scenario.motion, flown.programme
    states = states_after(programme, flown.before[0], motion, float(programme.times_s[0]))
    soon = drift_clearance(states, motion.mean_motion_rad_s, ORBITS * motion.period_s)
    ever = drift_clearance(states, motion.mean_motion_rad_s)
    rows = zip(programme.times_s, soon.distance_m, soon.at_s, ever.distance_m, strict=True)
    return tuple(EngineOut(k, *(float(each) for each in row)) for k, row in enumerate(rows, 1))


def cut_burns(scenario: Scenario, flown: Flown) -> tuple[CutBurn, ...]:
    """Each pulse cut at every fraction of itself, and none after it."""
    motion, programme = scenario.motion, flown.programme
    return audit_cut_burns(
        programme,
        np.asarray(flown.before[0]),
        motion,
        inner_radius_m(scenario),
        mean_motion_rad_s=motion.mean_motion_rad_s,
        orbits=ORBITS,
        start_s=float(programme.times_s[0]),
    )
