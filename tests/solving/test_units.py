"""A verdict does not depend on the units of rows, columns and objective."""

from __future__ import annotations

import numpy as np
import pytest

import orbsoc
from orbsoc.conic.own_scale import dual_scale, primal_scale
from orbsoc.conic.verify import check_certificate
from tests.zoo.unsolvable import SCALINGS, drawn, in_units

SEEDS = range(40)


@pytest.mark.parametrize("scaling", SCALINGS)
def test_no_solution_in_one_system_of_units_is_none_in_another(scaling: str) -> None:
    """Same verdict, with a proof that holds on the data in those units; in the median, no more than half as many iterations again."""
    ratios = []
    for seed in SEEDS:
        problem, verdict = drawn(seed)
        before, rescaled = orbsoc.solve(problem), in_units(problem, scaling, seed)
        after = orbsoc.solve(rescaled)
        assert before.status is verdict, (seed, before.message)
        assert after.status is verdict, (seed, after.message)
        assert check_certificate(rescaled, after).supports(verdict, 1e-8), seed
        ratios.append(after.iterations / before.iterations)
    assert np.median(ratios) <= 1.5


@pytest.mark.parametrize("scaling", SCALINGS)
@pytest.mark.parametrize("seed", range(6))
def test_the_own_scale_of_a_problem_moves_with_its_units(seed: int, scaling: str) -> None:
    """What x may be, in units of x, and the largest right-hand side beside it: the same problem in other words."""
    problem, _ = drawn(seed)
    rescaled = in_units(problem, scaling, seed)
    for scale in (primal_scale, dual_scale):
        before, after = scale(problem), scale(rescaled)
        assert after.largest_side == pytest.approx(before.largest_side, rel=1e-2)
    entries = np.abs(problem.A.toarray()).sum(axis=0) + np.abs(problem.G.toarray()).sum(axis=0)
    used = np.flatnonzero(entries)
    sizes, columns = primal_scale(rescaled).sizes / primal_scale(problem).sizes, rescaled.c / problem.c
    products = (sizes * columns)[used]
    assert products == pytest.approx(np.full(used.size, products[0]), rel=1e-2)


def test_rows_in_other_units_keep_verdict_and_iterations() -> None:
    """x ≥ 2 and x ≤ 1 in rows multiplied by 3e5, in which a point is nearly feasible."""
    G, h = np.array([[-1.0, 0.0], [1.0, 0.0], [0.0, -1.0]]), np.array([-2.0, 1.0, 0.0])
    found = [
        orbsoc.solve(orbsoc.Problem(c=[1.0, 1.0], G=u * G, h=u * h, cones=orbsoc.Cones(l=3)))
        for u in (1.0, 1e4, 3e5, 1e8)
    ]
    assert {solution.status for solution in found} == {orbsoc.Status.PRIMAL_INFEASIBLE}
    assert max(solution.iterations for solution in found) <= found[0].iterations + 3
