"""How many pulses, with the proof: the paper's ellipse, tighter and looser, natural ones, uncertain ones."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import orbsoc
from orbsoc.guidance.impulses import Impulses
from orbsoc.missions.fly_around import PlanStatus, plan
from orbsoc.missions.fly_around.model.flight import fly
from orbsoc.missions.fly_around.search.pulses import Search, Searcher, search
from orbsoc.missions.fly_around.search.times import least_error
from orbsoc.missions.fly_around.search.tube import (
    NoTube,
    Revolution,
    Tube,
    cheapest,
    solve_tube,
    tube_impulses,
)

from .baseline import planned, scenario

PAPER = scenario()
FLIGHT, START = PAPER.flight, PAPER.start_state
WHOLE = Revolution(FLIGHT, START, 1800.0, orbsoc.solve)
TIMES_13 = [
    0, 108.64, 241.13, 386.96, 545.74, 693.43, 826.97, 954.34, 1083.18, 1222.71, 1377.70, 1532.49, 1671.03,
]  # fmt: skip


def found(pulses: int | None = None, **changes: Any) -> Search:
    return search(Searcher(scenario(**changes), orbsoc.solve, lambda _: None), pulses)


def test_13_pulses_are_the_fewest_by_proof() -> None:
    best = planned("fewest").search
    assert best is not None
    assert best.found is not None
    assert (best.pulses, best.certified, best.impossible) == (13, True, 12)
    assert best.impossible_below_m == pytest.approx(2.2997, abs=6e-5)
    assert best.found.programme.total_m_s == pytest.approx(3.205, abs=5e-4)
    dense = fly(FLIGHT, START, best.found.programme, 1800.0, 4000)
    assert dense.largest_error_m <= 2.0 + 1e-4


def test_12_pulses_are_refused_with_the_proof() -> None:
    none = found(12)
    assert none.found is None
    assert none.impossible == 12
    assert none.impossible_below_m == pytest.approx(2.2997, abs=6e-5)


@pytest.mark.parametrize(("pulses", "dv_m_s"), [(14, 3.191), (16, 3.183), (20, 3.177), (60, 3.162)])
def test_more_pulses_cost_less_down_to_the_floor(pulses: int, dv_m_s: float) -> None:
    best = found(pulses).found
    assert best is not None
    assert dv_m_s - 2.5e-3 <= best.programme.total_m_s <= dv_m_s + 5e-4
    assert fly(FLIGHT, START, best.programme, 1800.0, 500).largest_error_m <= 2.0 + 1e-4


@pytest.mark.parametrize(("pulses", "error_m"), [(12, 2.3494), (13, 1.9939), (14, 1.7136)])
def test_times_of_least_error(pulses: int, error_m: float) -> None:
    from .test_fewest import bound

    times = bound(pulses).times_s[:-1]
    best = least_error(WHOLE, times)
    assert isinstance(best, Tube)
    assert best.error_m == pytest.approx(error_m, abs=5e-4)
    assert bound(pulses).bound_m <= best.error_m


def test_the_tube_at_known_times_with_many_samples() -> None:
    """Times found by another optimiser: 1.994 m at 24 samples an arc, 1.995 m between them."""
    best = solve_tube(replace(WHOLE, samples=24), np.array(TIMES_13), "error")
    assert isinstance(best, Tube)
    assert best.solution.objective == pytest.approx(1.9938, abs=2e-4)
    assert best.error_m == pytest.approx(1.9949, abs=2e-4)


@pytest.mark.parametrize("samples", [6, 8, 24])
def test_few_samples_and_margins_between_them_cost_nothing(samples: int) -> None:
    programme = planned("fewest").search
    assert programme is not None
    assert programme.found is not None
    times = programme.found.programme.times_s
    best = cheapest(replace(WHOLE, samples=samples), times, 2.0)
    assert isinstance(best, Tube)
    assert best.error_m <= 2.0 + 2e-5
    assert best.programme.total_m_s == pytest.approx(3.205, abs=2e-4)


def test_the_floor_of_a_grid_of_180_pulses() -> None:
    """One sample an arc, nothing between them: 3.1590 m/s."""
    times = np.linspace(0.0, 1800.0, 181)[:-1]
    problem = tube_impulses(replace(WHOLE, samples=1), times, "dv", 2.0).builder.build()
    assert orbsoc.solve(problem).objective == pytest.approx(3.1590, abs=5e-5)


def test_re_plans_of_one_pattern_start_warm() -> None:
    """From states that are off by 0.1 m and 2 mm/s: the pattern stays, and half the iterations do."""
    programme = planned("fewest").search
    assert programme is not None
    assert programme.found is not None
    times = programme.found.programme.times_s

    def problem(start: np.ndarray) -> orbsoc.Problem:
        return tube_impulses(replace(WHOLE, start=start), times, "dv", 2.3).builder.build()

    nominal = problem(START)
    base = orbsoc.solve(nominal)
    solver = orbsoc.Solver(nominal)
    rng = np.random.default_rng(0)
    cold, warm = 0, 0
    for _ in range(10):
        moved = problem(START + np.concatenate([0.1 * rng.normal(size=3), 2e-3 * rng.normal(size=3)]))
        solver.update(b=moved.b, h=moved.h)
        again, fresh = solver.solve(warm_start=base), orbsoc.solve(moved)
        assert again.objective == pytest.approx(fresh.objective, abs=1e-6)
        cold += fresh.iterations
        warm += again.iterations
    assert warm <= 0.6 * cold


def test_a_tube_without_a_flight_says_which_arcs_are_too_long() -> None:
    none = solve_tube(WHOLE, np.linspace(0.0, 1800.0, 10)[:-1], "dv", 2.0)
    assert isinstance(none, NoTube)
    assert none.reason.startswith("the constraints cannot be met together: ")
    assert "tube, arc " in none.reason


def test_moved_pulses_are_right_to_second_order() -> None:
    """Half the move, a quarter of the error: what the linearised problem says of positions, against flights."""
    tube = planned("fewest").search
    assert tube is not None
    assert tube.found is not None
    flown = tube.found.flown
    moves = np.concatenate([[0.0], np.random.default_rng(3).uniform(-1.0, 1.0, 12)])
    errors = []
    for size in (1.0, 0.5):
        builder = orbsoc.ConicBuilder()
        impulses = Impulses(
            builder, FLIGHT.motion, flown.programme.times_s, START, movable=flown.programme.dv_m_s
        )
        unknowns = np.zeros(52)
        unknowns[impulses.dv.index] = flown.programme.dv_m_s
        assert impulses.move is not None
        unknowns[impulses.move.index] = size * moves
        state = impulses.state(1800.0)
        linear = state.offset + sum(np.asarray(block) @ unknowns[columns] for columns, block in state.terms)
        moved = type(flown.programme)(flown.programme.times_s + size * moves, flown.programme.dv_m_s)
        exact = fly(FLIGHT, START, moved, 1800.0).before[-1]
        errors.append(np.linalg.norm(linear[:3] - exact[:3]))
    assert errors[1] == pytest.approx(0.25 * errors[0], rel=0.05)
    assert errors[0] < 0.01


def test_a_natural_ellipse_takes_one_pulse_and_the_other_way_round_many() -> None:
    natural = {
        "semi_axes_m": [200.0, 100.0],
        "angles_deg": [0.0, 0.0, 0.0],
        "period_s": PAPER.motion.period_s,
    }
    one = found(ellipse=natural, tolerance_m=1e-2)
    assert one.found is not None
    assert (one.pulses, one.certified) == (1, True)
    assert one.found.programme.total_m_s == pytest.approx(100.0 * PAPER.motion.mean_motion_rad_s, rel=1e-3)
    assert found(ellipse=natural | {"direction": -1}).pulses == 28


@pytest.mark.parametrize(("tolerance_m", "pulses"), [(0.5, 26), (20.0, 5)])
def test_other_tolerances_are_certified_too(tolerance_m: float, pulses: int) -> None:
    best = found(tolerance_m=tolerance_m)
    assert best.found is not None
    assert (best.pulses, best.certified) == (pulses, True)
    assert best.found.error_m <= tolerance_m + 1e-4
    assert best.impossible_below_m >= best.impossible_any_m > tolerance_m


NAVIGATION = {"position_m": 0.05, "velocity_m_s": 1e-3, "execution_share": 0.01, "execution_fixed_m_s": 2e-4}


def test_a_margin_for_uncertainty_takes_more_pulses() -> None:
    best = found(uncertainty=NAVIGATION)
    assert best.found is not None
    assert (best.pulses, best.certified) == (17, True)
    assert best.margin_m == pytest.approx(0.719, abs=2e-3)
    assert best.found.error_m <= 2.0 - best.margin_m + 1e-4
    assert best.next_needs_m == best.impossible_below_m + best.impossible_margin_m
    assert best.next_needs_m > 2.0
    assert best.impossible_margin_m > best.margin_m  # longer arcs
    exact = found(18, uncertainty=NAVIGATION)
    assert exact.margin_m == pytest.approx(0.64, abs=0.01)  # 1.4 m are left, as by hand


def test_a_margin_that_takes_all_is_told() -> None:
    none = found(uncertainty=NAVIGATION | {"position_m": 5.0})
    assert none.found is None
    assert "takes all of tolerance_m" in none.reason
    refused = plan(scenario(uncertainty=NAVIGATION | {"position_m": 5.0}))
    assert refused.status is PlanStatus.INFEASIBLE
    assert str(refused.verdict).startswith("Answer   INFEASIBLE   the margin for the uncertainty with ")


def test_a_disturbance_is_counted_on() -> None:
    pushed = scenario(disturbance={"acceleration_m_s2": [2e-5, -1e-5, 3e-5]})
    best = search(Searcher(pushed, orbsoc.solve, lambda _: None), 14).found
    assert best is not None
    assert fly(pushed.flight, START, best.programme, 1800.0, 500).largest_error_m <= 2.0 + 1e-4
    assert fly(FLIGHT, START, best.programme, 1800.0).largest_error_m > 10.0
