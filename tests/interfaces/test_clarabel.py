"""The Clarabel adapter: signs, order, statuses and limits in our terms."""

from __future__ import annotations

import numpy as np
import pytest

from orbsoc.conic.problem import Cones, Problem
from orbsoc.conic.settings import Settings
from orbsoc.conic.solution import Status
from orbsoc.conic.verify import check_certificate, verify
from orbsoc.interfaces.clarabel import solve
from tests.zoo import cases

INF = float("inf")
CASES = {case.name: case for case in cases()}


def test_multipliers_have_our_sign_and_order() -> None:
    """min 2x₀ + 3x₁, x₀ + x₁ = 1, x ≥ 0, (x₀ + 3, x₁) ∈ Q²: x = (1, 0), y = −2, z = (0, 1, 0, 0) by hand."""
    problem = Problem(
        c=[2.0, 3.0],
        A=[[1.0, 1.0]],
        b=[1.0],
        G=[[-1, 0], [0, -1], [-1, 0], [0, -1]],
        h=[0, 0, 3, 0],
        cones=Cones(l=2, q=[2]),
    )
    solution = solve(problem, tol=1e-10)
    assert solution.status is Status.SOLVED
    np.testing.assert_allclose(solution.x, [1, 0], atol=1e-8)
    np.testing.assert_allclose(solution.y, [-2], atol=1e-7)
    np.testing.assert_allclose(solution.z, [0, 1, 0, 0], atol=1e-7)
    np.testing.assert_allclose(solution.s, [1, 0, 4, 0], atol=1e-7)
    assert solution.objective == pytest.approx(2.0, abs=1e-8)
    assert solution.dual_objective == pytest.approx(2.0, abs=1e-8)


@pytest.mark.parametrize("name", ["known_socp_quadratic", "known_socp_all_modes", "known_qp_low_rank"])
def test_the_point_satisfies_our_optimality_conditions(name: str) -> None:
    problem = CASES[name].problem
    solution = solve(problem, tol=1e-10)
    assert verify(problem, solution).worst <= 1e-9
    assert abs(solution.s @ solution.z) <= 1e-8


def test_rows_without_a_bound_come_back_with_infinite_slack_and_no_multiplier() -> None:
    solution = solve(CASES["lp_infinite_bounds"].problem)
    assert solution.status is Status.SOLVED
    assert np.flatnonzero(np.isinf(solution.s)).tolist() == [0, 5]
    assert solution.z[[0, 5]].tolist() == [0.0, 0.0]


@pytest.mark.parametrize(
    ("name", "status"),
    [("lp_crossed_bounds", Status.PRIMAL_INFEASIBLE), ("socp_open_cone", Status.DUAL_INFEASIBLE)],
)
def test_infeasibility_comes_with_a_radius_and_without_objectives(name: str, status: Status) -> None:
    problem = CASES[name].problem
    solution = solve(problem)
    assert solution.status is status
    assert solution.certificate.radius >= 1e6
    assert solution.certificate.radius == check_certificate(problem, solution).radius
    assert np.isnan([solution.objective, solution.dual_objective]).all()


def test_a_claim_that_the_data_do_not_support_is_lowered() -> None:
    """Clarabel accepts Gx + s − h = 1.6e-5 here, because its residual is relative to ‖x‖ = 1e5."""
    solution = solve(CASES["lie_far_feasible_set"].problem)
    assert solution.status is Status.NUMERICAL_LIMIT
    assert "Solved, but on the original data inequality is" in solution.message


def test_tolerance_is_handed_on() -> None:
    problem = CASES["known_socp_sizes"].problem
    loose, tight = solve(problem, Settings(tol=1e-3)), solve(problem, tol=1e-11)
    assert loose.iterations < tight.iterations
    assert verify(problem, tight).worst <= 1e-10 < verify(problem, loose).worst


def test_an_override_leaves_the_other_settings() -> None:
    problem = CASES["known_socp_sizes"].problem
    assert solve(problem, Settings(max_iterations=2), tol=1e-9).status is Status.MAX_ITERATIONS


def test_limits_return_the_iterate_with_its_residuals() -> None:
    problem = CASES["known_lp_medium"].problem
    solution = solve(problem, max_iterations=3)
    assert solution.status is Status.MAX_ITERATIONS
    assert solution.iterations == 3
    assert 1e-8 < check_certificate(problem, solution).worst_line()[1] < 1e3
    assert solve(problem, max_time_s=1e-9).status is Status.MAX_TIME


def test_settings_that_do_not_exist_or_make_no_sense_are_refused() -> None:
    problem = CASES["lp_simplex"].problem
    with pytest.raises(TypeError, match="tolerance"):
        solve(problem, tolerance=1e-8)
    with pytest.raises(ValueError, match="tol = -1"):
        solve(problem, tol=-1.0)


def test_verbose_prints_and_silence_does_not(capfd: pytest.CaptureFixture[str]) -> None:
    problem = CASES["lp_simplex"].problem
    solve(problem)
    assert capfd.readouterr().out == ""
    solve(problem, verbose=True)
    assert "Clarabel" in capfd.readouterr().out


def test_sizes_and_times_are_reported() -> None:
    problem = CASES["qp_tracking"].problem
    solution = solve(problem)
    rows = problem.n + problem.p + problem.m
    assert solution.nnz_kkt >= rows
    assert solution.nnz_l >= rows - 1
    assert solution.setup_s > 0.0
    assert solution.solve_s > 0.0
