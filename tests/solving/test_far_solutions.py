"""Bounded problems whose solutions lie far out: a ray that fits the data to a millionth proves nothing."""

from __future__ import annotations

import numpy as np
import pytest

import orbsoc
from orbsoc.conic.problem import Cones, Problem
from orbsoc.conic.solution import Status
from orbsoc.conic.verify import check_certificate


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


def test_a_claim_holds_in_any_order_of_the_sums() -> None:
    """Gᵀz is a difference of two products of 1e14: its 0.015 is less than a unit in the last place of either.

    Found by the fuzzing of test_fuzz.py: in the order of one sum the certificate's radius is 53, in another's 38.
    No x is feasible, in truth, and the slopes let x be 1e-15 at most: a radius of 1, which both sums confirm, is a proof.
    """
    steep = [[128100934695773.0], [5160040444501711.0], [0.5], [1.0]]
    problem = Problem(P=[[1.0]], c=[0.0], G=steep, h=[0.0, 0.0, 1.0, 0.0], cones=Cones(q=[4]))
    solution = orbsoc.solve(problem)
    assert solution.status is Status.PRIMAL_INFEASIBLE, solution.message
    assert check_certificate(problem, solution).radius >= solution.certificate.radius > 1.0


@pytest.mark.parametrize("slope", [1.0, 1e-2, 1e-3, 1e-5])
@pytest.mark.parametrize("cost", [1e-2, 1.0, 100.0])
def test_of_two_certificates_the_stronger_one_is_claimed(slope: float, cost: float) -> None:
    """No x below 2/slope is feasible, true; but there is a ray along which the cost falls for ever."""
    problem = Problem(c=[cost * slope], G=[[slope]], h=[-2.0], cones=Cones(l=1))
    solution = orbsoc.solve(problem)
    assert solution.status is Status.DUAL_INFEASIBLE, solution.message
    assert solution.certificate.radius > 1e8


def driven(seed: int) -> tuple[Problem, float]:
    """Unstable dynamics of four states over fifteen steps with a bounded input, and how large the states are without one."""
    rng = np.random.default_rng([seed, 15, 20])
    dynamics = rng.normal(size=(4, 4))
    dynamics *= 2.0 / np.abs(np.linalg.eigvals(dynamics)).max()
    gain, first, steps = rng.normal(size=(4, 1)), dynamics @ rng.normal(size=4), 15
    states = np.eye(4 * steps) - np.kron(np.eye(steps, k=-1), dynamics)
    A = np.hstack([states, np.kron(np.eye(steps), -gain)])
    G = np.hstack([np.zeros((2 * steps, 4 * steps)), np.vstack([np.eye(steps), -np.eye(steps)])])
    b = np.r_[first, np.zeros(4 * (steps - 1))]
    P = np.diag(np.r_[np.ones(4 * steps), np.full(steps, 0.1)])
    problem = Problem(P=P, c=np.zeros(5 * steps), A=A, b=b, G=G, h=np.full(2 * steps, 0.3), cones=Cones(l=30))
    return problem, float(np.abs(np.linalg.solve(states, b)).max())


def test_a_solution_farther_out_than_the_certificate_reaches_is_not_called_none() -> None:
    """All are feasible, at states of 1e3 to 1e5; what is claimed must be true of nearer points, at least."""
    statuses = []
    for seed in range(20):
        problem, size = driven(seed)
        solution = orbsoc.solve(problem)
        statuses.append(solution.status)
        if solution.status is Status.PRIMAL_INFEASIBLE:
            assert solution.certificate.radius <= size * (1.0 + 1e-9)
    assert statuses[2] is Status.NUMERICAL_LIMIT
    found = orbsoc.solve(driven(2)[0])
    assert max(found.certificate.primal_residual, found.certificate.dual_residual) <= 1e-5


@pytest.mark.parametrize("value", [1e-307, 1e-310, 5e-324])
@pytest.mark.parametrize("name", ["P", "c", "G"])
def test_numbers_whose_inverse_is_infinite_count_as_zero(name: str, value: float) -> None:
    """x ≥ 0 at a cost of x₁ + x₂, but for the scaled matrix or vector."""
    data = {"P": np.zeros((2, 2)), "c": np.ones(2), "G": -np.eye(2)}
    data[name] = value * (np.eye(2) if name == "P" else data[name])
    solution = orbsoc.solve(Problem(**data, h=np.zeros(2), cones=Cones(l=2)))
    unbounded = name == "G" and value < 1e-308
    assert solution.status is (Status.DUAL_INFEASIBLE if unbounded else Status.SOLVED), solution.message


@pytest.mark.parametrize("steep", [1e293, 1e300, 1.7e308])
def test_a_slack_beyond_double_precision_is_no_solution(steep: float) -> None:
    """x = −2e16 fulfils the first row with a slack of which no number tells: ∞/∞ must not pass for no error."""
    problem = Problem(c=[1.0], G=[[steep], [-1.0]], h=[0.0, 2.2520233e16], cones=Cones(l=2))
    solution = orbsoc.solve(problem)
    assert solution.status is Status.NUMERICAL_LIMIT, solution.message
    assert "primal residual inf" in solution.message


@pytest.mark.parametrize("decades", range(1, 13))
def test_rows_of_very_different_sizes_take_few_iterations(decades: int) -> None:
    """At six decades a linear solve of the usual accuracy spoils the step in τ: 49 iterations without decision 0004."""
    d = np.array([10.0**-decades, 1.0, 10.0**decades])
    solution = orbsoc.solve(Problem(c=np.ones(3), G=-np.diag(d), h=-d, cones=Cones(l=3)))
    assert solution.status is Status.SOLVED
    assert solution.x == pytest.approx(np.ones(3), rel=1e-6)
    assert solution.iterations <= 12


@pytest.mark.parametrize("steep", [7.9e15, 1e17, 1e20])
def test_a_residual_that_rounding_may_hide_is_not_called_small(steep: float) -> None:
    """x = (1, 0), y = (3·steep/1e194, −3): the first entry of c + Aᵀy is the difference of two products of 3·steep, which
    is 0 or 4 as its terms are added. Found by the fuzzing of test_fuzz.py.
    """
    problem = Problem(c=[0.0, 3.0], A=[[4.1e194, 0.0], [steep, 1.0]], b=[4.1e194, steep])
    solution = orbsoc.solve(problem)
    assert solution.status is Status.NUMERICAL_LIMIT, solution.message
    assert "dual residual" in solution.message


def test_a_residual_whose_terms_are_large_may_still_be_small() -> None:
    """Terms of 3e5 lose a unit of 1e-10 to rounding, not the tolerance."""
    problem = Problem(c=[0.0, 3.0], A=[[4.1e20, 0.0], [1e5, 1.0]], b=[4.1e20, 1e5])
    assert orbsoc.solve(problem).status is Status.SOLVED


def test_a_gap_that_rounding_may_hide_is_not_called_small() -> None:
    """cᵀx is the difference of two products of 5.9e11, whose last digits are 1e-4. Found by the fuzzing of test_fuzz.py."""
    c = [9.23455399758174e121, 5.237307634613326e-88]
    G = [[0.0, 0.0], [3.2039275636557833e-125, 2.0566644729528354e-202]]
    problem = Problem(c=c, A=[c], b=[0.0], G=G, h=[1487075686.0, 0.0], cones=Cones(l=2))
    solution = orbsoc.solve(problem)
    assert solution.status is not Status.SOLVED, solution.message
    assert "gap" in solution.message
