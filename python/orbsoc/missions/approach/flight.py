"""The approach flown in a closed loop: what is left of it is planned again before every impulse but the first.

The flying programme is the reference of the new plan, which ends with the first flight that keeps every condition. Of the margins that
the plan on the ground leaves, a re-plan keeps what the state in which it begins allows.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import inf
from typing import Any, NamedTuple

import numpy as np

from orbsoc.guidance.closed_loop import ON_TARGET, Answer, Decision, FlownCycles, Sensed, Trigger
from orbsoc.guidance.impulses import ImpulseProgramme
from orbsoc.guidance.impulsive_flight import Chaser, Impulses, LeadTimes
from orbsoc.guidance.scenario_file import Complaint, ScenarioError
from orbsoc.guidance.scp import ExitReason, Solve, uninterrupted
from orbsoc.guidance.setting_out import given_errors, programme_of
from orbsoc.guidance.verdict import Question, VerdictLine, Word
from orbsoc.orbit import state_from_elements
from orbsoc.orbit.array import Array

from .dispersion import disperse
from .model.approach import Approach
from .model.instants import at_nodes
from .model.nearest import Search
from .model.problem import Forms
from .planner import planned
from .scenario import Scenario
from .search.sequence import Found, attempt, sides

COLUMNS = {
    ON_TARGET: "",
    "miss_m": "m",
    "miss_m_s": "m/s",
    "delta_v_m_s": "m/s",
    "outside_m": "m",
    "drift_m": "m",
}
AN_ORBIT = 360
"""Instants of a drift, at which it is looked at."""
SPARE_M = 0.1
"""That a re-plan leaves of what the state in which it begins has of a margin."""
ABOUT = "about the flying programme"
"""The first way; others pass the keep-out on a side."""
FREE_M = 1e4
"""Of a hold that is given up: beyond any."""


class Sought(NamedTuple):
    """What a re-plan asks for beside keep-out, drifts and corridor."""

    words: str
    slow: bool
    """Speed limit, holds, and the velocities at points."""
    margin: float
    """Share of the keep-out's margin; or what the drift of the state in which it begins has of it, where that is more."""


SOUGHT = (
    Sought("every condition", slow=True, margin=1.0),
    Sought("without speed limit, holds and velocities", slow=False, margin=1.0),
    Sought("without them, with half the margin", slow=False, margin=0.5),
    Sought("without them, with less margin", slow=False, margin=0.0),
)
"""In order: the next one where no flight is found."""


@dataclass(frozen=True, eq=False)
class ApproachLoop(LeadTimes):
    """An approach with errors, and the programme that was planned on the ground."""

    scenario: Scenario
    approach: Approach
    first: Impulses

    @classmethod
    def of(cls, scenario: Scenario, solve: Solve) -> ApproachLoop:
        """Plan on the ground. Raises ScenarioError without errors to fly with, without a programme, or where thrust is held."""
        if scenario.engine.thrust == "held":
            allowed = "a closed loop plans impulses again; must be 'impulses'"
            raise ScenarioError(scenario.name, [Complaint("engine.thrust", "'held'", allowed)])
        given_errors(scenario.name, scenario.uncertainty, "navigation and engine")
        found = planned(scenario, solve)
        programme = programme_of(scenario.name, found, found.programme, "points")
        return cls(scenario, found.approach, Impulses(programme, scenario.duration_s))

    @property
    def columns(self) -> Mapping[str, str]:
        corridor = {} if self.scenario.corridor is None else {"corridor_m": "m"}
        return COLUMNS | corridor | {"safe": ""}

    @property
    def shown(self) -> Sequence[tuple[str, str]]:
        return ("miss_m", "miss of the last point (m)"), (
            "outside_m",
            "least distance outside the keep-out (m)",
        )

    def vehicle(self, seed: int, number: int) -> Chaser:
        """From where the dispersed case of that number begins."""
        errors = self.scenario.uncertainty
        assert errors is not None
        start = disperse(self.scenario, number, seed).start.state()
        target = np.concatenate(state_from_elements(self.approach.orbit()))
        return Chaser.at(start, target, errors, np.random.default_rng([seed, number]))

    def answer(
        self, trigger: Trigger, sensed: Sensed, programme: Impulses, solve: Solve, allowance_s: float
    ) -> Answer:
        """The impulses that are left, from the state in which the next one will find the chaser. `allowance_s` is the lead."""
        at_s = trigger.at_s + self.scenario.guidance.lead_s
        done, times = programme.left(at_s), programme.programme.times_s
        state = self.approach.motion.transition(float(times[done]), sensed.at_s) @ sensed.estimate
        left = ImpulseProgramme(times[done:], programme.programme.dv_m_s[done:])
        decisions: list[Decision] = []
        for sought in SOUGHT:
            found, solves = replanned(self.approach, left, state, sought, uninterrupted(solve))
            word = "NOT FOUND" if found is None else "CHOSEN"
            words = "no safe flight" if found is None else f"{found.total_m_s:.4f} m/s"
            decisions.append(Decision(sought.words, words, word, solves))
            if found is None:
                continue
            impulses = np.concatenate([programme.programme.dv_m_s[:done], found.dv_m_s])
            flown = Impulses(ImpulseProgramme(times, impulses), programme.end_s)
            words = f"{len(found)} impulses, {words}; {sought.words}"
            return Answer(flown, at_s, words, {"left_m_s": found.total_m_s}, tuple(decisions))
        return Answer(None, at_s, "no flight that keeps out", decisions=tuple(decisions))

    def outcome(self, vehicle: Chaser, programme: Impulses) -> dict[str, float]:
        """The end; how far outside the keep-out the flight and its drifts before the gate stay, and inside the corridor after it."""
        scenario, approach = self.scenario, self.approach
        outside = drift = corridor = inf
        for k, state in enumerate(vehicle.after):
            at_s, span_s = float(approach.times_s[k]), float(approach.ends_s[k] - approach.times_s[k])
            if k < approach.guarded:
                outside = min(outside, nearest_m(approach, state, at_s, span_s))
                drift = min(drift, nearest_m(approach, state, at_s, drifted_s(approach)))
            elif scenario.corridor is not None:
                places = positions(approach, state, at_s, span_s)
                corridor = min(corridor, float(scenario.corridor.depth(places).min()))
        last, end = list(scenario.points.values())[-1], vehicle.relative
        wanted = last.velocity()
        miss = float(np.linalg.norm(end[:3] - last.position()))
        off = 0.0 if wanted is None else float(np.linalg.norm(end[3:] - wanted))
        return {
            ON_TARGET: float(miss <= scenario.guidance.miss_m),
            "miss_m": miss,
            "miss_m_s": off,
            "delta_v_m_s": vehicle.spent_m_s,
            "outside_m": outside,
            "drift_m": drift,
            **({} if scenario.corridor is None else {"corridor_m": corridor}),
            "safe": float(min(outside, corridor) >= 0.0),
        }

    def verdict(self, flown: FlownCycles) -> Sequence[VerdictLine]:
        end: Mapping[str, Any] = flown.outcome
        word = Word.MET if end[ON_TARGET] else Word.MISSED
        figure = (
            f"ends {end['miss_m']:.2f} m and {end['miss_m_s']:.3f} m/s off the last point,"
            f" {end['delta_v_m_s']:.3f} m/s fired"
        )
        safe = Word.NOT_SAFE
        if end["safe"]:
            safe = Word.SAFE if end["drift_m"] >= 0.0 else Word.PARTLY
        near = f"the flight stays {_beside(end['outside_m'], 'outside')} the keep-out up to the gate"
        if "corridor_m" in end:
            near += f", then {_beside(end['corridor_m'], 'inside')} the corridor"
        drift = f"the nearest drift after an impulse passes {_beside(end['drift_m'], 'outside')} the keep-out"
        return (
            VerdictLine(Question.ANSWER, word, figure, f"{self.scenario.guidance.miss_m:g} m"),
            VerdictLine(Question.SAFETY, safe, near, evidence=drift),
        )


def _beside(distance_m: float, side: str) -> str:
    """On which side, and how far from it."""
    other = {"outside": "inside", "inside": "outside"}[side]
    return f"{abs(distance_m):.1f} m {side if distance_m >= 0.0 else other}"


def replanned(
    approach: Approach, flying: ImpulseProgramme, state: Array, sought: Sought, solve: Solve
) -> tuple[ImpulseProgramme | None, int]:
    """The first safe flight, sought about the flying impulses, then from every side, from a state (6,) just before the first of them; and how many solves."""
    begun = allowed(replace(approach, start=state, times_s=flying.times_s, in_flight=True), sought)
    ways: dict[str, Array | None] = {ABOUT: None}
    if begun.guarded:
        ways |= sides(begun)
    solves = 0
    for name, normals in ways.items():
        start = Found(flying, at_nodes(begun)) if name == ABOUT else None
        found = attempt(begun, Forms(begun), name, normals, solve, None, start, any_safe=True)
        if found.reason is ExitReason.INTERRUPTED:
            raise KeyboardInterrupt
        solves += len(found.subproblems)
        if found.reason is ExitReason.CONVERGED:
            return found.reference.safe, solves
        last = found.reference.last
        if last is not None and Search(begun).broken(last).worst_m <= SPARE_M:
            return last, solves
        if found.reason is ExitReason.SUBPROBLEM_INFEASIBLE:  # whatever the planes are
            break
    return None, solves


def allowed(approach: Approach, sought: Sought) -> Approach:
    """The approach from where it begins, with what is asked for; after the gate the first arc with what its place leaves of the margin."""
    scenario, errors = approach.scenario, approach.scenario.uncertainty
    assert errors is not None
    changes: dict[str, Any] = {}
    if approach.guarded and sought.margin < 1.0:
        outside_m = nearest_m(approach, approach.start, float(approach.times_s[0]), drifted_s(approach))
        whole_m = scenario.keep_out.margin_m
        margin_m = max(sought.margin * whole_m, _left(whole_m, outside_m))
        changes["keep_out"] = scenario.keep_out.model_copy(update={"margin_m": margin_m})
    first_m = inf
    if not approach.guarded and scenario.corridor is not None:
        first_m = _left(scenario.corridor.margin_m, float(scenario.corridor.depth(approach.start[:3])))
    if not sought.slow:
        free = {"hold_within_m": FREE_M, "vx_m_s": None, "vy_m_s": None, "vz_m_s": None}
        points = scenario.points.items()
        changes["points"] = {name: point.model_copy(update=free) for name, point in points}
        changes["speed"] = None
    elif scenario.speed is not None:
        unknown_m_s = errors.sigmas * errors.velocity_m_s
        limit_m_s = scenario.speed.at_target_m_s + unknown_m_s
        changes["speed"] = scenario.speed.model_copy(update={"at_target_m_s": limit_m_s})
    return replace(approach, scenario=scenario.model_copy(update=changes), first_margin_m=first_m)


def _left(margin_m: float, has_m: float) -> float:
    """Of a margin; negative where the place is on the wrong side, from which the flight comes back."""
    return min(margin_m, has_m - SPARE_M)


def drifted_s(approach: Approach) -> float:
    """How long a drift is looked at: an orbit, where it is to be safe for all time."""
    horizon_s = approach.horizon_s
    return approach.period_s if horizon_s == inf else horizon_s


def positions(approach: Approach, state: Array, at_s: float, span_s: float) -> Array:
    """Of a drift by the linear model, (M, 3)."""
    count = max(2, int(np.ceil(AN_ORBIT * span_s / approach.period_s)) + 1)
    times = at_s + np.linspace(0.0, span_s, count)
    return np.asarray((approach.transitions(times, np.full(count, at_s)) @ state)[:, :3])


def nearest_m(approach: Approach, state: Array, at_s: float, span_s: float) -> float:
    """How far outside the keep-out a drift from a state (6,) stays, m."""
    return float(approach.outside_m(positions(approach, state, at_s, span_s)).min())
