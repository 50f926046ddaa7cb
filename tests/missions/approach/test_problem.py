"""One pattern for all problems of a plan, whose rows say of a flight what the geometry says."""

from __future__ import annotations

import numpy as np
import pytest

import orbsoc
from orbsoc.conic.pattern import pattern_digest
from orbsoc.guidance.impulses import ImpulseProgramme
from orbsoc.missions.approach.model.approach import Approach
from orbsoc.missions.approach.model.instants import KINDS, Instant, Instants, Room, at_nodes
from orbsoc.missions.approach.model.problem import Forms, flown
from orbsoc.missions.approach.model.rows import ROOM_M, Reference
from orbsoc.missions.approach.search.sequence import solve_convex
from orbsoc.orbit.array import Array
from tests.missions.approach.cases import planned, station

OUT_OF_PLANE = {"start__y_m": 40.0}


@pytest.mark.parametrize("name", ["station_vbar", "station_rbar", "geo_servicing"])
def test_all_problems_of_a_plan_have_few_patterns(name: str) -> None:
    plan = planned(name)
    assert len(plan.subproblems) >= 9
    assert len({pattern_digest(row.problem) for row in plan.subproblems}) <= 4


@pytest.mark.parametrize("changes", [{}, OUT_OF_PLANE], ids=["planar", "not planar"])
def test_rows_of_a_flight_are_the_distances_of_its_states(changes: dict[str, float]) -> None:
    """After a random programme, of which the last impulse before each instant was flown by a fraction."""
    at, rng = Approach.of(station(**changes)), np.random.default_rng(4)
    assert at.planar == (not changes)
    dv = 0.02 * rng.standard_normal((at.times_s.size, 3))
    if at.planar:
        dv[:, 2] = 0.0
    programme = ImpulseProgramme(at.times_s, dv)
    after = flown(at, programme)
    asked = Instants(
        keep_out=(
            Instant(0, 3000.0, 0.3),
            Instant(4, 5000.0),
            Instant(4, 6000.0, 0.0),
            Instant(9, 8000.0, 0.7),
        ),
        corridor=(Instant(12, 6470.0), Instant(20, 7100.0)),
        speed=(Instant(15, 6700.0), Instant(29, 7800.0)),
        hold=(Instant(6, 5500.0), Instant(8, 6075.0)),
    )
    filled = Forms(at).form.filled(asked, Reference(at, programme, after), None, None)
    s = filled.problem.h - filled.problem.G @ _unknowns(at, filled, programme)
    scenario = at.scenario
    assert scenario.corridor is not None
    assert scenario.speed is not None
    for kind in ("keep_out", "corridor", "speed", "hold"):
        for each, rows in zip(asked.of(kind), filled.where[kind], strict=True):
            state = after[each.arc].copy()
            state[3:] -= (1.0 - each.fraction) * dv[each.arc]
            state = at.motion.transition(each.t_s, float(at.times_s[each.arc])) @ state
            range_m, speed = float(np.linalg.norm(state[:3])), float(np.linalg.norm(state[3:]))
            kept = float(s[rows][0] - np.linalg.norm(s[rows][1:]))
            wanted = {
                "keep_out": range_m - 245.0 - ROOM_M,
                "corridor": (float(scenario.corridor.depth(state[:3])) - 0.3 - ROOM_M)
                / np.cos(np.radians(10.0)),
                "speed": float(scenario.speed.limit(range_m)) - speed,
                "hold": 2.0 - ROOM_M - float(np.linalg.norm(state[:3] - scenario.gate.position())),
            }[kind]
            assert kept == pytest.approx(wanted, abs=1e-6)
    used = np.concatenate([filled.where[kind].ravel() for kind in KINDS])
    reserved = {
        int(row)
        for kind in KINDS
        for names in filled.form._names[kind]
        for name in names
        for row in filled.form.builder.rows(name)
    }
    idle = sorted(reserved - set(used.tolist()))
    assert idle
    assert not filled.problem.G.toarray()[idle].any()
    assert set(np.unique(filled.problem.h[idle])) <= {0.0, 1.0}


def _unknowns(at: Approach, filled: object, programme: ImpulseProgramme) -> Array:
    """The point of the problem that a programme is."""
    form = filled.form  # type: ignore[attr-defined]
    x = np.zeros(filled.problem.n)  # type: ignore[attr-defined]
    impulses, state = form.impulses, at.start
    for k, t in enumerate(at.times_s.tolist()):
        if k:
            state = at.motion.transition(t, float(at.times_s[k - 1])) @ state
        x[impulses.state_columns(k)] = state[impulses.driven] if k else []
        x[impulses.dv.index[k]] = programme.dv_m_s[k, list(impulses.axes)]
        state = state + np.concatenate([np.zeros(3), programme.dv_m_s[k]])
    return x


def test_a_flight_in_the_plane_costs_what_the_problem_with_all_axes_says() -> None:
    """A start a micrometre out of the plane has all three axes."""
    costs = []
    for y in (0.0, 1e-6):
        at = Approach.of(station(start__y_m=y))
        _, row = solve_convex(at, Forms(at), at_nodes(at), orbsoc.solve)
        costs.append(row.solution.objective)
    assert costs[0] == pytest.approx(costs[1], rel=1e-6)


def test_rows_that_matter_find_room_and_idle_ones_give_way() -> None:
    at = Approach.of(station())
    room, old = Room.of(at), tuple(Instant(2, 1000.0 * k) for k in range(3, 6))
    slacks = {kind: np.zeros(0) for kind in KINDS}
    more = Instants(keep_out=(Instant(2, 9000.0),))
    idle, same = room.fitted(Instants(keep_out=old), slacks | {"keep_out": np.array([0.0, 9.0, 0.01])}, more)
    assert same is room
    assert {each.t_s for each in idle.keep_out} == {3000.0, 5000.0, 9000.0}
    full, larger = room.fitted(Instants(keep_out=old), slacks | {"keep_out": np.zeros(3)}, more)
    assert len(full.keep_out) == 4
    assert larger.counts["keep_out"][2] == 4
    beside = Instants(keep_out=(Instant(2, 4001.0),))
    moved, same = room.fitted(Instants(keep_out=old), slacks | {"keep_out": np.zeros(3)}, beside)
    assert same is room
    assert 4000.0 not in {each.t_s for each in moved.keep_out}
