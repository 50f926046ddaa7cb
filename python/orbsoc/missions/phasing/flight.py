"""The approach of hours flown in a closed loop: before the meeting the target is tracked anew, and the burns that are left are planned again.

Each re-plan is that of `dispersion.replanning`, on board. The chaser knows its own state; of the target it knows what tracking says.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from orbsoc.guidance.closed_loop import ON_TARGET, PERIOD, Answer, FlownCycles, Sensed, Trigger
from orbsoc.guidance.scenario_file import Complaint, ScenarioError
from orbsoc.guidance.scp import ExitReason, Solve
from orbsoc.guidance.setting_out import Lead, given_errors, programme_of
from orbsoc.guidance.verdict import Question, VerdictLine, Word
from orbsoc.orbit.array import Array
from orbsoc.orbit.perturbations import fast_coast
from orbsoc.orbit.relative import local_frame

from .dispersion.cases import disperse
from .dispersion.replanning import Horizon, planned_again
from .model.approach import Approach, state_at
from .planner import made
from .scenario import Errors, Scenario

COLUMNS = {ON_TARGET: "", "miss_km": "km", "speed_m_s": "m/s", "delta_v_m_s": "m/s"}


@dataclass(frozen=True, slots=True, eq=False)
class Burns:
    """Impulses (K, 3), m/s, inertial, at the approach's instants (K,), s after the first; the last is at the meeting."""

    times_s: Array
    dv_m_s: Array

    @property
    def end_s(self) -> float:
        return float(self.times_s[-1])


@dataclass(slots=True, eq=False)
class Pursuer:
    """The chaser's state (6,) at `time_s` after `start_s`, and the target as it really is."""

    scenario: Scenario
    start_s: float
    state: Array
    errors: Errors
    random: np.random.Generator
    time_s: float = 0.0
    spent_m_s: float = 0.0

    def advance(self, programme: Burns, until_s: float) -> None:
        """Fire every impulse from now until just before a time, and coast between; at the end that of the meeting, too."""
        last = until_s >= programme.end_s
        for at_s, impulse in zip(programme.times_s.tolist(), programme.dv_m_s, strict=True):
            due = at_s < until_s or (last and at_s <= until_s)
            if self.time_s <= at_s and due and impulse.any():
                self._coast(at_s)
                self._fire(impulse)
                self.time_s = float(np.nextafter(at_s, np.inf))  # fired once
        self._coast(until_s)

    def sense(self, random: np.random.Generator) -> Sensed:
        """The chaser's own state, and the target's as tracked, (2, 6)."""
        target = self.target()
        sigma = np.array([*self.errors.position_m, *self.errors.velocity_m_s])
        axes = np.kron(np.eye(2), local_frame(target)[0].T)
        return Sensed(
            self.time_s, np.array([self.state, target + axes @ (sigma * random.standard_normal(6))])
        )

    def target(self) -> Array:
        """Its state now, (6,)."""
        return state_at(self.scenario, "target", self.start_s + self.time_s)

    def _coast(self, until_s: float) -> None:
        if until_s > self.time_s + 1e-6:
            forces = self.scenario.forces_on(self.scenario.chaser.ballistic_m2_kg)
            self.state = fast_coast([self.state], [0.0, until_s - self.time_s], forces)[-1, 0]
        self.time_s = max(self.time_s, until_s)

    def _fire(self, impulse: Array) -> None:
        size = float(np.linalg.norm(impulse))
        along = impulse / size
        tilt = np.deg2rad(self.errors.execution_deg) * self.random.standard_normal(3)
        share = self.errors.execution_share * self.random.standard_normal()
        fired = impulse * (1.0 + share) + size * np.cross(tilt, along)
        self.state = self.state + np.concatenate([np.zeros(3), fired])
        self.spent_m_s += float(np.linalg.norm(fired))


@dataclass(frozen=True, eq=False)
class PhasingLoop(Lead):
    """An approach with errors, and the burns that were planned on the ground."""

    scenario: Scenario
    approach: Approach
    first: Burns
    errors: Errors = field(repr=False)

    @classmethod
    def of(cls, scenario: Scenario, solve: Solve) -> PhasingLoop:
        """Plan on the ground. Raises ScenarioError without errors to fly with, or without a plan by cones."""
        errors = given_errors(scenario.name, scenario.uncertainty, "tracking and engine")
        if scenario.scheme != "socp":
            allowed = "plans no burn again; must be 'socp' in a closed loop"
            raise ScenarioError(scenario.name, [Complaint("scheme", repr(scenario.scheme), allowed)])
        found = made(scenario, solve, None)
        descended = programme_of(scenario.name, found, found.descended if found.programme else None, "window")
        approach, roll = descended.approach, descended.roll
        burns = Burns(approach.times_s - approach.times_s[0], roll.dv_m_s)
        return cls(scenario, approach, burns, errors)

    @property
    def columns(self) -> Mapping[str, str]:
        return COLUMNS

    @property
    def shown(self) -> Sequence[tuple[str, str]]:
        return ("miss_km", "miss of the target (km)"), ("delta_v_m_s", "fired (m/s)")

    def vehicle(self, seed: int, number: int) -> Pursuer:
        """The chaser as planned, behind the target of the dispersed case of that number."""
        approach = self.approach
        actual = disperse(self.scenario, number, seed)
        random = np.random.default_rng([seed, number])
        return Pursuer(actual, float(approach.times_s[0]), approach.start, self.errors, random)

    def next_trigger(self, last: Trigger | None, programme: Burns) -> Trigger | None:
        """At each of `replans_h` before the meeting, where a burn can still follow."""
        number, after_s = (1, 0.0) if last is None else (last.number + 1, last.at_s)
        times = sorted(programme.end_s - 3600.0 * hours for hours in self.scenario.guidance.replans_h)
        later = [at_s for at_s in times if at_s > after_s and at_s + self.period_s < programme.end_s]
        return Trigger(number, later[0], PERIOD) if later else None

    def answer(
        self, trigger: Trigger, sensed: Sensed, programme: Burns, solve: Solve, allowance_s: float
    ) -> Answer:
        """The burns from the first instant on that comes after the allowance."""
        approach, times = self.approach, programme.times_s
        at_s = trigger.at_s + self.period_s
        done = int(np.searchsorted(times, at_s))
        chaser, target = sensed.estimate
        exact = Errors(execution_share=0.0, execution_deg=0.0)
        start_s = float(approach.times_s[0])
        ahead = Pursuer(self.scenario, start_s, chaser, exact, np.random.default_rng(0), sensed.at_s)
        ahead.advance(programme, float(times[done]))
        window = self.scenario.window.model_copy(update={"normal_first": False})
        real = replace(
            approach,
            scenario=self.scenario.model_copy(update={"window": window}),
            times_s=approach.times_s[done:],
            start=ahead.state,
            goal=self._goal(target, sensed.at_s),
        )
        roll, reason, _ = planned_again(real, programme.dv_m_s[done:], 0, Horizon(solve=solve))
        if reason is ExitReason.INTERRUPTED:
            raise KeyboardInterrupt
        if roll is None:
            return Answer(None, at_s, "no burns from here that meet the target")
        burns = Burns(times, np.concatenate([programme.dv_m_s[:done], roll.dv_m_s]))
        count = int(roll.dv_m_s.any(axis=1).sum())
        words = f"{count} burn{'s' * (count != 1)}, {roll.cost_m_s:.3f} m/s to the meeting"
        return Answer(burns, at_s, words, {"left_m_s": roll.cost_m_s})

    def _goal(self, target: Array, at_s: float) -> Array:
        """Where the target as tracked will be at the meeting, with the air that the scenario says it feels."""
        scenario = self.scenario
        forces = scenario.forces_on(scenario.target.ballistic_m2_kg)
        return np.asarray(fast_coast([target], [0.0, self.first.end_s - at_s], forces)[-1, 0])

    def outcome(self, vehicle: Pursuer, programme: Burns) -> dict[str, float]:
        """How far from the real target the chaser is at the meeting, and how fast beside it."""
        off = vehicle.state - vehicle.target()
        miss_km, speed = 1e-3 * float(np.linalg.norm(off[:3])), float(np.linalg.norm(off[3:]))
        return {
            ON_TARGET: float(miss_km <= self.errors.distance_km),
            "miss_km": miss_km,
            "speed_m_s": speed,
            "delta_v_m_s": vehicle.spent_m_s,
        }

    def verdict(self, flown: FlownCycles) -> Sequence[VerdictLine]:
        end = flown.outcome
        word = Word.MET if end[ON_TARGET] else Word.MISSED
        figure = (
            f"{end['miss_km']:.3g} km from the target at the meeting, {end['speed_m_s']:.3g} m/s beside it,"
            f" {end['delta_v_m_s']:.2f} m/s fired"
        )
        return (VerdictLine(Question.ANSWER, word, figure, f"{self.errors.distance_km:g} km"),)
