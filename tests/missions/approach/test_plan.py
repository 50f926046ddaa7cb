"""The plans of stations: what they claim holds on flights that neither planner nor verification has flown."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.linalg import expm

import orbsoc
from benchmarks.station_approaches import scenario
from orbsoc.conic.settings import Settings
from orbsoc.conic.solution import Status
from orbsoc.guidance.impulses import ImpulseProgramme
from orbsoc.guidance.mission import Auditable, Dispersible, PlanStatus
from orbsoc.guidance.scenario_file import ScenarioError, checked
from orbsoc.guidance.verdict import Question, Word
from orbsoc.interfaces import clarabel
from orbsoc.missions import approach
from orbsoc.missions.approach.model.problem import flown
from orbsoc.missions.approach.plan import Plan
from orbsoc.missions.approach.scenario import Scenario
from orbsoc.missions.approach.verification.cuts import audit_cuts
from orbsoc.missions.registry import MISSIONS
from orbsoc.orbit.array import Array
from tests.missions.approach.cases import STATIONS, planned, station
from tests.missions.verdict_rules import assert_rules

PROXOPS: dict[str, Any] = {
    "mission": "approach",
    "name": "proxops",
    "target": {"mean_motion_rad_s": float(np.sqrt(3.986004418e14 / 6.778e6**3))},
    "start": {"x_m": -100.0, "vx_m_s": 2.0},
    "points": {
        "entry": {"z_m": 25.0, "arrive_s": 120.0, "impulses": 40},
        "dock": {"vz_m_s": 0.0, "arrive_s": 177.0, "impulses": 19},
    },
    "keep_out": {"radius_m": 20.0, "until": "entry"},
    "corridor": {"axis": "+R-bar", "half_angle_deg": 20.0},
    "engine": {"largest_m_s": 0.3, "limit": "axes"},
    "safety": {"orbits": 0.0},
}


def steps(rate: float, state: Array, step_s: float, count: int) -> Array:
    """States (count + 1, 6) by the matrix exponential of Hill's equations."""
    motion = np.zeros((6, 6))
    motion[:3, 3:] = np.eye(3)
    motion[3, [0, 4]] = 3.0 * rate**2, 2.0 * rate
    motion[4, 3] = -2.0 * rate
    motion[5, 2] = -(rate**2)
    one = expm(motion * step_s)
    found = [state]
    for _ in range(count):
        found.append(one @ found[-1])
    return np.array(found)


def arcs(plan: Plan) -> list[Array]:
    """States (M, 6) of every arc, a second or so apart."""
    assert plan.programme is not None
    ends = [*plan.programme.times_s[1:].tolist(), plan.approach.duration_s]
    state, found = plan.approach.start, []
    for t, dv, end in zip(plan.programme.times_s.tolist(), plan.programme.dv_m_s, ends, strict=True):
        count = int(np.ceil(end - t))
        kicked = np.concatenate([state[:3], state[3:] + dv])
        found.append(steps(plan.approach.mean_motion_rad_s, kicked, (end - t) / count, count))
        state = found[-1][-1]
    return found


def before_gate(plan: Plan, flown: Sequence[Array]) -> tuple[Sequence[Array], Sequence[Array]]:
    count = plan.approach.guarded
    return flown[:count], flown[count:]


@pytest.mark.parametrize("name", STATIONS)
def test_a_station_is_approached_and_every_abort_is_safe(name: str) -> None:
    plan = planned(name)
    assert plan.status is PlanStatus.VERIFIED
    assert_rules(plan.verdict, plan.status)
    assert plan.verdict.word(Question.SAFETY) is Word.SAFE
    assert plan.verification is not None
    assert not plan.verification.unsafe_aborts


@pytest.mark.parametrize("name", STATIONS)
def test_every_condition_holds_on_a_dense_flight(name: str) -> None:
    plan, scenario = planned(name), planned(name).scenario
    flown = arcs(plan)
    outside, inside = before_gate(plan, flown)
    assert min(np.linalg.norm(arc[:, :3], axis=1).min() for arc in outside) >= 200.0
    assert scenario.corridor is not None
    assert scenario.speed is not None
    assert (
        min(scenario.corridor.depth(arc[:, :3]).min() for arc in inside) >= scenario.corridor.margin_m - 2e-3
    )
    for arc in flown:
        ranges, speeds = np.linalg.norm(arc[:, :3], axis=1), np.linalg.norm(arc[:, 3:], axis=1)
        assert (speeds <= scenario.speed.limit(ranges) + 2e-5).all()
    last = list(scenario.points.values())[-1]
    np.testing.assert_allclose(flown[-1][-1, :3], last.position(), atol=1e-5)
    velocity = last.velocity()
    assert velocity is not None
    np.testing.assert_allclose(flown[-1][-1, 3:], velocity, atol=1e-8)
    times = plan.approach.times_s
    held = [
        arc
        for t, arc in zip(times, flown, strict=True)
        if scenario.gate.arrive_s <= t < scenario.gate.leave_s
    ]
    away = [np.linalg.norm(arc[:, :3] - scenario.gate.position(), axis=1).max() for arc in held]
    assert max(away) <= scenario.gate.hold_within_m + 2e-3


@pytest.mark.parametrize("name", STATIONS)
def test_a_hundred_random_cuts_drift_no_nearer_than_was_said(name: str) -> None:
    plan = planned(name)
    assert plan.programme is not None
    assert plan.verification is not None
    said = plan.verification.least_cut_m
    assert said >= 200.0
    outside, _ = before_gate(plan, arcs(plan))
    rng = np.random.default_rng(48)
    for _ in range(100):
        k, fraction = int(rng.integers(len(outside))), float(rng.random())
        state = outside[k][0].copy()
        state[3:] -= (1.0 - fraction) * plan.programme.dv_m_s[k]
        period = plan.approach.period_s
        drift = steps(plan.approach.mean_motion_rad_s, state, period / 2000.0, 2000)
        assert np.linalg.norm(drift[:, :3], axis=1).min() >= said - 1e-3


@pytest.mark.parametrize("name", STATIONS)
def test_after_an_abort_the_chaser_leaves_and_stays_out_and_off_the_body(name: str) -> None:
    plan = planned(name)
    assert plan.verification is not None
    inside = 0
    for each in plan.verification.aborts:
        assert each.dv_m_s is not None
        assert each.safe == (not each.dv_m_s.any())
        state = each.state + np.concatenate([np.zeros(3), each.dv_m_s])
        ranges = np.linalg.norm(
            steps(plan.approach.mean_motion_rad_s, state, plan.approach.period_s / 2000.0, 2000)[:, :3],
            axis=1,
        )
        out = np.flatnonzero(ranges >= 200.0)
        assert out.size
        assert ranges.min() >= plan.scenario.keep_out.body_m - 0.011
        assert ranges[out[0] :].min() >= 200.0 - 0.011
        inside += bool(ranges[0] < 200.0)
    assert inside >= 10


def test_what_is_safe_for_all_time_is_so_after_twenty_orbits() -> None:
    plan = approach.plan(station(safety__all_time=True))
    assert plan.status is PlanStatus.VERIFIED
    assert plan.programme is not None
    outside, _ = before_gate(plan, arcs(plan))
    for k, arc in enumerate(outside):
        for fraction in (0.0, 0.3, 0.7, 1.0):
            state = arc[0].copy()
            state[3:] -= (1.0 - fraction) * plan.programme.dv_m_s[k]
            drift = steps(plan.approach.mean_motion_rad_s, state, plan.approach.period_s / 300.0, 6000)
            assert np.linalg.norm(drift[:, :3], axis=1).min() >= 200.0


def test_safer_costs_more_and_never_less_than_the_bound() -> None:
    costs = [
        approach.plan(station(**changes)).cost
        for changes in (
            {"safety__orbits": 0.0},
            {"safety__cut_burns": False},
            {},
            {"safety__orbits": 2.0},
        )
    ]
    assert costs == sorted(costs)
    bound = planned().lower_bound
    assert bound is not None
    assert bound < costs[0]


def test_drifts_that_grow_longer_lead_to_a_cheaper_plan_than_one_side_does() -> None:
    plan = planned()
    costs = {each.side: each.reference.cost for each in plan.attempts if each.found and not each.drawn}
    assert set(costs) == {"on the gate's side", "drift by drift"}
    assert plan.cost == pytest.approx(min(costs.values()), rel=1e-6)
    assert costs["drift by drift"] < 0.95 * costs["on the gate's side"]


def test_without_keep_out_in_the_way_the_bound_is_met() -> None:
    """From 600 m on the V-bar, with a small sphere and no drifts asked for, nothing but convex conditions is left."""
    plan = approach.plan(
        station(
            start__x_m=-600.0, keep_out__radius_m=50.0, keep_out__margin_m=0.0, safety__orbits=0.0, speed=None
        )
    )
    assert plan.status is PlanStatus.VERIFIED
    assert plan.verdict.word(Question.OPTIMUM) is Word.BOUND
    assert plan.lower_bound is not None
    assert plan.cost == pytest.approx(plan.lower_bound, rel=1e-3)


def test_each_conic_problem_has_clarabels_optimum() -> None:
    for row in planned().subproblems:
        theirs = clarabel.solve(row.problem, Settings(tol=1e-9))
        if Status.PRIMAL_INFEASIBLE in (row.solution.status, theirs.status):
            assert row.solution.status is theirs.status
            continue
        assert row.solution.objective == pytest.approx(theirs.objective, rel=1e-6)


def test_a_programme_made_elsewhere_is_judged_as_the_plan_is() -> None:
    plan = planned()
    assert plan.programme is not None
    again = approach.audit(plan.scenario, plan.programme.without_small(1e-7))
    assert again.status is PlanStatus.VERIFIED
    assert again.cost == pytest.approx(plan.cost)
    worse = plan.programme.dv_m_s.copy()
    worse[0] *= 1.1
    assert (
        approach.audit(plan.scenario, ImpulseProgramme(plan.programme.times_s, worse)).status
        is PlanStatus.NOT_VERIFIED
    )
    with pytest.raises(ScenarioError, match="must lie within 0 and the arrival at the last point, 7800"):
        approach.audit(plan.scenario, ImpulseProgramme([0.0, 7800.0], [[0.1, 0.0, 0.0]] * 2))


@pytest.mark.parametrize(
    ("changes", "status", "says"),
    [
        ({"engine__largest_m_s": 0.02}, PlanStatus.INFEASIBLE, "engine"),
        ({"points__S2__hold_within_m": 1e-3, "start__vx_m_s": 50.0}, PlanStatus.INFEASIBLE, "engine"),
        (
            {"safety__orbits": 2.0, "engine__largest_m_s": 0.15},
            PlanStatus.NOT_FOUND,
            "no flight keeps every condition",
        ),
    ],
)
def test_what_cannot_be_flown_is_a_status_with_its_reason(
    changes: dict[str, float], status: PlanStatus, says: str
) -> None:
    plan = approach.plan(station(**changes))
    assert plan.status is status
    assert says in plan.message
    assert_rules(plan.verdict, plan.status)
    assert plan.tables() == {}
    json.dumps(plan.to_dict())


def test_interrupt_is_told() -> None:
    def solve(problem: orbsoc.Problem, settings: Settings | None = None, /) -> orbsoc.Solution:
        raise KeyboardInterrupt

    assert approach.plan(station(), solve=solve).status is PlanStatus.INTERRUPTED


def test_the_mission_has_cases_audits_tables_and_figures(tmp_path: Path) -> None:
    for protocol in (Dispersible, Auditable):
        assert isinstance(MISSIONS["approach"], protocol)
    plan = planned()
    assert set(plan.tables()) == {"impulses.csv", "aborts.csv", "chaser.oem", "chaser.opm"}
    assert plan.verification is not None
    assert plan.tables()["aborts.csv"].count("\n") == 1 + len(plan.verification.aborts)
    figures = plan.figures(tmp_path)
    assert [each.name for each in figures] == [
        "approach.png",
        "abort_fan.png",
        "speed.png",
        "aborts.png",
        "space.png",
    ]
    assert all((tmp_path / each.name).stat().st_size > 10_000 for each in figures)
    assert replace(plan, verification=None).figures(tmp_path) == ()


def test_public_proxops_data_cost_less_and_keep_the_cone() -> None:
    """OpenSCvx's `proxops_cw`: 0.1 m/s² an axis is 0.3 m/s in 3 s. Its example ends with 6.33 m/s, and 1.7 m outside the cone
    between its nodes (version 0.5.2, 3 nodes, 177 s; it asks for no least fuel)."""
    plan = approach.plan(checked(Scenario, PROXOPS, source="proxops"))
    assert plan.status is PlanStatus.VERIFIED
    assert plan.programme is not None
    assert np.abs(plan.programme.dv_m_s).max() <= 0.3 + 1e-9
    assert plan.cost < 2.8
    corridor = plan.scenario.corridor
    assert corridor is not None
    _, inside = before_gate(plan, arcs(plan))
    assert min(corridor.depth(arc[:, :3]).min() for arc in inside) >= -1e-4
    assert np.abs(np.concatenate(arcs(plan))[:, 3:]).max() <= 2.0
    assert plan.verdict.word(Question.OPTIMUM) is Word.BOUND


def test_an_ellipsoid_on_an_eccentric_orbit_is_kept_out_of() -> None:
    plan = planned("elliptic_servicing")
    assert plan.status is PlanStatus.VERIFIED
    assert plan.programme is not None
    assert plan.verification is not None
    at, motion = plan.approach, plan.approach.motion
    said = plan.verification.least_cut_m / plan.verification.keep_out_m
    assert said >= 1.0
    after, rng = flown(at, plan.programme), np.random.default_rng(9)
    for _ in range(100):
        k, fraction = int(rng.integers(at.guarded)), float(rng.random())
        state = after[k].copy()
        state[3:] -= (1.0 - fraction) * plan.programme.dv_m_s[k]
        first = float(at.times_s[k])
        times = np.linspace(first, first + at.horizon_s, 400)
        places = np.array([motion.transition(t, first)[:3] @ state for t in times.tolist()])
        assert at.size(places).min() >= said - 1e-4


def test_cuts_by_pieces_of_time_are_those_of_the_branch_and_bound() -> None:
    plan = planned()
    assert plan.programme is not None
    assert plan.verification is not None
    known = {cut.number: cut for cut in plan.verification.cuts}
    burns = plan.programme.first(plan.approach.guarded)
    for cut in audit_cuts(plan.approach, burns, plan.approach.horizon_s):
        if cut.number in known:
            assert cut.distance_m == pytest.approx(known[cut.number].distance_m, abs=3e-3)
            assert cut.completed_m == pytest.approx(known[cut.number].completed_m, abs=3e-3)
            assert cut.at_least_m is not None
            assert cut.at_least_m <= known[cut.number].distance_m + 1e-9


def test_servicing_in_geostationary_orbit_meets_its_bound() -> None:
    plan = planned("geo_servicing")
    assert plan.status is PlanStatus.VERIFIED
    assert plan.verdict.word(Question.SAFETY) is Word.SAFE
    assert plan.verdict.word(Question.OPTIMUM) is Word.BOUND


FROM_THE_VBAR = {
    "start__z_m": 0.0, "start__vx_m_s": 0.0, "points__R1__arrive_s": 5400.0, "points__contact__arrive_s": 7500.0,
}  # fmt: skip
"""To the gate below the station, in an orbit."""
TO_THE_OTHER_SIDE = FROM_THE_VBAR | {
    "points__R1__z_m": 0.0, "points__R1__x_m": 250.0, "points__contact__z_m": 0.0, "points__contact__x_m": 20.0,
    "points__contact__vz_m_s": 0.0, "points__contact__vx_m_s": -0.1, "corridor__axis": "+V-bar",
}  # fmt: skip
"""To a gate in front of the station."""


@pytest.mark.parametrize(
    ("behind_m", "changes"), [(3000.0, FROM_THE_VBAR), (1000.0, FROM_THE_VBAR), (3000.0, TO_THE_OTHER_SIDE)]
)
def test_from_the_vbar_a_gate_below_or_in_front_is_reached_about_the_keep_out(
    behind_m: float, changes: dict[str, Any]
) -> None:
    plan = approach.plan(station("station_rbar", start__x_m=-behind_m, **changes))
    assert plan.status is PlanStatus.VERIFIED
    assert plan.programme is not None
    assert plan.verification is not None
    said, rng = plan.verification.least_cut_m, np.random.default_rng(5)
    assert said >= 200.0
    outside, _ = before_gate(plan, arcs(plan))
    for _ in range(100):
        k, fraction = int(rng.integers(len(outside))), float(rng.random())
        state = outside[k][0].copy()
        state[3:] -= (1.0 - fraction) * plan.programme.dv_m_s[k]
        drift = steps(plan.approach.mean_motion_rad_s, state, plan.approach.period_s / 2000.0, 2000)
        assert np.linalg.norm(drift[:, :3], axis=1).min() >= said - 1e-3


def test_a_half_space_is_kept_between_instants_and_costs_more() -> None:
    """After the gate no place is more than 10 m below the V-bar, where hops would fall by more."""
    plan = approach.plan(station(half_space__z=-1.0, half_space__at_least_m=-10.0, half_space__after="S2"))
    assert plan.status is PlanStatus.VERIFIED
    free = planned()
    assert plan.cost > free.cost
    lowest = []
    for each in (plan, free):
        gate_s = each.scenario.gate.arrive_s
        flown = [arc for t, arc in zip(each.approach.times_s, arcs(each), strict=True) if t >= gate_s]
        lowest.append(min(float(arc[:, 0].min()) for arc in flown))
    assert lowest[0] >= -10.0 - 2e-3
    assert lowest[1] < -15.0
    assert plan.verification is not None
    check = next(each for each in plan.verification.checks if each.name == "half-space")
    assert check.kept


def test_a_flight_beside_the_orbital_plane_is_found_where_it_costs_less() -> None:
    """From in front and above to a point above, all in the orbital plane: drifts pass beside the keep-out (its 73rd random approach)."""
    plan = approach.plan(checked(Scenario, scenario(73), source="random 73"))
    costs = {each.side: each.reference.cost for each in plan.attempts if each.found and not each.drawn}
    across = costs.pop("across the orbital plane")
    assert plan.status is PlanStatus.VERIFIED
    assert plan.cost <= across * (1.0 + 1e-6)
    assert across < 0.99 * min(costs.values())
    assert plan.programme is not None
    assert np.abs(plan.programme.dv_m_s[:, 2]).max() > 0.1
    assert plan.lower_bound is not None
    assert plan.lower_bound < plan.cost


def test_a_flight_in_front_of_the_target_and_back_is_found_where_it_costs_less() -> None:
    """From behind to a gate below: all starts but those about draws lead straight there (its 155th random approach)."""
    plan = approach.plan(checked(Scenario, scenario(155), source="random 155"))
    assert plan.status is PlanStatus.VERIFIED
    assert plan.programme is not None
    costs = {
        drawn: min(each.reference.cost for each in plan.attempts if each.found and each.drawn is drawn)
        for drawn in (False, True)
    }
    assert plan.cost == pytest.approx(costs[True], rel=1e-6)
    assert costs[True] < 0.85 * costs[False]
    radius, along = float(plan.approach.outer_m[0]), flown(plan.approach, plan.programme)[:, 1]
    assert along[0] < -4.0 * radius
    assert along.max() > 2.0 * radius
