"""Independent flights: bounds between samples, the search for the worst instant, and the corrected flight about the Earth."""

from __future__ import annotations

import numpy as np
import pytest

import orbsoc
from orbsoc.guidance.uncertainty import Uncertainty
from orbsoc.missions.approach.model.approach import Approach
from orbsoc.missions.approach.model.instants import at_nodes
from orbsoc.missions.approach.model.nearest import Search
from orbsoc.missions.approach.model.problem import Forms, flown
from orbsoc.missions.approach.search.sequence import solve_convex
from orbsoc.missions.approach.verification.closed_loop import fly_corrected
from orbsoc.missions.approach.verification.linear import arcs, bends, chord_lengths
from tests.missions.approach.cases import planned, station

ERRORS = Uncertainty(position_m=0.3, velocity_m_s=2e-3, execution_share=0.01, seed=3)


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize("ecc", [0.0, 0.05])
def test_a_coast_bends_no_more_than_its_bound(seed: int, ecc: float) -> None:
    rng = np.random.default_rng(seed)
    at = Approach.of(station(target__eccentricity=ecc, safety__orbits=1.0))
    assert at.circular == (ecc == 0.0)
    state = np.concatenate([rng.uniform(-2e3, 2e3, 3), rng.uniform(-2.0, 2.0, 3)])
    times = np.linspace(100.0, 400.0, 31)
    states = np.array([at.motion.transition(t, 100.0) @ state for t in times])
    bend_m, bend_m_s = bends(at, times, states)
    middle = np.array([at.motion.transition(t, 100.0) @ state for t in 0.5 * (times[:-1] + times[1:])])
    away = middle - 0.5 * (states[:-1] + states[1:])
    assert np.linalg.norm(away[:, :3], axis=1).max() <= bend_m
    assert np.linalg.norm(away[:, 3:], axis=1).max() <= bend_m_s
    assert (
        bend_m <= (1.5 if not ecc else 6.0) * np.linalg.norm(away[:, :3], axis=1).max() + 0.5
    )  # and is no idle bound


def test_least_lengths_of_chords_are_those_of_dense_points() -> None:
    rng = np.random.default_rng(1)
    path = rng.standard_normal((40, 3))
    share = np.linspace(0.0, 1.0, 2001)[:, None, None]
    dense = np.linalg.norm(path[:-1] + share * np.diff(path, axis=0), axis=2).min(axis=0)
    np.testing.assert_allclose(chord_lengths(path), dense, atol=2e-3)
    assert (chord_lengths(path) <= dense + 1e-12).all()


@pytest.mark.parametrize("name", ["station_vbar", "station_rbar"])
def test_the_search_finds_what_a_dense_look_finds(name: str) -> None:
    """Of the flight that knows no keep-out."""
    at = Approach.of(station(name, keep_out__margin_m=45.0))
    free, row = solve_convex(at, Forms(at), at_nodes(at), orbsoc.solve)
    programme = free.programme(row.solution)
    dv = programme.dv_m_s
    broken = Search(at).broken(programme)
    margin = at.axes_m[0] + 45.0
    after, worst = flown(at, programme), 0.0
    grid = np.linspace(0.0, at.horizon_s, 3001)
    table = np.array([at.motion.transition(float(t), 0.0)[:3] for t in grid])
    for g in range(at.guarded):
        for fraction in np.linspace(0.0, 1.0, 101):
            state = after[g].copy()
            state[3:] -= (1.0 - fraction) * dv[g]
            worst = max(worst, margin - float(np.linalg.norm(table @ state, axis=1).min()))
    assert worst > 10.0
    assert broken.worst_m >= worst - 0.05
    assert broken.instants.keep_out


def test_a_flight_with_errors_depends_on_seed_and_run_alone() -> None:
    plan = planned()
    assert plan.programme is not None
    assert plan.verification is not None
    first, more = (
        fly_corrected(plan.approach, plan.programme, plan.verification.arcs, errors=ERRORS, runs=runs)
        for runs in (2, 4)
    )
    np.testing.assert_allclose(more.miss_m[:2], first.miss_m, rtol=1e-4)
    assert len(set(more.miss_m.round(9).tolist())) == 4


def test_dispersed_flights_of_a_verified_plan_stay_out_of_the_keep_out() -> None:
    plan = planned()
    assert plan.programme is not None
    assert plan.verification is not None
    flights = fly_corrected(plan.approach, plan.programme, plan.verification.arcs, errors=ERRORS, runs=60)
    assert flights.entered == 0
    assert flights.outside_m.min() > 20.0
    assert flights.miss_m.max() < 2.0
    assert flights.delta_v_m_s.min() > plan.cost * 0.9


def test_without_corrections_drag_and_j2_lead_astray() -> None:
    """What the corrections are for: the same programme flown open loop misses by metres."""
    plan = planned()
    assert plan.programme is not None
    assert plan.verification is not None
    closed = plan.verification.corrected
    assert closed.miss_m[0] < 0.05
    blind = Uncertainty(position_m=30.0, velocity_m_s=0.03, seed=1)
    lost = fly_corrected(plan.approach, plan.programme, plan.verification.arcs, errors=blind, runs=4)
    assert lost.miss_m.min() > 10.0 * closed.miss_m[0]
    assert arcs(plan.approach, plan.programme)[-1].states[-1, 1] == pytest.approx(-20.0)
