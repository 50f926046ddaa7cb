"""The approach flown in a closed loop: re-planned before every impulse but the first, safe after each of them if no other follows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from orbsoc.guidance.closed_loop import ON_TARGET, Answer, FlownCycles, Sensed, Trigger
from orbsoc.guidance.impulses import ImpulseProgramme
from orbsoc.guidance.impulsive_flight import Chaser, Impulses, LeadTimes
from orbsoc.guidance.safety import drift_clearance
from orbsoc.guidance.scp import Solve
from orbsoc.guidance.setting_out import given_errors, programme_of
from orbsoc.guidance.verdict import Question, VerdictLine, Word
from orbsoc.orbit import state_from_elements

from .dispersion import disperse, replanned
from .model.approach import Approach
from .planner import plan_unflown
from .scenario import Scenario

COLUMNS = {ON_TARGET: "", "miss_m": "m", "delta_v_m_s": "m/s", "nearest_m": "m", "safe": ""}


@dataclass(frozen=True, eq=False)
class ApproachLoop(LeadTimes):
    """An approach with margins, and the programme that was planned on the ground."""

    scenario: Scenario
    approach: Approach
    first: Impulses

    @classmethod
    def of(cls, scenario: Scenario, solve: Solve) -> ApproachLoop:
        """Plan on the ground. Raises ScenarioError without errors to fly with, or without a programme."""
        given_errors(scenario.name, scenario.uncertainty, "navigation and engine")
        found = plan_unflown(scenario, solve=solve)
        programme = programme_of(scenario.name, found, found.programme, "capture")
        return cls(scenario, found.approach, Impulses(programme, scenario.duration_s))

    @property
    def columns(self) -> Mapping[str, str]:
        return COLUMNS

    @property
    def shown(self) -> Sequence[tuple[str, str]]:
        return ("miss_m", "miss of the capture point (m)"), ("nearest_m", "least distance of a drift (m)")

    def vehicle(self, seed: int, number: int) -> Chaser:
        """From where the dispersed case of that number holds."""
        errors = self.scenario.uncertainty
        assert errors is not None
        start = Approach.of(disperse(self.scenario, number, seed)).start
        target = np.concatenate(state_from_elements(self.approach.orbit()))
        return Chaser.at(start, target, errors, np.random.default_rng([seed, number]))

    def answer(
        self, trigger: Trigger, sensed: Sensed, programme: Impulses, solve: Solve, allowance_s: float
    ) -> Answer:
        """The impulses that are left, from the state in which the next one will find the chaser. `allowance_s` is the lead."""
        at_s = trigger.at_s + self.scenario.guidance.lead_s
        done = programme.left(at_s)
        times = programme.programme.times_s
        state = self.approach.motion.transition(float(times[done]), sensed.at_s) @ sensed.estimate
        found, given_up_m, solved = replanned(self.approach, times[done:], state, done, solve, margins=True)
        if not solved:
            return Answer(None, at_s, "no answer of the solver")
        impulses = np.concatenate([programme.programme.dv_m_s[:done], found])
        words = f"{len(found)} impulses, {given_up_m:.2f} m of margin given up"
        flown = Impulses(ImpulseProgramme(times, impulses), programme.end_s)
        return Answer(flown, at_s, words, {"given_up_m": given_up_m})

    def outcome(self, vehicle: Chaser, programme: Impulses) -> dict[str, float]:
        """The end, and how near to the target a drift after any impulse comes within an orbit."""
        approach = self.approach
        clear = drift_clearance(vehicle.after, approach.mean_motion_rad_s, approach.period_s)
        nearest = float(clear.distance_m.min())
        miss = float(np.linalg.norm(vehicle.relative[:3] - approach.capture))
        return {
            ON_TARGET: float(miss <= self.scenario.guidance.miss_m),
            "miss_m": miss,
            "delta_v_m_s": vehicle.spent_m_s,
            "nearest_m": nearest,
            "safe": float(nearest >= approach.keep_out_m),
        }

    def verdict(self, flown: FlownCycles) -> Sequence[VerdictLine]:
        end: Mapping[str, Any] = flown.outcome
        word = Word.MET if end[ON_TARGET] else Word.MISSED
        figure = f"ends {end['miss_m']:.2f} m from the capture point, {end['delta_v_m_s']:.3f} m/s fired"
        safe = Word.SAFE if end["safe"] else Word.NOT_SAFE
        near = f"the nearest drift after an impulse passes {end['nearest_m']:.1f} m from the target within an orbit"
        return (
            VerdictLine(Question.ANSWER, word, figure, f"{self.scenario.guidance.miss_m:g} m"),
            VerdictLine(Question.SAFETY, safe, near, f"{self.approach.keep_out_m:g} m"),
        )
