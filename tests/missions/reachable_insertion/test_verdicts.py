"""Answers that may not be wrong: burns that lower, turn, wait or do nothing, and targets that are out of reach."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.made_missions import Mission
from benchmarks.missions import KINDS, mission, unreachable
from orbsoc.guidance.mission import Agreement
from orbsoc.guidance.scp import Rules
from orbsoc.missions.reachable_insertion import Plan, PlanStatus, Scenario, load_scenario, plan
from orbsoc.missions.reachable_insertion.model.proof import proof_of_infeasibility
from orbsoc.missions.reachable_insertion.plan import details
from orbsoc.missions.reachable_insertion.search.run import Claim, Search, Strategy
from orbsoc.missions.reachable_insertion.search.setup import InsertionSetup
from orbsoc.missions.reachable_insertion.search.strategies import STRATEGIES
from orbsoc.missions.reachable_insertion.search.turning import quick_turn
from orbsoc.missions.reachable_insertion.starts.directions import starts
from orbsoc.missions.reachable_insertion.starts.steering_law import corrected, ends_of, steps_for
from orbsoc.missions.reachable_insertion.targets.target_orbit import LargestOrbit
from orbsoc.orbit import CanonicalUnits, propagate_burn
from orbsoc.solving.solver import solve

KICK = {"mass_kg": 5000.0, "dry_mass_kg": 1000.0, "thrust_n": 30000.0, "mass_flow_kg_s": 6.798108086519522}
SMALL = {"mass_kg": 1000.0, "dry_mass_kg": 800.0, "thrust_n": 440.0, "mass_flow_kg_s": 0.14473391410009306}
CASES: dict[str, tuple[dict[str, float], list[float], list[float], float]] = {
    "circular 500 km to 50 x 500 km": (
        SMALL,
        [-5937554.473575932, -3463748.028619892, 238044.2360555206, -720.0189005944769, 715.7569305617998, -7544.605224806287],
        [-5956641.372709687, -3439068.499999999, 0.0, -481.87436728612704, 834.6308870046765, -7420.454217803528],
        300.0,
    ),
    "apogee of a transfer orbit lowered": (
        KICK,
        [-6540981.615413907, 914239.1312802699, 96090.40474316917, -823.6430202076234, -10125.480410554334, -1064.230875248901],
        [-6578137.0, 0.0, 0.0, 0.0, -9794.895003107278, -1029.484948809186],
        60.0,
    ),
    "on its target orbit": (
        KICK,
        [6578137.0, 0.0, 0.0, 0.0, 8208.025123583355, 718.1091482495149],
        [6488789.947817233, 1139794.9085665918, 99719.13324414386, -1277.058054562525, 8096.722180306079, 708.3714024956843],
        80.0,
    ),
    "3 degrees of plane near the node": (
        KICK,
        [5380250.193766671, 4108009.248538274, -169098.39698543656, -4022.864821789759, 5418.6401782616485, 3657.765964157221],
        [5187161.8293655915, 4352545.577877533, 0.0, -4207.085077228394, 5013.808755136429, 4010.8194561412606],
        70.0,
    ),
    "out of reach unless it waits": (
        KICK,
        [0.0, 6553105.20272114, 573322.4161308518, -7784.2617485656265, 0.0, 0.0],
        [6578137.0, 0.0, 0.0, 0.0, 8208.025123583355, 718.1091482495149],
        80.0,
    ),
}  # fmt: skip


def scenario(case: str, **burn: Any) -> Scenario:
    vehicle, initial, target, duration_s = CASES[case]
    return Scenario.model_validate({
        "mission": "reachable_insertion", "name": case, "problem": "min_time", "axes": "eci", "vehicle": vehicle,
        "launch_site": {"geocentric_latitude_deg": 5.2, "azimuth_deg": 90.0, "inertial_longitude_deg": 0.0},
        "initial": {"position_m": initial[:3], "velocity_m_s": initial[3:]},
        "target": {"position_m": target[:3], "velocity_m_s": target[3:]},
        "burn": {"duration_s": duration_s, **burn},
    })  # fmt: skip


@pytest.mark.parametrize(
    ("case", "burn_s"),
    [("circular 500 km to 50 x 500 km", 300.526), ("apogee of a transfer orbit lowered", 63.364)],
)
def test_orbits_are_lowered_in_the_known_time(case: str, burn_s: float) -> None:
    found = plan(scenario(case))
    assert found.status is PlanStatus.VERIFIED
    assert found.time_of_flight_s == pytest.approx(burn_s, abs=0.002)
    assert found.later is not None
    assert "--set burn.ignition=free" in details(found)


def test_a_vehicle_on_its_target_orbit_gets_a_plan_of_no_burn() -> None:
    found = plan(scenario("on its target orbit"))
    assert found.status is PlanStatus.VERIFIED
    assert found.time_of_flight_s == 0.0
    assert found.subproblems == ()
    assert Agreement.of(found, found).agrees
    assert found.to_dict()["propellant_kg"] == 0.0
    assert found.tables()["attitude.csv"].splitlines() == ["t_s,pitch_deg,yaw_deg,ux,uy,uz,rate_deg_s"]


def test_a_plane_change_whose_shortest_burn_reverses_turns_as_fast_as_the_grid_follows() -> None:
    found = plan(scenario("3 degrees of plane near the node"))
    assert found.status is PlanStatus.VERIFIED
    assert 76.43 < found.time_of_flight_s < 76.6  # 16 °/s of limits.attitude_rate_deg_s take 76.618 s
    assert found.verification is not None
    peak = f"{np.rad2deg(found.verification.peak_rate_rad_s):.4g} °/s"
    words = f"turns at up to {peak}, about as fast as a grid of 48 nodes follows; one of 76.4"
    assert words in details(found)  # where a sequence led, too fast for its grid
    assert "s turned faster than 48 nodes follow" in details(found)
    assert found.later is not None
    assert found.later.burn_s < 67.6
    assert "max_nodes" not in details(found)


def test_the_faster_turn_is_added_to_what_was_found_and_an_interruption_keeps_that() -> None:
    coarse = scenario("3 degrees of plane near the node").with_changes(method={"max_nodes": 18})
    setup, search = InsertionSetup.of(coarse), Search(solve, Rules())
    smooth = search.run(setup, STRATEGIES[:-1])
    assert smooth.claim is Claim.SMOOTH_TURN

    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    last = replace(
        STRATEGIES[-1], run=lambda _, result: quick_turn(replace(search, callback=interrupted), result)
    )
    known = Strategy("what is known", lambda _: True, lambda *_: iter(smooth.attempts), frozenset(Claim))
    stopped = search.run(setup, [known, last])
    assert stopped.status is PlanStatus.INTERRUPTED
    assert stopped.best is smooth.best
    faster = search.run(setup, [known, STRATEGIES[-1]])
    assert faster.verified
    assert faster.claim is Claim.FAST_TURN
    assert faster.time_of_flight_s < 0.97 * smooth.time_of_flight_s  # 79.13 and 82.71 s
    assert faster.attempts[: len(smooth.attempts)] == smooth.attempts


def test_a_target_that_no_present_burn_reaches_is_not_found_and_names_the_coast_that_does() -> None:
    found = plan(scenario("out of reach unless it waits"))
    assert found.status is PlanStatus.NOT_FOUND
    words = details(found)
    assert words.startswith("NOT FOUND: ")
    assert "from 6 starts" in words
    assert "--set burn.ignition=free" in words
    tried = found.to_dict()["starts"]
    assert len(tried) == 6
    assert all(each["worst_row"] and each["by_canonical"] for each in tried)
    assert found.later is not None
    assert found.later.burn_s == pytest.approx(72.1, abs=0.1)


def test_a_free_ignition_finds_the_coast_and_its_flight_starts_there() -> None:
    found = plan(scenario("out of reach unless it waits", ignition="free"))
    assert found.status is PlanStatus.VERIFIED
    assert found.time_of_flight_s <= 72.10
    assert found.ignition_s == pytest.approx(3940.0, abs=15.0)
    bounded = plan(scenario("out of reach unless it waits", ignition="free", latest_ignition_s=1000.0))
    assert bounded.status is not PlanStatus.VERIFIED


def test_of_equal_burns_a_revolution_apart_the_earlier_is_planned() -> None:
    deorbit = load_scenario(Path(__file__).resolve().parents[3] / "scenarios" / "deorbit.toml")
    once, twice = (
        plan(deorbit.with_changes(burn={"ignition": "free", "latest_ignition_s": latest}))
        for latest in (5700.0, 11400.0)
    )
    assert twice.ignition_s == pytest.approx(once.ignition_s, abs=2.0)
    assert twice.time_of_flight_s == pytest.approx(once.time_of_flight_s, rel=1e-6)


@pytest.mark.parametrize("number", range(40))
def test_missions_that_are_feasible_by_construction_are_verified_with_a_burn_no_longer(number: int) -> None:
    made = mission(2026, number)
    assert made.kind == KINDS[number % 10]
    found = plan(made.scenario)
    assert found.status is PlanStatus.VERIFIED, details(found)
    assert found.time_of_flight_s <= 1.001 * made.burn_s


@pytest.mark.parametrize("number", range(4))
def test_missions_beyond_reach_are_never_verified(number: int) -> None:
    found = plan(unreachable(2026, number).scenario)
    assert found.status in (PlanStatus.INFEASIBLE, PlanStatus.NOT_FOUND, PlanStatus.NOT_VERIFIED)
    assert (found.status is PlanStatus.INFEASIBLE) == (found.proof is not None)


@pytest.mark.parametrize("number", range(60))
def test_no_bound_proves_a_mission_infeasible_that_is_feasible_by_construction(number: int) -> None:
    """Not even for a burn of exactly the construction's length."""
    made = mission(7, number)
    ready = InsertionSetup.of(made.scenario)
    duration = made.burn_s / ready.units.time_s
    assert proof_of_infeasibility(ready.burn, ready.target, duration) is None
    state = CanonicalUnits.of().state_from_si(made.scenario.launch_inertial(made.scenario.target))
    largest = LargestOrbit.about(state, 0.0, is_direction_free=False)
    assert proof_of_infeasibility(ready.burn, largest, duration) is None


def laws() -> list[tuple[Mission, InsertionSetup]]:
    made = [mission(11, number) for number in range(10) if KINDS[number] != "null"]
    return [(each, InsertionSetup.of(each.scenario)) for each in made]


@pytest.mark.parametrize(("made", "ready"), laws(), ids=lambda value: getattr(value, "kind", ""))
def test_corrected_laws_end_on_the_orbit_by_an_independent_integrator(
    made: Mission, ready: InsertionSetup
) -> None:
    start = next(starts(ready.burn, ready.target))
    assert start.reaches
    assert start.law is not None
    law, duration_s = start.law, start.law.duration * ready.units.time_s
    end = propagate_burn(
        ready.start_si,
        made.scenario.vehicle.thruster(),
        lambda t, _x: law.directions(np.array([2.0 * t / duration_s - 1.0]))[0],
        np.array([duration_s]),
    )
    rows = ready.target.conditions(CanonicalUnits.of().state_from_si(end))[0]
    assert np.abs(rows).max() < 1e-8
    own = ends_of(ready.burn, law.coefficients[None], np.array([law.duration]), steps_for(law))
    np.testing.assert_allclose(own, CanonicalUnits.of().state_from_si(end), atol=1e-9)


def test_a_correction_changes_only_the_direction_of_a_law_and_meets_a_fixed_duration() -> None:
    _, ready = laws()[0]
    start = next(starts(ready.burn, ready.target))
    assert start.law is not None
    law, miss = corrected(ready.burn, ready.target, start.law.of_degree(2), free_duration=False)
    assert miss < 1e-9
    assert law.duration == start.law.duration


def test_one_scenario_has_one_answer() -> None:
    def numbers(found: Plan) -> tuple[float, list[float]]:
        return found.time_of_flight_s, found.trajectory.controls.ravel().tolist()

    case = scenario("apogee of a transfer orbit lowered")
    assert numbers(plan(case)) == numbers(plan(case))
