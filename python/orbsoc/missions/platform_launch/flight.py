"""The rendezvous flown in a closed loop: corrections between the impulses, each the rendezvous planned again from where the server is.

The launch is never quite as planned, and two impulses leave no room to make up for it. So guidance plans again at times of its own, for
an impulse more and those that are left, which still end at rest at the target at the planned time.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from orbsoc.conic.settings import Settings
from orbsoc.guidance.closed_loop import ON_TARGET, PERIOD, Answer, FlownCycles, Sensed, Trigger
from orbsoc.guidance.impulses import ImpulseProgramme
from orbsoc.guidance.impulsive_flight import Chaser, Impulses
from orbsoc.guidance.scenario_file import Complaint, ScenarioError
from orbsoc.guidance.scp import Solve, uninterrupted
from orbsoc.guidance.setting_out import Lead, given_errors, programme_of
from orbsoc.guidance.uncertainty import Uncertainty
from orbsoc.guidance.verdict import Question, VerdictLine, Word

from .dispersion import disperse
from .planner import USABLE, made
from .scenario import Scenario
from .search.rendezvous import TOLERANCE, to_rest

COLUMNS = {ON_TARGET: "", "miss_m": "m", "speed_m_s": "m/s", "delta_v_m_s": "m/s"}


@dataclass(frozen=True, eq=False)
class LaunchLoop(Lead):
    """A launch with errors, and the programme that was planned on the ground."""

    scenario: Scenario
    first: Impulses
    errors: Uncertainty = field(repr=False)

    @classmethod
    def of(cls, scenario: Scenario, solve: Solve) -> LaunchLoop:
        """Plan on the ground. Raises ScenarioError without errors to fly with, without a programme, or with no time to correct it."""
        cycle = scenario.guidance
        given = given_errors(scenario.name, scenario.uncertainty, "launch and engine")
        found = made(scenario, solve, None)
        programme = programme_of(scenario.name, found, found.programme, "rendezvous")
        meeting = programme_of(scenario.name, found, found.meeting, "rendezvous")
        apart_s = meeting.time_s / (cycle.corrections + 1)
        if cycle.lead_s >= apart_s:
            allowed = f"{cycle.corrections} corrections in {meeting.time_s:.4g} s are {apart_s:.4g} s apart; must be below that"
            raise ScenarioError(scenario.name, [Complaint("guidance.lead_s", f"{cycle.lead_s:g}", allowed)])
        errors = Uncertainty(
            position_m=given.position_m,
            velocity_m_s=given.velocity_m_s,
            execution_share=given.execution_share,
        )
        return cls(scenario, Impulses(programme, meeting.time_s), errors)

    @property
    def columns(self) -> Mapping[str, str]:
        return COLUMNS

    @property
    def shown(self) -> Sequence[tuple[str, str]]:
        return ("miss_m", "miss of the target (m)"), ("speed_m_s", "speed left there (m/s)")

    def vehicle(self, seed: int, number: int) -> Chaser:
        """The server where the dispersed launch of that number leaves it."""
        start = disperse(self.scenario, number, seed).separation().state
        random = np.random.default_rng([seed, number])
        return Chaser.at(start, self.scenario.target_state(), self.errors, random)

    def next_trigger(self, last: Trigger | None, programme: Impulses) -> Trigger | None:
        """A lead before the next correction."""
        number = 1 if last is None else last.number + 1
        count = self.scenario.guidance.corrections
        if number > count:
            return None
        at_s = number * programme.end_s / (count + 1) - self.period_s
        return Trigger(number, at_s, PERIOD)

    def answer(
        self, trigger: Trigger, sensed: Sensed, programme: Impulses, solve: Solve, allowance_s: float
    ) -> Answer:
        """An impulse when the lead is over, and those that are left after it."""
        motion, end_s, at_s = self.scenario.motion, programme.end_s, trigger.at_s + self.period_s
        fired, left = programme.programme.times_s, programme.left(at_s)
        state = sensed.estimate
        kicks = programme.programme.dv_m_s
        now_s = sensed.at_s
        for k in range(programme.left(sensed.at_s), left):  # that are still fired before the answer is flown
            state = motion.transition(float(fired[k]), now_s) @ state
            state[3:] += kicks[k]
            now_s = float(fired[k])
        state = motion.transition(at_s, now_s) @ state
        times = np.union1d([at_s], fired[left:])
        impulses = to_rest(state, motion, times, end_s, self.scenario.rendezvous.cost)
        solution = uninterrupted(solve)(impulses.builder.build(), Settings(tol=TOLERANCE))
        if solution.status not in USABLE:
            return Answer(None, at_s, "no answer of the solver")
        found = impulses.programme(solution)
        whole = ImpulseProgramme(
            np.concatenate([fired[:left], found.times_s]), np.concatenate([kicks[:left], found.dv_m_s])
        )
        after = len(found) - 1
        words = f"a correction of {found.sizes_m_s[0]:.3f} m/s, {after} impulse{'s' * (after != 1)} after it"
        return Answer(Impulses(whole, end_s), at_s, words, {"correction_m_s": float(found.sizes_m_s[0])})

    def outcome(self, vehicle: Chaser, programme: Impulses) -> dict[str, float]:
        """Where the server is when it should be at rest at the target."""
        miss, speed = (float(np.linalg.norm(each)) for each in np.split(vehicle.relative, 2))
        return {
            ON_TARGET: float(miss <= self.scenario.guidance.miss_m),
            "miss_m": miss,
            "speed_m_s": speed,
            "delta_v_m_s": vehicle.spent_m_s,
        }

    def verdict(self, flown: FlownCycles) -> Sequence[VerdictLine]:
        end = flown.outcome
        word = Word.MET if end[ON_TARGET] else Word.MISSED
        figure = (
            f"ends {end['miss_m']:.2f} m from the target at {end['speed_m_s']:.3f} m/s,"
            f" {end['delta_v_m_s']:.3f} m/s fired"
        )
        return (VerdictLine(Question.ANSWER, word, figure, f"{self.scenario.guidance.miss_m:g} m"),)
