"""Two burns under a bound on the attitude rate: kept by what is flown, and what it costs."""

from __future__ import annotations

import csv
import io
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.two_burn_missions import transfer
from orbsoc.guidance.collocation import legendre_gauss
from orbsoc.missions.reachable_insertion import Plan, PlanStatus, Scenario, TwoBurnPlan, load_scenario, plan
from orbsoc.missions.reachable_insertion.plan import details as verdict_of_one_burn
from orbsoc.missions.reachable_insertion.search.setup import InsertionSetup
from orbsoc.missions.reachable_insertion.two_burns.flight import sensitivities
from orbsoc.missions.reachable_insertion.two_burns.motion import Motion
from orbsoc.missions.reachable_insertion.two_burns.transfer import Transfer, constant
from orbsoc.missions.reachable_insertion.two_burns.turning import held_shares, slowed, turn_rates
from orbsoc.missions.reachable_insertion.two_burns.verdict import verdict, violations
from orbsoc.missions.reachable_insertion.two_burns.verification import verify

Array = NDArray[np.float64]
RAISE = Path(__file__).resolve().parents[4] / "scenarios" / "raise_two_burns.toml"


def scenario(bound_deg_s: float | None, **settings: Any) -> Scenario:
    """The shipped raise with a tenth of its thrust: burns of six minutes, over which the orbit turns by 24°."""
    limits = {} if bound_deg_s is None else {"limits.attitude_rate_deg_s": bound_deg_s}
    return load_scenario(RAISE, {"vehicle.thrust_n": 500.0, "axes": "eci", **limits, **settings})


@cache
def turning(bound_deg_s: float | None, *, j2: bool = False) -> TwoBurnPlan:
    found = plan(scenario(bound_deg_s, **{"burn.coast_j2": j2}))
    assert isinstance(found, TwoBurnPlan)
    return found


def flown_rates_deg_s(found: TwoBurnPlan) -> Array:
    """Of the burns, from the lines of attitude.csv alone: angles between neighbours."""
    rows = list(csv.DictReader(io.StringIO(found.tables()["attitude.csv"])))
    t, on = (np.array([float(row[key]) for row in rows]) for key in ("t_s", "thrust_n"))
    u = np.array([[float(row[key]) for key in ("ux_eci", "uy_eci", "uz_eci")] for row in rows])
    angles = 2.0 * np.arcsin(0.5 * np.linalg.norm(np.diff(u, axis=0), axis=1))
    burning = (on[1:] > 0.0) & (on[:-1] > 0.0)
    return np.asarray(np.rad2deg(angles) / np.diff(t))[burning]


@pytest.mark.parametrize(("bound", "j2"), [(0.04, False), (0.005, False), (0.02, True)])
def test_the_flown_attitude_of_both_burns_keeps_the_bound_and_reaches_it(bound: float, j2: bool) -> None:
    found = turning(bound, j2=j2)
    assert found.status is PlanStatus.VERIFIED, verdict(found)
    rates = flown_rates_deg_s(found)
    assert len(rates) == 800
    assert 0.999 * bound < rates.max() <= bound * (1.0 + 1e-9)
    told = found.to_dict()["attitude_rate"]
    assert told["bound_deg_s"] == bound
    assert told["active"]
    assert 0.999 * bound < told["peak_deg_s"] <= bound
    assert "which is the bound" in verdict(found)


def test_a_slower_turn_takes_longer_burns() -> None:
    by_bound = [turning(bound).time_of_flight_s for bound in (None, 0.04, 0.02, 0.005)]
    assert by_bound == sorted(by_bound)
    assert 1.0005 < by_bound[1] / by_bound[0] < by_bound[3] / by_bound[0] < 1.006  # 707.62 and 711.15 s


def test_a_bound_that_is_not_reached_changes_no_bit() -> None:
    free, bounded = turning(None), turning(0.1)
    assert free.transfer is not None
    assert bounded.transfer is not None
    np.testing.assert_array_equal(free.transfer.controls, bounded.transfer.controls)
    np.testing.assert_array_equal(free.transfer.coasts, bounded.transfer.coasts)
    assert bounded.to_dict()["attitude_rate"]["active"] is False
    assert free.to_dict()["attitude_rate"]["bound_deg_s"] is None
    assert "0.1 °/s are allowed" in verdict(bounded)


def test_the_flight_of_a_plan_that_turns_too_fast_is_refused() -> None:
    found = turning(None)
    assert found.transfer is not None
    end = sensitivities(Motion.of(InsertionSetup.of(found.scenario)), found.transfer).end
    [failure] = verify(scenario(0.02), found.target, found.transfer, end).failures
    assert failure.startswith("attitude rate is 0.0662")
    assert failure.endswith("°/s, allowed 0.02 °/s")


def test_the_slew_between_the_burns_is_told_and_named_where_it_is_faster_than_the_bound() -> None:
    found = turning(0.02)
    slew = found.to_dict()["attitude_rate"]["slew_deg_s"]
    rows = list(csv.DictReader(io.StringIO(found.tables()["attitude.csv"])))
    between = [float(row["rate_deg_s"]) for row in rows if float(row["thrust_n"]) == 0.0]
    np.testing.assert_allclose(between, slew)
    assert slew > 0.02
    assert f"the slew between the burns takes {slew:.4g} °/s" in verdict(found)
    assert "the slew" not in verdict(turning(0.1))


def test_a_bounded_transfer_that_is_feasible_by_construction_is_verified_with_burns_no_longer() -> None:
    made = transfer(2026, 2, bounded=True)
    found = plan(made.scenario)
    assert found.status is PlanStatus.VERIFIED, found.message
    assert found.time_of_flight_s <= 1.001 * made.burn_s


def test_propellant_for_the_fast_turn_alone_is_not_found_within_the_bound() -> None:
    enough = {"vehicle.dry_mass_kg": 1000.0 - 709.0 * scenario(None).vehicle.mass_flow_kg_s}
    assert turning(None).time_of_flight_s < 709.0
    slow = plan(scenario(0.01, **enough))
    assert slow.status is PlanStatus.NOT_FOUND
    assert isinstance(slow, TwoBurnPlan)
    assert "the propellant lasts for 709.0 s" in verdict(slow)
    assert "not a proof" in verdict(slow)
    assert violations(slow) == ()


def test_one_burn_that_fails_within_the_bound_names_two_that_keep_it() -> None:
    one = plan(scenario(0.02, **{"burn.count": 1, "burn.duration_s": 600.0}))
    assert isinstance(one, Plan)
    assert one.status is PlanStatus.NOT_FOUND
    assert "--set burn.count=2" in verdict_of_one_burn(one)


def arc(degrees: float) -> Transfer:
    """Both burns turn by an angle at a constant rate."""
    grid = legendre_gauss(12)
    angle = 0.5 * np.deg2rad(degrees) * grid.nodes
    controls = np.column_stack([np.cos(angle), np.sin(angle), 0.0 * angle])
    return Transfer(grid, np.array([0.1, 1.0]), np.array([0.5, 2.0]), np.array([controls, controls]))


def test_rates_are_those_of_a_great_circle() -> None:
    np.testing.assert_allclose(turn_rates(arc(40.0)), np.deg2rad(40.0) / np.array([0.5, 2.0]), rtol=1e-6)


@pytest.mark.parametrize("degrees", [10.0, 120.0, 355.0])
def test_a_slowed_transfer_keeps_its_times_and_its_slow_burns(degrees: float) -> None:
    fast = arc(degrees)
    bound = 0.7 * float(turn_rates(fast)[0])
    found = slowed(fast, bound)
    rates = turn_rates(found)
    assert 0.5 * bound < rates[0] <= bound
    np.testing.assert_array_equal(found.controls[1], fast.controls[1])
    np.testing.assert_array_equal(found.durations, fast.durations)
    np.testing.assert_allclose(np.linalg.norm(found.controls, axis=2), 1.0)


def test_of_a_constant_attitude_the_whole_bound_is_held() -> None:
    still = constant(np.eye(3)[:2], np.array([0.1, 1.0]), np.array([0.5, 2.0]), 12)
    np.testing.assert_allclose(held_shares(still), 1.0, atol=1e-5)
