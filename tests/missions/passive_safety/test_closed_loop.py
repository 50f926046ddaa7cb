"""Flights with errors: margins that hold, and nothing given up in silence."""

from __future__ import annotations

from pathlib import Path

import pytest

import orbsoc
from orbsoc.missions import passive_safety
from orbsoc.missions.passive_safety.dispersion import fly_many
from orbsoc.missions.passive_safety.model.approach import Approach
from orbsoc.missions.passive_safety.planner import plan_unflown
from tests.missions.passive_safety.cases import CASES, Case

SCENARIOS = Path(__file__).resolve().parents[3] / "scenarios"
ERRORS = {
    "position_m": 0.5,
    "velocity_m_s": 1e-3,
    "execution_share": 0.01,
    "execution_fixed_m_s": 2e-4,
}
ROBUST = {2: 0.39301, 1: 0.63134, 10: 0.30226, 9: 0.52829, 14: 0.65980}
"""Of cases by their place: the cost of the plan with margins."""


@pytest.mark.parametrize("case", ROBUST)
def test_margins_cost_what_is_known(case: int) -> None:
    found = plan_unflown(CASES[case].scenario(uncertainty=ERRORS))
    assert found.cost == pytest.approx(ROBUST[case], abs=1e-5)
    assert found.cost > CASES[case].norms


def test_where_no_plan_has_the_margins_that_is_told() -> None:
    found = plan_unflown(CASES[6].scenario(uncertainty=ERRORS))
    assert found.status.name == "INFEASIBLE"
    assert found.programme is None


@pytest.mark.parametrize("case", [2, 9])
def test_re_planned_flights_with_margins_are_safe_and_give_nothing_up(case: int) -> None:
    row: Case = CASES[case]
    approach = row.approach(uncertainty=ERRORS)
    robust, bare = plan_unflown(row.scenario(uncertainty=ERRORS)), plan_unflown(row.scenario())
    assert robust.programme is not None
    assert bare.programme is not None
    found = fly_many(approach, robust.programme, orbsoc.solve, runs=40)
    assert (found.unsafe, found.fallbacks, found.failed) == (0, 0, 0)
    assert found.replans == 160
    assert found.miss_m.mean() < 4.0
    for options in ({"replan": False}, {"margins": False}):
        unsafe = fly_many(approach, bare.programme, orbsoc.solve, runs=40, **options)
        assert unsafe.unsafe > 0


def test_a_flight_depends_on_seed_and_number_alone() -> None:
    approach = CASES[2].approach(uncertainty=ERRORS)
    programme = plan_unflown(CASES[2].scenario(uncertainty=ERRORS)).programme
    assert programme is not None
    few, many = (fly_many(approach, programme, orbsoc.solve, runs=runs) for runs in (2, 5))
    assert many.nearest_m[:2].tolist() == few.nearest_m.tolist()
    other = CASES[2].approach(uncertainty=ERRORS | {"seed": 1})
    assert fly_many(other, programme, orbsoc.solve, runs=2).nearest_m.tolist() != few.nearest_m.tolist()


def test_depth_that_is_given_up_is_counted() -> None:
    """From half the depth that the margins ask for, no re-plan can keep them."""
    scenario = passive_safety.load_scenario(SCENARIOS / "paper000_robust.toml")
    approach = Approach.of(scenario.with_changes(uncertainty={"position_m": 5.0, "velocity_m_s": 0.02}))
    programme = plan_unflown(scenario).programme
    assert programme is not None
    found = fly_many(approach, programme, orbsoc.solve, runs=5)
    assert found.fallbacks > 0
    assert found.most_given_up_m > 1.0
    assert found.to_dict()["fallbacks"] == found.fallbacks
