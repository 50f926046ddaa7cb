"""The budget of a plan: it prices every subproblem, compares every word, and never prices half a solve."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import orbsoc
import orbsoc.cycle_budget
from orbsoc import Cones, Problem, Settings, Solution, Status
from orbsoc.cycle_budget import CycleBudget, cycle_budget
from orbsoc.scp import Iteration

PROBLEM = Problem(
    c=[1.0, 1.0], A=[[1.0, -1.0]], b=[0.5], G=[[-1.0, 0.0], [0.0, -1.0]], h=[0.0, 0.0], cones=Cones(l=2)
)


def row(solution: Solution) -> Iteration:
    return Iteration(1, 1e-8, PROBLEM, solution, 0.0, 0.0, {})


def budget(*solutions: Solution, deadline_ms: float | None = None, scheduled: bool = False) -> CycleBudget:
    scheduler = None
    if scheduled:
        scheduler = orbsoc.PsScheduler()
        scheduler(PROBLEM, Settings(tol=1e-8))
    return cycle_budget(
        [row(solution) for solution in solutions],
        device="zu9eg",
        partition="paper",
        deadline_ms=deadline_ms,
        scheduled=scheduler,
    )


@pytest.fixture
def solved() -> Solution:
    return orbsoc.solve(PROBLEM, tol=1e-8)


@pytest.mark.parametrize("scheduled", [True, False])
def test_the_same_solve_has_the_same_bits(solved: Solution, scheduled: bool) -> None:
    assert budget(solved, scheduled=scheduled).same_bits


@pytest.mark.parametrize("name", ["x", "y", "s", "z"])
def test_one_different_last_bit_of_any_vector_is_seen(solved: Solution, name: str) -> None:
    changed = getattr(solved, name).copy()
    changed[-1] = np.nextafter(changed[-1], np.inf)
    assert not budget(replace(solved, **{name: changed})).same_bits


def test_another_status_or_iteration_count_is_seen(solved: Solution) -> None:
    assert not budget(replace(solved, iterations=solved.iterations + 1)).same_bits
    assert not budget(replace(solved, status=Status.SOLVED_INACCURATE)).same_bits


def test_a_difference_does_not_keep_the_later_subproblems_out_of_the_price(solved: Solution) -> None:
    other = replace(solved, iterations=99)
    assert len(budget(other, solved, solved).report.solves) == 3


def test_an_interrupted_solve_is_not_priced(solved: Solution, monkeypatch: pytest.MonkeyPatch) -> None:
    stopped = replace(solved, status=Status.INTERRUPTED)
    monkeypatch.setattr(orbsoc.PsScheduler, "__call__", lambda *_: stopped)
    with pytest.raises(KeyboardInterrupt):
        budget(solved)


def test_an_interrupted_comparison_is_not_a_difference(
    solved: Solution, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(orbsoc.cycle_budget, "solve", lambda *_: replace(solved, status=Status.INTERRUPTED))
    with pytest.raises(KeyboardInterrupt):
        budget(solved, scheduled=True)
