"""Equalities softened at a high cost: the optimal value is what it is without penalties."""

from __future__ import annotations

import numpy as np
import pytest

import orbsoc
from benchmarks.guidance import powered_descent
from benchmarks.penalties import Kept, linear, softened
from benchmarks.six_dof import landing
from orbsoc.conic.problem import Problem
from orbsoc.conic.solution import Status


def of_guidance(problem: Problem) -> Kept:
    solution = orbsoc.solve(problem)
    assert solution.status is Status.SOLVED
    return Kept(problem, solution.objective, float(np.abs(solution.y).max()))


def check(kept: Kept, decade: int) -> None:
    penalty = kept.penalty(decade)
    assert penalty > kept.multiplier, "not exact"
    solution = orbsoc.solve(softened(kept.problem, penalty))
    assert solution.status is Status.SOLVED, solution.message
    assert abs(solution.objective - kept.value) <= 1e-5 * (1.0 + abs(kept.value))


@pytest.mark.parametrize("decade", [4, 6, 7, 8, 9, 10])
def test_penalties_of_an_lp_do_not_hide_its_costs(decade: int) -> None:
    for seed in range(20):
        check(linear(seed), decade)


@pytest.mark.parametrize("decade", [6, 7, 8])
def test_virtual_control_does_not_hide_the_fuel(decade: int) -> None:
    check(of_guidance(powered_descent(10, 0)), decade)
    check(of_guidance(next(iter(landing(10, 0, 1)))), decade)


def test_slacks_are_used_where_the_equalities_contradict() -> None:
    """x = 1 and x = 3: the penalty is least anywhere between, and the cost decides."""
    kept = Problem(c=[1.0], A=[[1.0], [1.0]], b=[1.0, 3.0], G=[[-1.0]], h=[0.0], cones=orbsoc.Cones(l=1))
    solution = orbsoc.solve(softened(kept, 100.0))
    assert solution.status is Status.SOLVED, solution.message
    assert solution.x[0] == pytest.approx(1.0, abs=1e-5)
    assert solution.x[1:] == pytest.approx([0.0, 2.0, 0.0, 0.0], abs=1e-5)
