"""The conditions of a launch and its rendezvous, each with its margin: by equations that planning does not use."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np

from orbsoc.guidance.mission import Check
from orbsoc.guidance.relative_flight import oblate_with_drag, two_body

from ..model.separation import Separation, disagreement
from ..model.transfer import cost_of, in_plane, stationary_minima
from ..scenario import Scenario
from ..search.rendezvous import Rendezvous
from .flights import Flown, corrected, flown

KANE, TWO_BODIES = 1e-12, 1e-9
"""Within which the launch's three ways must agree, SI."""
MISS_M, MISS_M_S = 1e-3, 1e-6
"""Within which the corrected flight must end."""
CHEAPER = 1e-7
"""By which another minimum may be cheaper: what the conic solver leaves, m²/s²."""


@dataclass(frozen=True, slots=True, eq=False)
class Verification:
    """The launch by Kane's equations and by two bodies, the programme about the Earth, and with impulses corrected."""

    by_kane: float
    by_two_bodies: float
    as_planned: Flown
    with_j2_and_drag: Flown
    corrected: Flown
    checks: tuple[Check, ...]

    @property
    def failures(self) -> tuple[str, ...]:
        return tuple(
            f"{each.name} is broken by {-each.margin:.3g} {each.unit}".rstrip()
            for each in self.checks
            if not each.margin >= 0.0
        )


def verify(scenario: Scenario, separation: Separation, found: Rendezvous) -> Verification:
    """Fly launch and rendezvous by equations that planning does not use. Raises PropagationError."""
    by_kane, by_two_bodies = disagreement(separation)
    state, programme, end_s = separation.state, found.programme, found.time_s
    met = corrected(scenario, state, programme, end_s)
    plan, drag = (
        flown(scenario, state, programme, end_s, partial(forces, constants=scenario.constants))
        for forces in (two_body, oblate_with_drag)
    )
    chasers = plan.flight.pairs[:, 1, :3]
    heights = np.linalg.norm(chasers, axis=1) - scenario.constants.earth_radius_m
    low = int(heights.argmin())
    checks: tuple[Check, ...] = (
        Check("Kane's equations agree", KANE - by_kane, "", separation.time_s),
        Check("two bodies with their reaction agree", TWO_BODIES - by_two_bodies, "", separation.time_s),
        Check("two-body rendezvous, corrected: position", MISS_M - met.miss_m, "m", end_s),
        Check("two-body rendezvous, corrected: velocity", MISS_M_S - met.speed_m_s, "m/s", end_s),
        Check("height over the ground", float(heights[low]), "m", float(plan.flight.times_s[low])),
    )
    if found.cost == "squares" and scenario.rendezvous.duration_s == "free":
        plane = in_plane(state)
        times = stationary_minima(scenario.motion, plane, scenario.longest_s)
        least = min(map(cost_of(scenario.motion, plane, "squares"), times), default=found.value)
        checks += (Check("no minimum is cheaper", least - found.value + CHEAPER, "m²/s²", end_s),)
    return Verification(by_kane, by_two_bodies, plan, drag, met, checks)
