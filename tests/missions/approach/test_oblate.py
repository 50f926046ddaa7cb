"""J2 in the linear model of the plan: under J2 its flight without corrections ends nearer, and what cannot go with it is refused."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from orbsoc.guidance.claims import Kind
from orbsoc.guidance.mission import PlanStatus
from orbsoc.guidance.relative_flight import TRUTHS, fly
from orbsoc.guidance.scenario_file import ScenarioError
from orbsoc.guidance.verdict import Question
from orbsoc.missions import approach
from orbsoc.missions.approach.model.approach import Approach
from orbsoc.missions.approach.plan import Plan
from orbsoc.orbit import state_from_elements
from orbsoc.orbit.relative import AlongReference, Tabulated
from tests.missions.approach.cases import station

QUICK: dict[str, Any] = {"safety__orbits": 0.5, "safety__cut_burns": False, "safety__abort_every_s": 1000.0}


def missed_m(plan: Plan, forces: str) -> float:
    """By how much the last point is missed about the Earth, uncorrected."""
    assert plan.programme is not None
    target = np.concatenate(state_from_elements(plan.approach.orbit()))
    times = [0.0, plan.approach.duration_s]
    flight = fly(plan.programme, plan.approach.start, target, times, TRUTHS[forces])
    last = list(plan.scenario.points.values())[-1]
    return float(np.linalg.norm(flight.states[-1, :3] - last.position()))


def test_with_j2_a_plan_misses_under_j2_what_another_misses_without() -> None:
    """What is left is of second order in the distance, as that of the plan without it where there is no J2."""
    without, with_ = (
        approach.plan(station("station_rbar", **QUICK, model__j2=each)) for each in (False, True)
    )
    assert with_.status is PlanStatus.VERIFIED, with_.message
    left = missed_m(without, "two_body")
    assert missed_m(without, "j2") > 2.0 * left
    assert missed_m(with_, "j2") == pytest.approx(left, rel=0.02)
    spent = [
        float(plan.verification.corrected.delta_v_m_s[0]) - plan.programme.total_m_s
        for plan in (without, with_)
        if plan.verification is not None and plan.programme is not None
    ]
    assert abs(spent[1]) < 0.2 * spent[0]
    (safety,) = [line for line in with_.verdict.lines if line.question is Question.SAFETY]
    assert safety.claim is not None
    assert safety.claim.kind is Kind.SAMPLED
    assert with_.verification is not None
    assert all(cut.at_least_m is None for cut in with_.verification.cuts)


def test_looked_up_transitions_are_the_integrated_ones() -> None:
    """At times between the steps, with lengths in m and speeds by the mean motion: to 1e-9."""
    at = Approach.of(station("station_rbar", model__j2=True))
    assert isinstance(at.motion, Tabulated)
    assert not at.planar
    target = np.concatenate(state_from_elements(at.orbit()))
    along = AlongReference(target, TRUTHS["j2"](1))
    units = np.repeat([1.0, at.mean_motion_rad_s], 3)
    rng = np.random.default_rng(3)
    for first, last in rng.uniform(0.0, at.duration_s, (4, 2)).tolist():
        wanted = along.transition(last, first) / np.outer(units, 1.0 / units)
        found = at.motion.transition(last, first) / np.outer(units, 1.0 / units)
        assert np.abs(found - wanted).max() < 1e-9 * np.abs(wanted).max()
    with pytest.raises(ValueError, match="must be within 0 and"):
        at.motion.transition(at.motion.end_s + 1.0, 0.0)


@pytest.mark.parametrize(
    ("name", "changes", "says"),
    [
        (
            "station_rbar",
            {"safety__all_time": True},
            "safety.all_time = true: for all time only without J2 in the model; give orbits",
        ),
        ("station_held", {}, "model.j2 = true: thrust that is held is planned without it; leave it out"),
        ("station_rbar", {"model__j2": 1}, "model.j2 = 1: Input should be a valid boolean"),
        ("station_rbar", {"model__j3": True}, "model.j3 = True: unknown key; allowed here: j2"),
    ],
)
def test_what_does_not_go_with_j2_is_refused(name: str, changes: dict[str, Any], says: str) -> None:
    with pytest.raises(ScenarioError) as error:
        station(name, **({"model__j2": True} | changes))
    assert says in str(error.value)
