"""Rows and variables with two-sided bounds in the builder, held against HiGHS and the conditions of optimality."""

from __future__ import annotations

import re

import numpy as np
import pytest
from scipy.optimize import linprog

import orbsoc
from orbsoc.conic.builder import BuilderError, ConicBuilder


def random_lp(seed: int) -> tuple[np.ndarray, ...]:
    """c, M, lower, upper of rows, and of variables: of every kind, with a point within them."""
    random = np.random.default_rng(seed)
    rows, n = 12, 8
    M, inside = random.normal(size=(rows, n)), random.normal(size=n)
    low = M @ inside - random.uniform(0.1, 2.0, rows)
    high = M @ inside + random.uniform(0.1, 2.0, rows)
    low[:2] = high[:2] = (M @ inside)[:2]
    low[2:4], high[4:6] = -np.inf, np.inf
    least, most = inside - random.uniform(0.1, 2.0, n), inside + random.uniform(0.1, 2.0, n)
    most[0] = least[0] = inside[0]
    return random.normal(size=n), M, low, high, least, most


@pytest.mark.parametrize("seed", range(8))
def test_the_optimum_and_the_multipliers_are_those_of_highs(seed: int) -> None:
    c, M, low, high, least, most = random_lp(seed)
    b = ConicBuilder()
    x = b.variable("x", c.size)
    b.cost(x, c)
    b.between(low, [(x, M)], high, name="rows")
    b.bounds(x, least, most, name="bounds")
    solution = orbsoc.solve(b.build(), tol=1e-10)
    equal, above, below = low == high, (low < high) & (high < np.inf), (low < high) & (low > -np.inf)
    found = linprog(
        c,
        A_ub=np.vstack([M[above], -M[below]]),
        b_ub=np.concatenate([high[above], -low[below]]),
        A_eq=M[equal],
        b_eq=high[equal],
        bounds=np.column_stack([least, most]),
    )
    assert solution.objective == pytest.approx(found.fun, abs=1e-7)
    rows, bounds = b.dual(solution, "rows"), b.dual(solution, "bounds")
    np.testing.assert_allclose(c + M.T @ rows + bounds, 0.0, atol=1e-7)
    expected = np.zeros(low.size)
    expected[above] -= found.ineqlin.marginals[: above.sum()]
    expected[below] += found.ineqlin.marginals[above.sum() :]
    expected[equal] -= found.eqlin.marginals
    np.testing.assert_allclose(rows, expected, atol=1e-5)


def test_an_infinite_bound_makes_no_row_and_one_number_serves_all_rows() -> None:
    b = ConicBuilder()
    x = b.variable("x", 3)
    b.between(-1.0, [(x, np.eye(3))], [np.inf, 2.0, -1.0])
    b.bounds(x.index[:1], -np.inf, 4.0)
    problem = b.build()
    assert (problem.p, problem.m) == (1, 4)
    assert sorted(problem.h) == [1.0, 1.0, 2.0, 4.0]


def test_why_names_two_sided_rows() -> None:
    b = ConicBuilder()
    x = b.variable("x", 2)
    b.bounds(x, 0.0, 1.0, name="box")
    b.between(3.0, [(x, np.ones((1, 2)))], 4.0, name="sum")
    solution = orbsoc.solve(b.build())
    assert solution.status is orbsoc.Status.PRIMAL_INFEASIBLE
    assert re.search(r"met together: sum \(\d+ %\) and box \(\d+ %\)", b.why(solution))


@pytest.mark.parametrize(
    ("low", "high", "message"),
    [
        (2.0, 1.0, "between 2.0 and 1.0"),
        (np.nan, 1.0, "between nan and 1.0"),
        (np.inf, np.inf, "between inf and inf"),
        ([0.0, 0.0], 1.0, "needs|need"),
        ([0.0] * 3, [1.0] * 2, r"upper has shape \(2,\)"),
    ],
)
def test_bounds_that_are_none_are_named(low: object, high: object, message: str) -> None:
    b = ConicBuilder()
    x = b.variable("x", 3)
    with pytest.raises(BuilderError, match=message):
        b.between(low, [(x, np.eye(3))], high)  # type: ignore[arg-type]
