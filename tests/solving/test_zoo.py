"""The zoo: its own answers are right, and the solver gives them, on every problem and on its rescaled twin."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy import optimize

from orbsoc.conic.problem import Problem
from orbsoc.conic.solution import Status
from orbsoc.conic.verify import check_certificate, verify
from orbsoc.interfaces import clarabel
from orbsoc.solving.solver import solve
from tests.zoo import ZooCase, cases, rescaled_twins

scipy_optimize: Any = optimize  # published without types

BASES = cases()
TWINS = rescaled_twins()
ALL = [*BASES, *TWINS]
INFEASIBLE = {Status.PRIMAL_INFEASIBLE, Status.DUAL_INFEASIBLE}

each = pytest.mark.parametrize("case", ALL, ids=[case.name for case in ALL])


def relative(value: float, reference: float) -> float:
    return abs(value - reference) / (1.0 + abs(reference))


def reference_objective(case: ZooCase) -> float:
    """The known value, or Clarabel's on the well scaled problem (scaling does not change it)."""
    if case.objective is not None:
        return case.objective
    base = next(b for b in BASES if b.name == case.name.removesuffix("_scaled"))
    answer = clarabel.solve(base.problem)
    assert answer.status is Status.SOLVED, f"no reference for {case.name}: {answer.message}"
    return answer.objective


@each
def test_the_solver_gives_the_known_answer(case: ZooCase) -> None:
    """Status, value to 1e-7, verified residual to 1e-8 (1e-7 where scaled); claims with their certificate."""
    solution = solve(case.problem)
    found = verify(case.problem, solution)
    assert solution.status in case.expected, f"{solution.message}; {found}"
    if case.solvable:
        assert found.worst <= (1e-7 if case.scaled else 1e-8), found
        assert relative(solution.objective, reference_objective(case)) <= 1e-7
    else:
        residuals = check_certificate(case.problem, solution)
        assert residuals.supports(solution.status, 1e-8), residuals


@each
def test_no_limit_makes_the_solver_lie(case: ZooCase) -> None:
    """Stopped at any iteration, it claims nothing that the data or the known answer contradict."""
    for limit in (1, 2, 4, 7):
        solution = solve(case.problem, max_iterations=limit)
        if solution.status in (Status.SOLVED, Status.SOLVED_INACCURATE):
            assert case.solvable
            assert verify(case.problem, solution).worst <= 1e-5
        elif solution.status in INFEASIBLE:
            assert solution.status in case.expected
            assert check_certificate(case.problem, solution).supports(solution.status, 1e-8)


@each
def test_clarabel_agrees_with_the_known_answer(case: ZooCase) -> None:
    """Independent of our solver, at 1e-6: the zoo itself is right. Where Clarabel fails, the record must say so."""
    solution = clarabel.solve(case.problem)
    right = solution.status in case.expected
    if case.solvable and solution.status in (Status.SOLVED, Status.SOLVED_INACCURATE):
        value = relative(solution.objective, reference_objective(case))
        right = value <= 1e-6 and verify(case.problem, solution).worst <= 1e-6
    recorded = case.clarabel_fails
    assert right == (recorded is None), (
        f"recorded: {recorded}; found: {solution.status.name}, {solution.message}"
    )


def is_linear(problem: Problem) -> bool:
    return not problem.cones.q and problem.P.nnz == 0


LINEAR = [case for case in BASES if is_linear(case.problem)]


@pytest.mark.parametrize("case", LINEAR, ids=[case.name for case in LINEAR])
def test_a_simplex_method_agrees_on_every_linear_program(case: ZooCase) -> None:
    """HiGHS (through SciPy), a method of another kind, verifies a second time the LPs."""
    problem = case.problem
    rows = np.isfinite(problem.h)
    answer = scipy_optimize.linprog(
        problem.c,
        A_ub=problem.G.toarray()[rows] if rows.any() else None,
        b_ub=problem.h[rows] if rows.any() else None,
        A_eq=problem.A.toarray() if problem.p else None,
        b_eq=problem.b if problem.p else None,
        bounds=(None, None),
        method="highs",
        options={"presolve": False},  # with it, "infeasible or unbounded" is all one may get
    )
    if case.solvable:
        assert answer.status == 0, answer.message
        assert relative(answer.fun, reference_objective(case)) <= 1e-7
    else:
        codes = {Status.PRIMAL_INFEASIBLE: {2}, Status.DUAL_INFEASIBLE: {3}}
        assert answer.status in set().union(*(codes[status] for status in case.expected)) | {4}, (
            answer.message
        )


@pytest.mark.parametrize("case", BASES, ids=[case.name for case in BASES])
def test_a_twin_is_the_same_problem_in_other_units(case: ZooCase) -> None:
    """Same sizes and pattern, entries spread over decades, one factor per second-order cone."""
    twin = TWINS[BASES.index(case)].problem
    for name in "PAG":
        one, other = getattr(case.problem, name).toarray(), getattr(twin, name).toarray()
        assert np.array_equal(one != 0.0, other != 0.0)
    assert twin.cones == case.problem.cones
    for rows in case.problem.cones.second_order():
        for column in [*range(case.problem.n), None]:
            one, other = (
                (p.h if column is None else p.G.toarray()[:, column])[rows] for p in (case.problem, twin)
            )
            factors = other[one != 0.0] / one[one != 0.0]
            assert factors.size == 0 or factors.max() <= factors.min() * (1.0 + 1e-12)


def test_the_zoo_is_as_large_and_as_varied_as_it_says() -> None:
    names = [case.name for case in ALL]
    sizes = {size for case in BASES for size in case.problem.cones.q}
    assert len(set(names)) == len(names) >= 2 * 55
    assert {1, 2, 3, 4, 5, 300} <= sizes
    assert sum(case.name.startswith("known_") for case in BASES) >= 15
    assert sum(case.expected == {Status.PRIMAL_INFEASIBLE} for case in BASES) >= 10
    assert sum(case.expected == {Status.DUAL_INFEASIBLE} for case in BASES) >= 10
    assert sum(case.objective is not None for case in BASES) >= 55


def test_the_update_that_rescales_columns_keeps_pattern_and_value() -> None:
    by_name = {case.name: case for case in BASES}
    before, after = by_name["lie_before_columns_are_rescaled"], by_name["lie_after_columns_are_rescaled"]
    assert before.problem.A.indices.tobytes() == after.problem.A.indices.tobytes()
    assert relative(reference_objective(after), reference_objective(before)) <= 1e-7


def test_an_update_that_rescales_columns_is_solved_like_fresh_data() -> None:
    """Known false claim: the equilibration of the first data kept for the second."""
    from orbsoc.solving.solver import Solver

    by_name = {case.name: case for case in BASES}
    before, after = by_name["lie_before_columns_are_rescaled"], by_name["lie_after_columns_are_rescaled"]
    solver = Solver(before.problem)
    assert solver.solve().status is Status.SOLVED
    solver.update(c=after.problem.c, A=after.problem.A, G=after.problem.G)
    updated, fresh = solver.solve(), Solver(after.problem).solve()
    assert updated.status is Status.SOLVED
    assert verify(after.problem, updated).worst <= 1e-7
    assert updated.x.tobytes() == fresh.x.tobytes()


def test_no_iterate_of_the_previous_solve_is_returned_for_updated_data() -> None:
    """Known false claim: a best iterate remembered from the solve before; stopped early, only the new one may come back."""
    from orbsoc.solving.solver import Solver

    problem = next(case.problem for case in BASES if case.name == "known_socp_sizes")
    b = problem.b + 1e3
    for limit in (1, 2, 3):
        solver = Solver(problem, max_iterations=limit)
        solver.solve()
        solver.update(b=b)
        fresh = Solver(
            Problem(c=problem.c, A=problem.A, b=b, G=problem.G, h=problem.h, cones=problem.cones),
            max_iterations=limit,
        )
        updated = solver.solve()
        assert updated.status is not Status.SOLVED
        assert updated.x.tobytes() == fresh.solve().x.tobytes()
