"""CVXPY's own standard tests of conic solvers, from its wheel, unmodified: what a solver must pass to be one of CVXPY's.

Left out are the tests of what orbsoc does not solve (integers; exponential, power and semidefinite cones), test_lp_7,
which asserts nothing without a package of multiprecision arithmetic, and the two tests that a solver without CVXPY's flag
BOUNDED_VARIABLES cannot pass, because they assert the flag. Solves of these three problems are here.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from cvxpy.tests import solver_test_helpers as standard

import orbsoc

FAMILIES = {
    "lp": standard.StandardTestLPs,
    "qp": standard.StandardTestQPs,
    "socp": standard.StandardTestSOCPs,
    "infeasible": standard.StandardTestInfeasibleProblems,
}
UNSUPPORTED = ("_mi_", "_lp_7", "power_cone", "exp_cone", "psd_cone", "exp_mixed", "_bound_attr")
TESTS: dict[str, Callable[..., Any]] = {
    f"{family}-{name}": getattr(tests, name)
    for family, tests in FAMILIES.items()
    for name in dir(tests)
    if name.startswith("test_") and not any(part in name for part in UNSUPPORTED)
}


def test_the_wheel_has_the_tests_that_we_know() -> None:
    assert len(TESTS) == 19, sorted(TESTS)


@pytest.mark.parametrize("test", TESTS.values(), ids=TESTS)
def test_standard(test: Callable[..., Any]) -> None:
    test(solver=orbsoc.CVXPY())


@pytest.mark.parametrize("name", ["lp-test_lp_1", "lp-test_lp_2", "qp-test_qp_0"])
def test_standard_to_seven_places_at_a_tighter_tolerance(name: str) -> None:
    """Those whose expected values are exact; the SOCPs' are recorded to six digits."""
    TESTS[name](solver=orbsoc.CVXPY(orbsoc.Settings(tol=1e-10)), places=7)


def test_standard_with_the_quadratic_objective_as_a_cone() -> None:
    standard.StandardTestQPs.test_qp_0(solver=orbsoc.CVXPY(), use_quad_obj=False)


@pytest.mark.parametrize("make", [standard.lp_7, standard.lp_bound_attr, standard.qp_bound_attr])
def test_the_problems_of_the_tests_left_out_are_solved(make: Callable[[], Any]) -> None:
    problem = make()
    problem.solve(orbsoc.CVXPY())
    problem.verify_objective(places=4)
