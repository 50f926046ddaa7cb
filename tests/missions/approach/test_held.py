"""Thrust that is held: the plan flown by the matrix exponential, cuts beside samples of all instants, and what is refused."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.linalg import expm

from orbsoc.guidance.impulses import ImpulseProgramme
from orbsoc.guidance.mission import PlanStatus
from orbsoc.guidance.scenario_file import ScenarioError, checked
from orbsoc.guidance.verdict import Question, Word
from orbsoc.missions import approach
from orbsoc.missions.approach.model.approach import Approach
from orbsoc.missions.approach.model.instants import Instant, Instants
from orbsoc.missions.approach.model.nearest import Search
from orbsoc.missions.approach.model.problem import Forms, flown
from orbsoc.missions.approach.model.rows import ROOM_M, Reference
from orbsoc.missions.approach.plan import Plan
from orbsoc.missions.approach.scenario import Scenario
from orbsoc.missions.approach.verification import held_cuts
from orbsoc.missions.approach.verification.cuts import WITHIN_M
from orbsoc.missions.approach.verification.held_cuts import audit_held
from orbsoc.missions.approach.verification.linear import arcs
from orbsoc.orbit.array import Array
from tests.missions.approach.cases import station
from tests.missions.approach.test_plan import steps
from tests.missions.verdict_rules import assert_rules

BRIEF: dict[str, Any] = {
    "mission": "approach",
    "name": "brief",
    "target": {"altitude_km": 420.0, "inclination_deg": 51.6},
    "start": {"x_m": -1500.0},
    "points": {
        "gate": {
            "x_m": -300.0, "vx_m_s": 0.0, "arrive_s": 4500.0, "impulses": 6, "hold_s": 600.0, "hold_impulses": 2,
        },
        "near": {"x_m": -280.0, "arrive_s": 5700.0, "impulses": 6},
    },
    "keep_out": {"radius_m": 200.0, "until": "gate", "margin_m": 60.0},
    "engine": {"thrust": "held", "largest_m_s2": 1e-3},
    "safety": {"orbits": 1.0, "abort_every_s": 600.0},
}  # fmt: skip


@cache
def brief() -> Plan:
    return approach.plan(checked(Scenario, BRIEF, source="brief"))


def pushed(rate: float, state: Array, push: Array, lasts_s: float) -> Array:
    """A state (6,) after an acceleration (3,) was held, by the matrix exponential of Hill's equations."""
    motion = np.zeros((7, 7))
    motion[:3, 3:6] = np.eye(3)
    motion[3, [0, 4]] = 3.0 * rate**2, 2.0 * rate
    motion[4, 3], motion[5, 2] = -2.0 * rate, -(rate**2)
    motion[3:6, 6] = push
    return np.asarray((expm(motion * lasts_s) @ np.append(state, 1.0))[:6])


def starts(plan: Plan) -> tuple[list[Array], Array]:
    """States at the beginnings of arcs and at the end, and the accelerations (K, 3), from thrust.csv."""
    table = np.array([[float(cell) for cell in line.split(",")] for line in _rows(plan)])
    found = [plan.approach.start]
    for a, b, *push in table:
        found.append(pushed(plan.approach.mean_motion_rad_s, found[-1], np.array(push), b - a))
    return found, table[:, 2:]


def _rows(plan: Plan) -> list[str]:
    return plan.tables()["thrust.csv"].splitlines()[1:]


def test_the_plan_keeps_its_conditions_on_another_flight() -> None:
    """Points, limit, the integral of the norm, and drifts after cuts at random, none nearer than told."""
    plan = brief()
    assert plan.status is PlanStatus.VERIFIED, plan.message
    assert plan.verification is not None
    states, pushes = starts(plan)
    at, n = plan.approach, plan.approach.mean_motion_rad_s
    lasts = at.ends_s - at.times_s
    assert np.linalg.norm(states[6][:3] - [0.0, -300.0, 0.0]) < 1e-4
    assert np.linalg.norm(states[6][3:]) < 1e-6
    assert np.linalg.norm(states[-1][:3] - [0.0, -280.0, 0.0]) < 1e-4
    sizes = np.linalg.norm(pushes, axis=1)
    assert sizes.max() <= 1e-3 * (1.0 + 1e-6)
    assert plan.cost == pytest.approx(float((sizes * lasts).sum()), rel=1e-9)
    rng = np.random.default_rng(2)
    for k in range(at.guarded):
        cut = next((each for each in plan.verification.cuts if each.number == k + 1), None)
        for share in rng.random(6):
            state = pushed(n, states[k], pushes[k], float(share * lasts[k]))
            drift = steps(n, state, 10.0, int(at.horizon_s / 10.0))
            nearest = float(np.linalg.norm(drift[:, :3], axis=1).min())
            assert nearest >= 260.0 - 0.01
            assert cut is None or nearest >= (cut.at_least_m or 0.0)
    assert any(0.0 < cut.fraction < 1.0 and cut.distance_m < 260.01 for cut in plan.verification.cuts)


def test_rows_of_a_cut_are_the_distances_of_its_states() -> None:
    """Before the cut the flight, after it the drift: by the matrix exponential."""
    at = Approach.of(checked(Scenario, BRIEF, source="brief"))
    dv = 0.05 * np.random.default_rng(4).standard_normal((at.times_s.size, 3))
    dv[:, 2] = 0.0
    programme = ImpulseProgramme(at.times_s, dv)
    begun, n = flown(at, programme), at.mean_motion_rad_s
    asked = Instants(keep_out=(Instant(0, 3000.0, 0.3), Instant(2, 1900.0), Instant(4, 6000.0, 0.8)))
    filled = Forms(at).form.filled(asked, Reference(at, programme, begun), None, None)
    x = np.zeros(filled.problem.n)
    impulses = filled.form.impulses
    for k in range(at.times_s.size):
        x[impulses.state_columns(k)] = begun[k, :6][impulses.driven] if k else []
        x[impulses.dv.index[k]] = dv[k, :2]
    s = filled.problem.h - filled.problem.G @ x
    for each, rows in zip(asked.keep_out, filled.where["keep_out"], strict=True):
        lasts = float(at.ends_s[each.arc] - at.times_s[each.arc])
        lapse = each.t_s - float(at.times_s[each.arc])
        cut = min(each.fraction * lasts, lapse)
        state = pushed(n, begun[each.arc, :6], dv[each.arc] / lasts, cut)
        state = pushed(n, state, np.zeros(3), lapse - cut)
        assert s[rows][0] == pytest.approx(np.linalg.norm(state[:3]) - 260.0 - ROOM_M, abs=1e-6)


def test_the_nearest_cut_is_below_all_samples_and_the_search_finds_it() -> None:
    """Random pushes of which some lead past the target: the bound is below 200 cuts by 400 times, and reached to 2 mm."""
    at = Approach.of(checked(Scenario, BRIEF, source="brief"))
    dv = 0.1 * np.random.default_rng(10).standard_normal((at.times_s.size, 3))
    programme = ImpulseProgramme(at.times_s, dv)
    flight, begun = arcs(at, programme), flown(at, programme)
    which, reached = np.array([0, 3, 5]), 0
    searched: dict[int, list[float]] = {k: [] for k in which.tolist()}
    for instant, depth in Search(at)._held.nearest(begun, None):
        searched.get(instant.arc, []).append(depth + 260.0)
    for k, cut in zip(which.tolist(), audit_held(at, programme, flight, which), strict=True):
        fractions, lapses = np.linspace(0.0, 1.0, 200), np.linspace(0.0, at.horizon_s, 400)
        lasts = float(at.ends_s[k] - at.times_s[k])
        f, h = (each.ravel() for each in np.meshgrid(fractions, lapses))
        to = at.responses(at.times_s[k] + f * lasts + h, np.full(f.size, k), f)[:, :3]
        away = np.linalg.norm(to @ begun[k], axis=1)
        assert cut.at_least_m == pytest.approx(cut.distance_m - WITHIN_M)
        assert cut.at_least_m <= away.min() <= cut.distance_m + 1.0
        assert cut.completed_m >= cut.distance_m - 1e-9
        if cut.distance_m < 300.0:
            reached += 1
            assert min(searched[k]) == pytest.approx(cut.distance_m, abs=5e-3)
    assert reached


def test_the_verdict_says_what_thrust_that_is_held_has_not() -> None:
    """No abort impulse; where a drift is not safe by itself the plan is safe in part, at most."""
    plan = brief()
    assert_rules(plan.verdict, plan.status)
    assert plan.verification is not None
    assert plan.verification.bounded
    (safety,) = [line for line in plan.verdict.lines if line.question is Question.SAFETY]
    unsafe = [each for each in plan.verification.aborts if not each.safe]
    assert (safety.word is Word.SAFE) == (not unsafe and plan.verification.drift_with_j2_m >= 0.0)
    assert all(each.dv_m_s is None for each in unsafe)
    assert "m/s²" in str(plan.verdict)
    document = plan.to_dict()
    assert document["impulses"] == []
    assert len(document["thrust"]) == plan.approach.times_s.size
    assert set(plan.tables()) == {"thrust.csv", "aborts.csv"}


def test_drifts_that_are_not_known_from_below_are_told(monkeypatch: pytest.MonkeyPatch) -> None:
    """With one round of the branch and bound the bound stays below, holds all the same, and the plan is safe in part."""
    plan = brief()
    assert plan.programme is not None
    assert plan.verification is not None
    monkeypatch.setattr(held_cuts, "ROUNDS", 1)
    which = np.array([cut.number - 1 for cut in plan.verification.cuts])
    rough = held_cuts.audit_held(plan.approach, plan.programme, plan.verification.arcs, which)
    told = replace(plan, verification=replace(plan.verification, cuts=rough))
    assert told.verification is not None
    assert not told.verification.bounded
    for cut, known in zip(rough, plan.verification.cuts, strict=True):
        assert (cut.at_least_m or 0.0) <= known.distance_m <= cut.distance_m + WITHIN_M
    (safety,) = [line for line in told.verdict.lines if line.question is Question.SAFETY]
    assert safety.word is Word.PARTLY
    assert "not known from below" in safety.evidence


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"engine__largest_m_s2": None}, "engine.largest_m_s2: must be given with engine.thrust = 'held'"),
        ({"engine__largest_m_s2": -1.0}, "engine.largest_m_s2 = -1.0: Input should be greater than 0"),
        ({"engine__thrust": "pulsed"}, "engine.thrust = 'pulsed': Input should be 'impulses' or 'held'"),
        ({"engine__thrust": "impulses"}, "engine.largest_m_s2 = 0.0005: impulses have a size in m/s"),
        ({"engine__largest_m_s": 1.0}, "engine.largest_m_s = 1: thrust that is held has a limit in m/s²"),
        ({"safety__all_time": True}, "safety.all_time = true: thrust that is held is judged for some orbits"),
        ({"safety__abort_m_s": 0.5}, "safety.abort_m_s = 0.5: an abort is an impulse; leave it out"),
        (
            {"engine__largest_m_s": 10.0},
            "engine.largest_m_s = 10: thrust that is held has a limit in m/s²",
        ),  # the default, given
        ({"safety__abort_m_s": 1.0}, "safety.abort_m_s = 1: an abort is an impulse; leave it out"),
        ({"target__eccentricity": 0.01}, "engine.thrust = 'held': is planned about a circular target alone"),
        (
            {"uncertainty": {"position_m": 1.0, "velocity_m_s": 1e-3, "runs": 0}},
            "uncertainty: errors of impulses alone are known",
        ),
    ],
)
def test_what_does_not_go_with_it_is_refused(changes: dict[str, Any], says: str) -> None:
    with pytest.raises(ScenarioError) as error:
        station("station_held", **changes)
    assert says in str(error.value)


def test_programmes_of_impulses_and_closed_loops_are_refused() -> None:
    scenario = station("station_held")
    with pytest.raises(ScenarioError, match=r"engine.thrust = 'held': a programme of impulses cannot"):
        approach.audit(scenario, ImpulseProgramme([0.0], [[0.0, 0.1, 0.0]]))
    with pytest.raises(ScenarioError, match=r"engine.thrust = 'held': a closed loop plans impulses again"):
        approach.closed_loop(scenario, None)  # type: ignore[arg-type]
