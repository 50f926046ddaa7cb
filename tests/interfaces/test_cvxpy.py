"""orbsoc as CVXPY's solver: values, duals, statuses, options and bounds, with Clarabel as reference."""

from __future__ import annotations

import builtins
import subprocess
import sys
from collections.abc import Callable
from typing import Any

import cvxpy as cp
import numpy as np
import pytest

import orbsoc
from orbsoc.interfaces.cvxpy import NAME

RNG_SEED = 20251101


def least_squares() -> cp.Problem:
    """A quadratic objective with equalities and inequalities."""
    rng = np.random.default_rng(RNG_SEED)
    x = cp.Variable(8)
    A, b = rng.normal(size=(12, 8)), rng.normal(size=12)
    return cp.Problem(cp.Minimize(cp.sum_squares(A @ x - b)), [x >= -0.2, cp.sum(x) == 1])


def robust_portfolio() -> cp.Problem:
    """A linear objective with second-order cones of two sizes."""
    rng = np.random.default_rng(RNG_SEED + 1)
    w, t = cp.Variable(6, nonneg=True), cp.Variable()
    factor = rng.normal(size=(6, 6))
    constraints = [cp.sum(w) == 1, cp.SOC(t, factor @ w), cp.norm(w - 1 / 6) <= 0.3]
    return cp.Problem(cp.Minimize(t - rng.uniform(0, 0.1, 6) @ w), constraints)


def regularised_fit() -> cp.Problem:
    """A quadratic objective and a second-order cone, maximised, with a constant in the objective."""
    rng = np.random.default_rng(RNG_SEED + 2)
    x = cp.Variable((3, 2))
    target = rng.normal(size=(3, 2))
    return cp.Problem(cp.Maximize(7.0 - cp.sum_squares(x - target) - cp.norm(x, "fro")), [x[0] == x[1]])


def bounded() -> cp.Problem:
    """Bounds of every kind as attributes of variables, beside constraints that keep their duals."""
    low, high = np.array([-1.0, -np.inf, 0.5, -np.inf, 2.0]), np.array([1.0, 3.0, np.inf, np.inf, 2.0])
    x = cp.Variable(5, bounds=[low, high])
    c = np.array([1.0, -1.0, 1.0, -0.5, 0.0])
    return cp.Problem(cp.Minimize(c @ x + cp.norm(x)), [cp.sum(x) >= 1, x[3] <= 4, x[0] + x[3] == 1.0])


@pytest.mark.parametrize("make", [least_squares, robust_portfolio, regularised_fit, bounded])
def test_values_and_duals_agree_with_clarabel(make: Callable[[], cp.Problem]) -> None:
    """A gap of 1e-10 leaves errors of its root, 1e-5, in points and multipliers where the optimum is flat."""
    ours, theirs = make(), make()
    ours.solve(solver=orbsoc.CVXPY(), tol=1e-10)
    theirs.solve(solver=cp.CLARABEL, tol_gap_abs=1e-10, tol_gap_rel=1e-10, tol_feas=1e-10)
    assert ours.status == cp.OPTIMAL
    assert ours.value == pytest.approx(theirs.value, rel=1e-8)
    for one, other in zip(ours.variables(), theirs.variables(), strict=True):
        assert np.max(np.abs(one.value - other.value)) < 1e-5
    for one, other in zip(ours.constraints, theirs.constraints, strict=True):
        left, right = (np.concatenate([np.ravel(v.value) for v in c.dual_variables]) for c in (one, other))
        assert np.max(np.abs(left - right)) < 1e-5


def test_solver_stats_are_those_of_the_solution() -> None:
    problem = least_squares()
    problem.solve(solver=orbsoc.CVXPY())
    stats = problem.solver_stats
    solution = stats.extra_stats
    assert stats.solver_name == NAME
    assert isinstance(solution, orbsoc.Solution)
    assert solution.status is orbsoc.Status.SOLVED
    assert (stats.num_iters, stats.solve_time, stats.setup_time) == (
        solution.iterations, solution.solve_s, solution.setup_s,
    )  # fmt: skip


def test_settings_come_from_the_solver_and_options_override_them() -> None:
    problem = robust_portfolio()
    solver = orbsoc.CVXPY(orbsoc.Settings(tol=1e-4))
    problem.solve(solver=solver)
    rough = problem.solver_stats.num_iters
    problem.solve(solver=solver, tol=1e-10)
    assert problem.solver_stats.num_iters > rough


def test_an_unknown_option_is_a_type_error_that_names_it() -> None:
    with pytest.raises(TypeError, match="tolerance"):
        least_squares().solve(solver=orbsoc.CVXPY(), tolerance=1e-9)


def test_verbose_prints_the_iteration_table(capfd: pytest.CaptureFixture[str]) -> None:
    problem = least_squares()
    problem.solve(solver=orbsoc.CVXPY(), verbose=True)
    printed = capfd.readouterr().err
    assert "iter       objective" in printed
    assert len([line for line in printed.splitlines() if line.endswith(tuple("0123456789"))]) >= 3


def test_an_inaccurate_solution_is_called_so() -> None:
    problem = robust_portfolio()
    with pytest.warns(UserWarning, match="may be inaccurate"):
        problem.solve(solver=orbsoc.CVXPY(), tol=1e-30)
    assert problem.status == cp.OPTIMAL_INACCURATE
    assert problem.value is not None


def test_at_the_iteration_limit_the_best_iterate_is_there() -> None:
    problem = robust_portfolio()
    with pytest.warns(UserWarning, match="may be inaccurate"):
        problem.solve(solver=orbsoc.CVXPY(), max_iterations=3)
    assert problem.status == cp.settings.USER_LIMIT
    assert np.isfinite(problem.variables()[0].value).all()
    assert "max_iterations" in problem.solver_stats.extra_stats.message


def test_unbounded_is_minus_infinity_without_values() -> None:
    x = cp.Variable(2)
    problem = cp.Problem(cp.Minimize(x[0] - x[1]), [cp.norm(x) <= x[0] + x[1] + 1])
    assert problem.solve(solver=orbsoc.CVXPY()) == -np.inf
    assert problem.status == cp.UNBOUNDED
    assert x.value is None


def test_a_numerical_limit_is_a_solver_error_that_says_how_far_it_came(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(orbsoc.Solver, "solve", lambda _, **__: stopped(orbsoc.Status.NUMERICAL_LIMIT))
    with pytest.raises(cp.SolverError, match=r"ORBSOC.*as far as it went"):
        least_squares().solve(solver=orbsoc.CVXPY())


def test_ctrl_c_goes_on_as_keyboard_interrupt(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(orbsoc.Solver, "solve", lambda _, **__: stopped(orbsoc.Status.INTERRUPTED))
    with pytest.raises(KeyboardInterrupt):
        least_squares().solve(solver=orbsoc.CVXPY())


def stopped(status: orbsoc.Status) -> orbsoc.Solution:
    """A solve that ended with `status`."""
    none = np.zeros(0)
    certificate = orbsoc.Certificate(1.0, 1.0, 1.0, float("nan"))
    return orbsoc.Solution(
        status, none, none, none, none, 0.0, 0.0, 1, 1, 0.0, 0.0, certificate, "as far as it went", 0, 0
    )


def ball(value: float) -> tuple[cp.Problem, cp.Parameter]:
    """A projection onto a ball of a radius that is a parameter."""
    x, radius = cp.Variable(4), cp.Parameter(nonneg=True, value=value)
    return cp.Problem(cp.Minimize(cp.sum_squares(x - 2) + x[0]), [cp.norm(x) <= radius]), radius


def test_without_a_warm_start_a_new_parameter_gives_the_bits_of_a_fresh_problem() -> None:
    """The analysis is kept between solves; no number of the last solve is."""
    problem, radius = ball(1.0)
    problem.solve(solver=orbsoc.CVXPY())
    first = problem.variables()[0].value.copy()
    radius.value = 3.0
    problem.solve(solver=orbsoc.CVXPY(), warm_start=False)
    fresh, _ = ball(3.0)
    fresh.solve(solver=orbsoc.CVXPY())
    assert problem.variables()[0].value.tobytes() == fresh.variables()[0].value.tobytes()
    assert np.max(np.abs(first - problem.variables()[0].value)) > 0.1


def test_a_second_solve_starts_from_the_first_solution() -> None:
    problem, radius = ball(1.0)
    problem.solve(solver=orbsoc.CVXPY())
    cold = problem.solver_stats.extra_stats
    radius.value = 1.0001
    problem.solve(solver=orbsoc.CVXPY())
    warm = problem.solver_stats.extra_stats
    assert (cold.warm_start, warm.warm_start) == ("none", "used")
    assert warm.iterations < cold.iterations


def test_an_infeasible_solve_is_no_point_to_start_from() -> None:
    x, least = cp.Variable(2), cp.Parameter(value=3.0)
    problem = cp.Problem(cp.Minimize(cp.sum_squares(x)), [x <= 1, cp.sum(x) >= least])
    assert problem.solve(solver=orbsoc.CVXPY()) == np.inf
    least.value = 1.0
    assert problem.solve(solver=orbsoc.CVXPY()) == pytest.approx(0.5, abs=1e-6)
    assert problem.solver_stats.extra_stats.warm_start == "none"


def test_new_entries_of_the_cost_are_taken() -> None:
    x, weight = cp.Variable(2), cp.Parameter(nonneg=True, value=1.0)
    problem = cp.Problem(cp.Minimize(weight * cp.sum_squares(x) - x[0]), [cp.norm(x) <= 5])
    for value in (1.0, 4.0, 4.0, 0.25):
        weight.value = value
        assert problem.solve(solver=orbsoc.CVXPY()) == pytest.approx(-0.25 / value, abs=1e-6)


def test_a_value_outside_its_bounds_is_no_error() -> None:
    """CVXPY 1.9.3 raises ValueError here for a solver that takes bounds apart from the rows."""
    x = cp.Variable((3, 3), diag=True, bounds=[0, 1])
    problem = cp.Problem(cp.Minimize(cp.trace(x)), [cp.sum(x) >= 0.5])
    x.save_value(np.diag([-1e-3, 0.5, 0.2]))
    assert problem.solve(solver=orbsoc.CVXPY()) == pytest.approx(0.5, abs=1e-6)


def test_a_parameter_that_changes_the_pattern_is_solved_anew() -> None:
    x, weight = cp.Variable(3), cp.Parameter(3, value=np.array([1.0, 0.0, 2.0]))
    problem = cp.Problem(cp.Minimize(cp.sum(x)), [weight @ x >= 1, x >= -1])
    problem.solve(solver=orbsoc.CVXPY())
    weight.value = np.array([0.0, 3.0, 2.0])
    assert problem.solve(solver=orbsoc.CVXPY()) == pytest.approx(-1.0, abs=1e-6)


def test_equal_solvers_share_one_compilation() -> None:
    problem = least_squares()
    problem.solve(solver=orbsoc.CVXPY())
    chain = problem._cache.solving_chain
    problem.solve(solver=orbsoc.CVXPY())
    assert problem._cache.solving_chain is chain
    assert orbsoc.CVXPY() != orbsoc.CVXPY(orbsoc.Settings(tol=1e-3))


@pytest.mark.parametrize(
    "constrain",
    [
        lambda x: [cp.Variable(boolean=True) + x >= 1],
        lambda x: [cp.exp(x) <= 2],
        lambda x: [cp.bmat([[x, 1], [1, x]]) >> 0],
    ],
)
def test_what_orbsoc_does_not_solve_is_refused_before_solving(constrain: Callable[[Any], list[Any]]) -> None:
    x = cp.Variable()
    with pytest.raises(cp.SolverError, match="ORBSOC"):
        cp.Problem(cp.Minimize(x), constrain(x)).solve(solver=orbsoc.CVXPY())


def test_an_infinite_right_hand_side_is_no_constraint() -> None:
    x = cp.Variable(2)
    problem = cp.Problem(cp.Minimize(cp.sum_squares(x - 1)), [x <= np.array([np.inf, 0.5])])
    assert problem.solve(solver=orbsoc.CVXPY()) == pytest.approx(0.25, abs=1e-7)


def test_bounds_that_no_point_meets_are_infeasible() -> None:
    x = cp.Variable(2, bounds=[0, 1])
    problem = cp.Problem(cp.Minimize(cp.sum(x)), [cp.sum(x) >= 3])
    assert problem.solve(solver=orbsoc.CVXPY()) == np.inf
    assert problem.status == cp.INFEASIBLE
    y = problem.constraints[0].dual_value
    assert y > 0.0


def test_without_cvxpy_the_error_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    real = builtins.__import__

    def blind(name: str, *arguments: Any, **keywords: Any) -> Any:
        if name.split(".")[0] == "cvxpy":
            raise ModuleNotFoundError("No module named 'cvxpy'", name="cvxpy")
        return real(name, *arguments, **keywords)

    monkeypatch.delitem(sys.modules, "orbsoc.interfaces.cvxpy")
    monkeypatch.setattr(builtins, "__import__", blind)
    with pytest.raises(ImportError, match=r"pip install 'orbsoc\[cvxpy\]'"):
        _ = orbsoc.CVXPY


def test_import_orbsoc_imports_neither_cvxpy_nor_the_missions() -> None:
    code = (
        "import sys, orbsoc\n"
        "assert not {'cvxpy', 'orbsoc.missions', 'pydantic', 'matplotlib', 'typer'} & set(sys.modules)\n"
        "assert orbsoc.missions.reachable_insertion.plan\n"
        "try:\n    orbsoc.nothing\nexcept AttributeError as error:\n    print(error)\n"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout == "module 'orbsoc' has no attribute 'nothing'\n"
