"""Random transfers made by flying two burns forward: found again, verified, and with burns no longer; others never."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.two_burn_missions import KINDS, transfer, unreachable_transfer
from orbsoc.missions.reachable_insertion import PlanStatus, TwoBurnPlan, plan
from orbsoc.missions.reachable_insertion.model.proof import proof_of_infeasibility
from orbsoc.missions.reachable_insertion.search.setup import InsertionSetup
from orbsoc.missions.reachable_insertion.two_burns.verdict import verdict


@pytest.mark.parametrize("number", range(40))
def test_a_transfer_that_is_feasible_by_construction_is_verified_with_burns_no_longer(number: int) -> None:
    made = transfer(2026, number)
    assert made.kind == KINDS[number % 4]
    found = plan(made.scenario)
    assert isinstance(found, TwoBurnPlan)
    assert found.status is PlanStatus.VERIFIED, verdict(found)
    assert found.time_of_flight_s <= 1.001 * made.burn_s
    assert found.time_of_flight_s <= made.scenario.vehicle.longest_burn_s
    if made.scenario.burn.ignition == "now":
        assert found.ignition_s == 0.0


@pytest.mark.parametrize("number", range(6))
def test_transfers_beyond_reach_are_never_verified(number: int) -> None:
    found = plan(unreachable_transfer(2026, number).scenario)
    assert found.status in (PlanStatus.INFEASIBLE, PlanStatus.NOT_FOUND, PlanStatus.NOT_VERIFIED)
    assert (found.status is PlanStatus.INFEASIBLE) == (found.proof is not None) == (number % 2 == 0)


@pytest.mark.parametrize("number", range(60))
def test_no_bound_proves_a_transfer_infeasible_that_is_feasible_by_construction(number: int) -> None:
    """Not even with the construction's burns as all the propellant; the bound on one burn's momentum does, wrongly for two."""
    made = transfer(7, number)
    ready = InsertionSetup.of(made.scenario)
    duration = made.burn_s / ready.units.time_s
    assert proof_of_infeasibility(ready.burn, ready.target, duration, coasts=True) is None


def test_the_bound_on_the_momentum_of_one_burn_is_no_proof_for_two() -> None:
    proved = 0
    for number in range(60):
        made = transfer(7, number)
        ready = InsertionSetup.of(made.scenario)
        duration = made.burn_s / ready.units.time_s
        proved += proof_of_infeasibility(ready.burn, ready.target, duration) is not None
    assert proved > 0


def test_one_scenario_has_one_answer() -> None:
    first, second = (plan(transfer(2026, 2).scenario) for _ in range(2))
    assert isinstance(first, TwoBurnPlan)
    assert isinstance(second, TwoBurnPlan)
    assert first.transfer is not None
    assert second.transfer is not None
    np.testing.assert_array_equal(first.transfer.controls, second.transfer.controls)
    np.testing.assert_array_equal(first.transfer.coasts, second.transfer.coasts)


def test_an_interrupted_search_says_so() -> None:
    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    found = plan(transfer(2026, 2).scenario, callback=interrupted)
    assert found.status is PlanStatus.INTERRUPTED
    assert isinstance(found, TwoBurnPlan)
    assert verdict(found).startswith("INTERRUPTED")
