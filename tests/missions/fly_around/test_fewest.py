"""The proof: bounds that no flight and no second solver contradicts."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import orbsoc
from orbsoc.interfaces import clarabel
from orbsoc.missions.fly_around.search.fewest import (
    Bound,
    bound_below,
    even_bound,
    first_shares,
    free_arc,
    largest,
    partition,
)
from orbsoc.missions.fly_around.search.tube import Revolution, Tube, solve_tube

from .baseline import planned, scenario

PAPER = scenario()
FLIGHT, START = PAPER.flight, PAPER.start_state


@cache
def bound(pulses: int, samples: int = 8) -> Bound:
    return even_bound(FLIGHT, START[:3], 1800.0, pulses, solve=orbsoc.solve, samples=samples)


@pytest.mark.parametrize(
    ("pulses", "samples", "error_m"), [(12, 8, 2.2997), (12, 48, 2.3009), (13, 8, 1.9577), (13, 48, 1.9586)]
)
def test_12_pulses_need_2_2997_m_and_13_need_1_9577_m(pulses: int, samples: int, error_m: float) -> None:
    found = bound(pulses, samples)
    assert found.bound_m == pytest.approx(error_m, abs=6e-5 if samples == 8 else 2e-4)
    assert found.pulses == pulses
    errors = np.array([arc.error_m for arc in found.arcs])
    assert errors.max() - errors.min() <= 1e-4 * errors.max()


def test_every_arc_of_the_proof_holds_by_a_second_solver() -> None:
    """A bound is of multipliers, whatever their residual: Clarabel's own give 2.2997 m as well."""
    for arc in bound(12).arcs:
        other = clarabel.solve(arc.problem, orbsoc.Settings(tol=1e-9))
        assert bound_below(arc.problem, other) == pytest.approx(arc.bound_m, abs=2e-5)
        assert bound_below(arc.problem, other) > 2.2996
        assert arc.bound_m <= arc.error_m


@settings(max_examples=20)
@given(st.integers(0, 2**32 - 1))
def test_no_arc_has_an_unknown_beyond_what_its_error_allows(seed: int) -> None:
    rng = np.random.default_rng(seed)
    problem = bound(12).arcs[int(rng.integers(12))].problem
    x = rng.normal(size=problem.n) * 10.0 ** rng.uniform(-3, 3, problem.n)
    rows = (problem.h - problem.G.toarray()[:, :-1] @ x[:-1]).reshape(-1, 4)[:, 1:]
    x[-1] = np.linalg.norm(rows, axis=1).max()
    assert (np.abs(x) <= largest(problem, float(x[-1])) * (1.0 + 1e-9)).all()


@settings(max_examples=20)
@given(st.integers(0, 2**32 - 1))
def test_bad_multipliers_give_a_lower_bound_and_never_a_higher_one(seed: int) -> None:
    rng = np.random.default_rng(seed)
    arc = bound(12).arcs[int(rng.integers(12))]
    solution = arc.solution
    noise = 10.0 ** rng.uniform(-9, 0) * rng.normal(size=solution.z.size)
    assert bound_below(arc.problem, replace(solution, z=solution.z + noise)) <= arc.error_m + 1e-8


@settings(max_examples=10)
@given(st.integers(0, 2**32 - 1), st.integers(2, 5))
def test_no_flight_beats_the_bound_of_any_partition(seed: int, pulses: int) -> None:
    """Random times of the pulses against a random partition: the best flight strays at least as far as the bound."""
    rng = np.random.default_rng(seed)
    times = np.concatenate([[0.0], np.sort(rng.uniform(20.0, 1780.0, pulses - 1))])
    if np.diff(times, append=1800.0).min() < 5.0:
        return
    tube = solve_tube(Revolution(FLIGHT, START, 1800.0, orbsoc.solve), times, "error")
    assert isinstance(tube, Tube)
    shares = first_shares(pulses) * rng.uniform(0.7, 1.3, pulses)
    ends = partition(FLIGHT, 1800.0, shares)
    arcs = [
        free_arc(FLIGHT, ends[k], ends[k + 1], None if k else START[:3], solve=orbsoc.solve)
        for k in range(pulses)
    ]
    least = Bound(tuple(arcs)).bound_m
    assert least <= tube.error_m + 1e-6
    even = even_bound(FLIGHT, START[:3], 1800.0, pulses, solve=orbsoc.solve)
    assert least <= even.bound_m + 2e-4 * even.bound_m
    assert even.bound_m <= tube.error_m + 1e-6


def test_the_error_of_an_arc_grows_with_the_interval() -> None:
    errors = [
        free_arc(FLIGHT, 600.0, 600.0 + length, None, solve=orbsoc.solve).error_m
        for length in (50.0, 100.0, 200.0, 400.0, 800.0)
    ]
    assert errors == sorted(errors)


def test_all_conic_problems_of_the_plan_agree_with_clarabel() -> None:
    """Same status or better, objectives to 1e-6, and not more than 1.1 times its iterations."""
    rows = planned("fewest").subproblems
    ours, theirs = 0, 0
    for row in rows:
        other = clarabel.solve(row.problem, row.settings)
        assert row.solution.status is orbsoc.Status.SOLVED
        assert other.status in (orbsoc.Status.SOLVED, orbsoc.Status.SOLVED_INACCURATE)
        assert row.solution.objective == pytest.approx(other.objective, abs=1e-6, rel=1e-6)
        ours += row.solution.iterations
        theirs += other.iterations
    assert ours <= 1.1 * theirs
