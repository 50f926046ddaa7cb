"""Impulses: files round trip, both forms of the states agree, the primer bounds every other programme."""

from __future__ import annotations

import itertools
import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

import orbsoc
from orbsoc.guidance.impulses import (
    CSV_COLUMNS,
    Cost,
    ImpulseFileError,
    ImpulseProgramme,
    Impulses,
    ImpulsesError,
    generate,
)
from orbsoc.orbit.relative import ClohessyWiltshire

Array = NDArray[np.float64]
MOTION = ClohessyWiltshire(1.1e-3)
START = np.array([-300.0, -2000.0, 100.0, 0.1, 0.2, -0.05])


def transfer(times: Array, cost: Cost, *, linked: bool = False, end_s: float = 4000.0) -> Impulses:
    impulses = Impulses(orbsoc.ConicBuilder(), MOTION, times, START, start_s=0.0, linked=linked)
    impulses.cost(cost)
    impulses.meet(end_s, np.zeros(6), name="capture")
    return impulses


# ---- As data ----


@given(st.integers(0, 2**32 - 1), st.integers(1, 20))
def test_a_programme_comes_back_from_its_file_bit_for_bit(seed: int, count: int) -> None:
    rng = np.random.default_rng(seed)
    programme = ImpulseProgramme(np.cumsum(rng.uniform(0.1, 9.0, count)), rng.normal(size=(count, 3)))
    again = ImpulseProgramme.from_csv(programme.to_csv())
    assert np.array_equal(again.times_s, programme.times_s)
    assert np.array_equal(again.dv_m_s, programme.dv_m_s)


def test_totals_are_those_of_the_norms() -> None:
    programme = ImpulseProgramme([0.0, 1.0, 2.0], [[3.0, 4.0, 0.0], [0.0, 0.0, 1e-9], [-1.0, 2.0, 2.0]])
    assert (programme.total_m_s, programme.total_absolutes_m_s) == pytest.approx((8.0, 12.0))
    assert programme.largest_m_s == 5.0
    assert programme.without_small(1e-6).times_s.tolist() == [0.0, 2.0]
    assert len(programme.first(1)) == 1
    assert programme.to_list()[0] == {"time_s": 0.0, "dv_m_s": [3.0, 4.0, 0.0], "norm_m_s": 5.0}
    assert ImpulseProgramme([], []).largest_m_s == 0.0


HEADER = ",".join(CSV_COLUMNS) + "\n"


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", f"here.csv: the first line is nothing; it must be {HEADER.strip()}"),
        ("t,x\n0,1\n", "here.csv: the first line is t,x; it must be time_s,"),
        (HEADER, "here.csv: no impulses; there must be at least one line of numbers"),
        (HEADER + "0,1,2\n", "here.csv, line 2: 3 values; there must be 4"),
        (HEADER + "0,1,2,3\n\n1,x,2,3\n", "here.csv, line 4, dv_r_m_s = 'x': must be a finite number"),
        (HEADER + "0,1,nan,3\n", "here.csv, line 2, dv_t_m_s = 'nan': must be a finite number"),
        (HEADER + "5,0,0,1\n5,0,0,1\n", "here.csv, line 3, time_s = 5: must be after 5, the one before"),
    ],
)
def test_a_bad_file_names_line_column_value_and_what_is_allowed(text: str, says: str) -> None:
    with pytest.raises(ImpulseFileError, match=re.escape(says)):
        ImpulseProgramme.from_csv(text, source="here.csv")


def test_a_file_that_is_missing_or_no_text_is_told(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_bytes(b"\xff\xfe")
    for name in ("a.csv", "b.csv"):
        with pytest.raises(ImpulseFileError, match=f"{name}: cannot be read as text"):
            ImpulseProgramme.read(tmp_path / name)


@pytest.mark.parametrize(
    ("times", "dv", "says"),
    [
        ([0.0], [[1.0, 2.0, 3.0], [1.0, 2.0, 3.0]], "must be (N,) and (N, 3)"),
        ([0.0, 0.0], np.zeros((2, 3)), "impulse 1 at 0 s is not after that at 0 s"),
        ([np.nan], np.zeros((1, 3)), "holds finite numbers only"),
    ],
)
def test_a_programme_refuses_what_is_none(times: list[float], dv: Array, says: str) -> None:
    with pytest.raises(ValueError, match=re.escape(says)):
        ImpulseProgramme(times, dv)


# ---- As unknowns ----


@pytest.mark.parametrize("linked", [False, True])
def test_states_are_those_of_an_integrator_with_a_disturbance(linked: bool) -> None:
    push = np.array([1e-4, -2e-4, 3e-4])
    n = MOTION.mean_motion_rad_s

    def rate(_: float, x: Array, forced: Array) -> Array:
        curl = [2 * n * x[4] + 3 * n * n * x[0], -2 * n * x[3], -n * n * x[2]]
        return np.concatenate([x[3:], curl + forced])

    def flown(x: Array, dt: float, forced: Array = push) -> Array:
        if dt == 0.0:
            return x
        return np.array(
            solve_ivp(rate, (0.0, dt), x, "DOP853", rtol=1e-12, atol=1e-12, args=(forced,)).y[:, -1]
        )

    times, dv = np.array([100.0, 400.0, 900.0]), np.random.default_rng(0).normal(size=(3, 3))
    builder = orbsoc.ConicBuilder()
    impulses = Impulses(
        builder, MOTION, times, START, start_s=0.0, linked=linked, forced=lambda t: flown(np.zeros(6), t)
    )
    expected = flown(START, 100.0)
    unknowns = np.zeros(builder.build().n)
    unknowns[impulses.dv.index] = dv
    for k, (t, end) in enumerate(zip(times, [400.0, 900.0, 1300.0], strict=True)):
        if linked and k:
            unknowns[builder.build().A.indices.size and 9 + 6 * (k - 1) + np.arange(6)] = expected
        after = expected + np.concatenate([np.zeros(3), dv[k]])
        for at, before, state in ((t, True, expected), (t, False, after), (end, True, flown(after, end - t))):
            found = impulses.state(at, before=before)
            value = found.offset + sum(block @ unknowns[columns] for columns, block in found.terms)
            np.testing.assert_allclose(value, state, rtol=0, atol=1e-7)
        expected = flown(after, end - t)


@pytest.mark.parametrize("cost", ["norms", "absolutes", "largest"])
def test_linked_states_give_the_same_programme(cost: Cost) -> None:
    times = np.array([0.0, 1000.0, 2500.0, 4000.0])
    found = []
    for linked in (False, True):
        impulses = transfer(times, cost, linked=linked)
        solution = orbsoc.solve(impulses.builder.build(), tol=1e-10)
        assert solution.status is orbsoc.Status.SOLVED
        found.append((solution.objective, impulses.programme(solution).dv_m_s))
    assert found[0][0] == pytest.approx(found[1][0], rel=1e-8)
    np.testing.assert_allclose(found[0][1], found[1][1], atol=1e-5)


@settings(max_examples=15)
@given(st.integers(0, 2**32 - 1), st.sampled_from(["norms", "absolutes"]))
def test_the_primer_is_the_slope_of_the_cost_in_a_new_impulse(seed: int, cost: Cost) -> None:
    """It is along the impulses; and a given velocity change at another time lowers the cost by primer · change."""
    rng = np.random.default_rng(seed)
    times = np.sort(rng.uniform(0.0, 4000.0, 4))
    at, change = float(rng.uniform(0.0, 3900.0)), 1e-5 * rng.normal(size=3)
    impulses = transfer(times, cost)
    solution = orbsoc.solve(impulses.builder.build(), tol=1e-11)
    primer = impulses.primer(solution, times)
    programme = impulses.programme(solution)
    sizes = np.linalg.norm(programme.dv_m_s, ord=2 if cost == "norms" else 1, axis=1)
    gains = np.sum(primer * programme.dv_m_s, axis=1)
    np.testing.assert_allclose(gains, sizes, rtol=0, atol=1e-6)

    moved = Impulses(orbsoc.ConicBuilder(), MOTION, times, START, start_s=0.0)
    moved.cost(cost)
    given_away = MOTION.transition(4000.0, at) @ np.concatenate([np.zeros(3), change])
    moved.meet(4000.0, -given_away)
    after = orbsoc.solve(moved.builder.build(), tol=1e-11).objective
    slope = float(impulses.primer(solution, [at])[0] @ change)
    assert (
        solution.objective - after <= slope + 1e-8
    )  # the cost is convex: the slope bounds what a change saves
    assert solution.objective - after == pytest.approx(slope, abs=3e-7)


@pytest.mark.parametrize("cost", ["norms", "absolutes"])
def test_generated_times_reach_their_bound_and_no_grid_of_times_is_better(cost: Cost) -> None:
    start = np.array([0.0, 1000.0, 3000.0, 4000.0])
    found = generate(lambda times: transfer(times, cost), start, (0.0, 4000.0), solve=orbsoc.solve)
    assert abs(found.gap) <= 1e-6
    costs = [each.cost for each in found.rounds]
    assert costs == sorted(costs, reverse=True)
    assert all(each.lower_bound <= costs[-1] * (1 + 1e-9) for each in found.rounds)
    dense = transfer(np.linspace(0.0, 4000.0, 161), cost)
    objective = orbsoc.solve(dense.builder.build()).objective
    assert costs[-1] - 1e-7 <= objective <= costs[-1] * 1.01
    assert len(found.programme) <= 6  # as many as the conditions, by the theory of linear programming


def test_generation_ends_with_the_solve_that_has_no_solution() -> None:
    def build(times: Array) -> Impulses:
        impulses = transfer(times, "norms")
        impulses.builder.norm([(impulses.dv.index[:1], np.eye(3))], bound=1e-6, name="largest impulse")
        return impulses

    found = generate(build, [0.0], (0.0, 4000.0), solve=orbsoc.solve)
    assert found.solution.status is orbsoc.Status.PRIMAL_INFEASIBLE
    assert np.isnan(found.gap)
    assert "capture" in found.impulses.builder.why(found.solution)


def test_positions_stay_within_a_bound_that_is_a_number_or_an_unknown() -> None:
    centres = np.zeros((3, 3))
    costs = []
    for free in (False, True):
        impulses = Impulses(orbsoc.ConicBuilder(), MOTION, [0.0, 500.0], np.zeros(6), linked=True)
        builder = impulses.builder
        bound = builder.variable("bound", 1) if free else 4.0
        impulses.meet(600.0, [0.0, 3.0, 0.0])
        impulses.below(300.0, [[0.0, -1.0, 0.0, 0.0, 0.0, 0.0]], -1.0, name="ahead")
        for k, times in enumerate(([100.0, 200.0, 400.0], [500.0, 550.0, 600.0])):
            impulses.within(times, centres, bound, name=f"tube {k}")
        if free:
            builder.cost(builder.variable("unused", 1), 0.0)
            builder.cost(bound, 1.0)
        else:
            impulses.cost("norms")
        solution = orbsoc.solve(builder.build())
        assert solution.status is orbsoc.Status.SOLVED
        costs.append(solution.objective)
    assert costs[1] == pytest.approx(3.0, abs=1e-6)


def test_misuse_is_refused() -> None:
    builder = orbsoc.ConicBuilder()
    for times, start, says in (
        ([], START, "must be a non-empty vector"),
        ([1.0, 1.0], START, "of increasing times"),
        ([1.0], START[:3], "start has shape (3,)"),
    ):
        with pytest.raises(ImpulsesError, match=re.escape(says)):
            Impulses(builder, MOTION, times, start)
    with pytest.raises(ImpulsesError, match="must not be after the first impulse"):
        Impulses(builder, MOTION, [1.0], START, start_s=2.0)
    impulses = Impulses(builder, MOTION, [1.0, 3.0], START)
    with pytest.raises(ImpulsesError, match="must not be before the start"):
        impulses.state(0.5)
    with pytest.raises(ImpulsesError, match="must lie on one arc"):
        impulses.within([2.0, 4.0], np.zeros((2, 3)), 1.0, name="tube")
    with pytest.raises(ImpulsesError, match="call cost first"):
        impulses.primer_size(orbsoc.solve(builder.build()), [1.0])


@pytest.mark.parametrize("cost", ["norms", "absolutes"])
def test_an_engine_in_the_plane_plans_as_all_axes_do(cost: Cost) -> None:
    start = START * np.array([1, 1, 0, 1, 1, 0])
    found = []
    for axes in ((0, 1), (0, 1, 2)):
        impulses = Impulses(
            orbsoc.ConicBuilder(), MOTION, [0.0, 1500.0, 4000.0], start, start_s=0.0, axes=axes
        )
        impulses.cost(cost)
        impulses.meet(4000.0, np.zeros(2), matrix=np.eye(6)[[0, 1]], name="capture")
        solution = orbsoc.solve(impulses.builder.build(), tol=1e-9)
        found.append(impulses.programme(solution))
        primer = impulses.primer_size(solution, impulses.times_s)
        assert primer[found[-1].sizes_m_s > 1e-6] == pytest.approx(1.0, abs=1e-6)
    assert found[0].dv_m_s == pytest.approx(found[1].dv_m_s, abs=1e-6)


def test_over_given_instants_generation_reaches_the_programme_with_all_of_them() -> None:
    instants = np.linspace(0.0, 4000.0, 41)
    found = generate(
        lambda times: transfer(times, "norms"), instants[::20], (0.0, 4000.0), solve=orbsoc.solve,
        candidates_s=instants, keep_s=[1000.0],
    )  # fmt: skip
    best = orbsoc.solve(transfer(instants, "norms").builder.build(), tol=1e-9)
    assert found.solved
    assert found.programme.total_m_s == pytest.approx(best.objective, rel=1e-6)
    assert set(found.impulses.times_s) <= set(instants)
    assert 1000.0 in found.impulses.times_s
    assert found.impulses.times_s.size < 10
    assert found.lower_bound <= best.objective * (1.0 + 1e-8)


def test_impulses_that_are_the_solvers_zeros_are_counted_apart() -> None:
    programme = ImpulseProgramme([0.0, 60.0, 120.0], [[0.0, 0.3, 0.4], [1e-13, 0.0, 0.0], [0.0, 0.0, -0.5]])
    assert programme.words == "1.0000 m/s in 2 of 3 impulses, the rest zero"
    assert programme.worth_firing.tolist() == [True, False, True]
    assert ImpulseProgramme([0.0], [[0.0, 0.3, 0.4]]).words == "0.5000 m/s in 1 impulse"


@pytest.mark.parametrize("linked", [False, True])
def test_spread_changes_of_velocity_are_accelerations_that_are_held(linked: bool) -> None:
    """Against the integrated equations, within a span, at its end and after it."""
    times, until = np.array([0.0, 700.0, 2000.0]), np.array([700.0, 1500.0, 2000.0])
    rng = np.random.default_rng(6)
    dv, rate = rng.standard_normal((3, 3)), 1.1e-3
    motion = ClohessyWiltshire(rate)
    impulses = Impulses(
        orbsoc.ConicBuilder(), motion, times, START, start_s=0.0, linked=linked, until_s=until
    )

    def pushed(t: float, state: Array) -> Array:
        push = sum(
            (change / (b - a) for a, b, change in zip(times, until, dv, strict=True) if a <= t < b),
            np.zeros(3),
        )
        x, _, z, vx, vy, vz = state
        pull = [3.0 * rate**2 * x + 2.0 * rate * vy, -2.0 * rate * vx, -(rate**2) * z]
        return np.concatenate([[vx, vy, vz], pull + push])

    edges, states = [0.0, 300.0, 700.0, 1500.0, 1900.0, 2000.0], [START]
    for a, b in itertools.pairwise(edges):
        found = solve_ivp(
            lambda t, s, a=a, b=b: pushed(min(max(t, a), np.nextafter(b, a)), s), (a, b), states[-1],
            method="DOP853", rtol=1e-11, atol=1e-9,
        )  # fmt: skip
        states.append(found.y[:, -1])
    x = np.zeros(impulses.builder.build().n)
    x[impulses.dv.index] = dv
    if linked:
        x[impulses.state_columns(1)], x[impulses.state_columns(2)] = states[2], states[5]
    for t, wanted in zip(edges[1:-1], states[1:-1], strict=True):
        state = impulses.state(t, before=True)
        built = state.offset + sum(block @ x[np.asarray(columns)] for columns, block in state.terms)
        np.testing.assert_allclose(built, wanted, atol=1e-6)
    last = states[-1] + np.concatenate([np.zeros(3), dv[2]])  # the third is an impulse
    state = impulses.state(2000.0)
    built = state.offset + sum(block @ x[np.asarray(columns)] for columns, block in state.terms)
    np.testing.assert_allclose(built, last, atol=1e-6)
    with pytest.raises(ImpulsesError, match="until_s: must be a vector of times"):
        Impulses(orbsoc.ConicBuilder(), motion, times, START, start_s=0.0, until_s=until + 600.0)
