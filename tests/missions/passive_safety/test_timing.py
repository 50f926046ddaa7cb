"""Timing: the second impulse's time is one well, two impulses are enough."""

from __future__ import annotations

import pytest

import orbsoc
from orbsoc.missions.passive_safety.search.timing import plan_times
from tests.missions.passive_safety.cases import CASES, Case


@pytest.mark.parametrize("case", CASES, ids=str)
def test_the_free_time_is_the_known_one_and_the_scan_has_one_well(case: Case) -> None:
    found = plan_times(case.approach(impulses={"timing": "free"}), orbsoc.solve)
    assert found.best is not None
    assert found.best.cost == pytest.approx(case.free, abs=6e-5)
    assert found.best.second_s == pytest.approx(case.second_s, abs=4.0)
    assert found.wells == 1


@pytest.mark.parametrize("case", CASES[::5], ids=str)
def test_more_impulses_gain_nothing(case: Case) -> None:
    two = plan_times(case.approach(impulses={"timing": "free"}), orbsoc.solve)
    many = plan_times(case.approach(impulses={"timing": "generated"}), orbsoc.solve)
    assert two.best is not None
    assert many.best is not None
    assert many.best.cost == pytest.approx(two.best.cost, abs=1e-6)
    assert many.programme is not None
    assert len(many.programme) <= 3


def test_without_a_condition_the_first_drift_leads_away() -> None:
    """The all-time rule for a free first impulse: fitted, of the rows with condition 1."""
    for case, cost in zip(CASES[0:8:2], (0.3215, 0.2570, 0.8023, 0.5640), strict=True):
        found = plan_times(case.approach(condition="none", impulses={"timing": "free"}), orbsoc.solve)
        assert found.best is not None
        assert found.best.cost == pytest.approx(cost, abs=2e-4)
