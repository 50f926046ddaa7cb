"""Recovery: what is left of the families that once ended without a solution."""

from __future__ import annotations

from pathlib import Path

import pytest

import orbsoc
from benchmarks.recovery import BOUNDS, KINDS, loose_bounds, second_differences, slow_gap
from orbsoc.conic.problem import Problem
from orbsoc.conic.solution import Status

HARD = Path(__file__).resolve().parents[3] / "shared" / "problems" / "hard"


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("bound", BOUNDS)
def test_loose_bounds_cost_nothing(kind: str, bound: float) -> None:
    for seed in range(12):
        solution = orbsoc.solve(loose_bounds(seed, bound, kind))
        assert solution.status is Status.SOLVED, (seed, solution.message)
        assert solution.iterations <= 35


@pytest.mark.parametrize("seed", [4, 5])
def test_second_differences_need_less_regularisation(seed: int) -> None:
    problem = second_differences(seed, 3000)
    assert orbsoc.solve(problem).status is Status.SOLVED
    without = orbsoc.solve(problem, max_restarts=0)
    assert without.status is not Status.SOLVED


def test_a_gap_that_rises_first_is_no_stall() -> None:
    for seed in range(12):
        assert orbsoc.solve(slow_gap(seed)).status is Status.SOLVED


@pytest.mark.skipif(not HARD.is_dir(), reason="the folder of public problems is not there")
@pytest.mark.parametrize(
    ("name", "status", "iterations"),
    [
        ("safe2_fit_1000_6000_H1_t3600", Status.SOLVED, 25),
        ("safe2_printed_2000_6000_H1_t3300", Status.SOLVED, 25),
        ("robust_infeasible", Status.PRIMAL_INFEASIBLE, 18),
        ("mission003_n10_subproblem", Status.SOLVED, 18),
    ],
)
def test_problems_without_interior_end_as_they_should(name: str, status: Status, iterations: int) -> None:
    solution = orbsoc.solve(Problem.load(HARD / f"{name}.json"))
    assert solution.status is status, solution.message
    assert solution.iterations <= iterations
