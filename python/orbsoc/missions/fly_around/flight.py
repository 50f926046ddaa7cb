"""The fly-around flown in a closed loop: before each pulse but the first, those that are left are planned again within the tube."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from orbsoc.guidance.closed_loop import ON_TARGET, Answer, FlownCycles, Sensed, Trigger
from orbsoc.guidance.impulses import ImpulseProgramme
from orbsoc.guidance.impulsive_flight import Chaser, Impulses, LeadTimes
from orbsoc.guidance.scp import Solve, uninterrupted
from orbsoc.guidance.setting_out import given_errors, programme_of
from orbsoc.guidance.verdict import Question, VerdictLine, Word
from orbsoc.orbit.array import Array

from .dispersion import disperse
from .planner import made
from .scenario import Scenario
from .search.tube import NoTube, Revolution, solve_tube
from .verification import target_state

COLUMNS = {ON_TARGET: "", "error_m": "m", "delta_v_m_s": "m/s"}


@dataclass(frozen=True, eq=False)
class FlyAroundLoop(LeadTimes):
    """A fly-around with errors, and the programme that was planned on the ground."""

    scenario: Scenario
    first: Impulses

    @classmethod
    def of(cls, scenario: Scenario, solve: Solve) -> FlyAroundLoop:
        """Plan on the ground. Raises ScenarioError without errors to fly with, or without a programme."""
        given_errors(scenario.name, scenario.uncertainty, "navigation and engine")
        found = made(scenario, solve, None)
        verified = programme_of(scenario.name, found, found.verification, "impulses", repr(scenario.impulses))
        plan = verified.flown
        return cls(scenario, Impulses(plan.programme, plan.end_s))

    @property
    def columns(self) -> Mapping[str, str]:
        return COLUMNS

    @property
    def shown(self) -> Sequence[tuple[str, str]]:
        return ("error_m", "largest distance from the path (m)"), ("delta_v_m_s", "fired (m/s)")

    def vehicle(self, seed: int, number: int) -> Chaser:
        """From where the dispersed case of that number begins."""
        scenario, errors = self.scenario, self.scenario.uncertainty
        assert errors is not None
        start = disperse(scenario, number, seed).start_state

        def path(at_s: float) -> Array:
            return np.asarray(scenario.flight.ellipse.position(np.array([at_s]))[0])

        return Chaser.at(start, target_state(scenario), errors, np.random.default_rng([seed, number]), path)

    def answer(
        self, trigger: Trigger, sensed: Sensed, programme: Impulses, solve: Solve, allowance_s: float
    ) -> Answer:
        """Least fuel within what the plan leaves of the tube, else the least largest error. `allowance_s` is the lead."""
        scenario, at_s = self.scenario, trigger.at_s + self.scenario.guidance.lead_s
        done, times = programme.left(at_s), programme.programme.times_s
        state = scenario.flight.state_after(sensed.estimate, float(times[done]) - sensed.at_s)
        whole = Revolution(scenario.flight, state, programme.end_s, uninterrupted(solve))
        found = solve_tube(whole, times[done:], "error")
        if isinstance(found, NoTube):
            return Answer(None, at_s, found.reason)
        impulses = np.concatenate([programme.programme.dv_m_s[:done], found.programme.dv_m_s])
        words = f"{len(times) - done} pulses, at most {found.error_m:.2f} m from the path"
        flown = Impulses(ImpulseProgramme(times, impulses), programme.end_s)
        return Answer(flown, at_s, words, {"error_m": found.error_m})

    def outcome(self, vehicle: Chaser, programme: Impulses) -> dict[str, float]:
        """The largest distance from the path beside the tolerance."""
        return {
            ON_TARGET: float(vehicle.error_m <= self.scenario.tolerance_m),
            "error_m": vehicle.error_m,
            "delta_v_m_s": vehicle.spent_m_s,
        }

    def verdict(self, flown: FlownCycles) -> Sequence[VerdictLine]:
        end = flown.outcome
        word = Word.MET if end[ON_TARGET] else Word.MISSED
        figure = f"at most {end['error_m']:.2f} m from the path, {end['delta_v_m_s']:.3f} m/s fired"
        return (VerdictLine(Question.ANSWER, word, figure, f"{self.scenario.tolerance_m:g} m"),)
