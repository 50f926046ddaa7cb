"""Bounded problems whose solutions lie far out: a ray that fits the data to a millionth proves nothing."""

from __future__ import annotations

import pytest

import orbsoc
from orbsoc.problem import Cones, Problem
from orbsoc.solution import Status


@pytest.mark.parametrize("curvature", [1e-4, 1e-5, 1e-6, 3e-7, 1e-7])
def test_a_flat_parabola_is_solved_not_called_unbounded(curvature: float) -> None:
    problem = Problem(P=[[curvature]], c=[-1.0], G=[[-1.0]], h=[0.0], cones=Cones(l=1))
    solution = orbsoc.solve(problem)
    assert solution.status is Status.SOLVED, solution.message
    assert solution.objective == pytest.approx(-0.5 / curvature, rel=1e-7)
    assert orbsoc.verify(problem, solution).worst <= 1e-8


@pytest.mark.parametrize("slope", [1e-4, 1e-6, 1e-7, 1e-8])
def test_a_flat_constraint_is_solved_not_called_unbounded(slope: float) -> None:
    problem = Problem(c=[-1.0], G=[[slope]], h=[1.0], cones=Cones(l=1))
    solution = orbsoc.solve(problem)
    assert solution.status is Status.SOLVED, solution.message
    assert solution.objective == pytest.approx(-1.0 / slope, rel=1e-7)


def test_a_radius_of_one_hundred_million_times_the_data_is_claimed() -> None:
    """Where curvature is lost in rounding at tolerance 1e-8, the claim states how far it reaches."""
    problem = Problem(P=[[1e-10]], c=[-1.0], G=[[-1.0]], h=[0.0], cones=Cones(l=1))
    solution = orbsoc.solve(problem)
    assert solution.status is Status.DUAL_INFEASIBLE
    assert 1e8 <= solution.certificate.radius <= 1.1e10
