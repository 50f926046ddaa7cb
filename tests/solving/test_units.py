"""A verdict does not depend on the units of rows, columns and objective."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import orbsoc
from orbsoc.conic.solution import Status
from orbsoc.conic.verify import RADIUS_FACTOR, check_certificate
from tests.zoo.unsolvable import SCALINGS, drawn, in_units

SEEDS = range(40)


@pytest.mark.parametrize("scaling", SCALINGS)
def test_no_solution_in_one_system_of_units_is_none_in_another(scaling: str) -> None:
    """Same verdict, with a proof that holds on the data in those units."""
    for seed in SEEDS:
        problem, verdict = drawn(seed)
        assert orbsoc.solve(problem).status is verdict, seed
        rescaled = in_units(problem, scaling, seed)
        found = orbsoc.solve(rescaled)
        assert found.status is verdict, (seed, found.message)
        assert check_certificate(rescaled, found).supports(found.status, 1e-8), seed


@pytest.mark.parametrize(("seed", "scaling"), [(168, "rows 1e-8"), (16778, "columns 1e-8")])
def test_the_stronger_proof_is_told_where_both_are_weak_in_their_own_scale(seed: int, scaling: str) -> None:
    """A residual of 1.2e-8 against a proof for all points below 1e6; own radii of 0.17 and 0.18, which say less than the data's scale."""
    problem, verdict = drawn(seed)
    assert orbsoc.solve(in_units(problem, scaling, seed)).status is verdict


@pytest.mark.parametrize("scaling", ["rows 1e8", "columns 1e8"])
def test_large_units_cost_few_iterations(scaling: str) -> None:
    """A radius need not be 1e8 times the data where these are 1e8."""
    ratios = []
    for seed in SEEDS:
        problem, _ = drawn(seed)
        iterations = [orbsoc.solve(each).iterations for each in (problem, in_units(problem, scaling, seed))]
        ratios.append(iterations[1] / iterations[0])
    assert np.median(ratios) <= 1.5


@pytest.mark.parametrize("seed", range(10))
def test_a_far_solution_in_small_columns_is_found(seed: int) -> None:
    """A quadratic cost in columns of 1e-8, where the solution is 1e13: half of these were called infeasible or unbounded."""
    rng = np.random.default_rng(seed)
    A, G, x, y = (rng.normal(size=shape) for shape in ((1, 3), (6, 3), 3, 1))
    x, z, slack = 1e5 * x, *(np.abs(rng.normal(size=(2, 6))) + 0.1)
    problem = orbsoc.Problem(
        P=A.T @ A,
        c=-(A.T @ (A @ x + y) + G.T @ z),
        A=A,
        b=A @ x,
        G=G,
        h=G @ x + slack,
        cones=orbsoc.Cones(l=6),
    )
    found = orbsoc.solve(in_units(problem, "columns 1e-8", seed))
    assert found.status is Status.SOLVED, found.message


@pytest.mark.parametrize("seed", range(20))
def test_the_radius_in_a_proofs_own_scale_is_the_same_in_other_units(
    seed: int,
) -> None:
    problem, verdict = drawn(seed)
    rng = np.random.default_rng(seed)
    found = orbsoc.solve(problem)
    noisy = {
        name: getattr(found, name) * (1.0 + 1e-4 * rng.normal(size=getattr(found, name).size))
        for name in "xyz"
    }
    before = check_certificate(problem, replace(found, **noisy))
    rows, cone_rows, columns = (
        2.0 ** rng.integers(-20, 21, size) for size in (problem.p, problem.m, problem.n)
    )
    for cone in problem.cones.second_order():
        cone_rows[cone] = cone_rows[cone.start]
    other = orbsoc.Problem(
        P=problem.P.toarray() * np.outer(columns, columns) if problem.P.nnz else None,
        c=problem.c * columns,
        A=rows[:, None] * problem.A.toarray() * columns,
        b=problem.b * rows,
        G=cone_rows[:, None] * problem.G.toarray() * columns,
        h=problem.h * cone_rows,
        cones=problem.cones,
    )
    moved = {"x": noisy["x"] / columns, "y": noisy["y"] / rows, "z": noisy["z"] / cone_rows}
    after = check_certificate(other, replace(found, **moved))
    assert found.status is verdict
    assert before.own_radius > 0.0
    assert after.own_radius == pytest.approx(before.own_radius, rel=1e-12)


def test_a_proof_is_good_in_its_own_scale_where_right_hand_sides_are_large_in_the_users() -> None:
    """x ≥ 2 and x ≤ 1 in rows of 1e8, where 2e8 is the data's scale, and by a proof that misses by 1e-6 of its terms."""
    problem = orbsoc.Problem(c=[1.0], G=[[-1e8], [1e8]], h=[-2e8, 1e8], cones=orbsoc.Cones(l=2))
    proof = orbsoc.solve(orbsoc.Problem(c=[1.0], G=[[-1.0], [1.0]], h=[-2.0, 1.0], cones=orbsoc.Cones(l=2)))
    found = check_certificate(problem, replace(proof, z=np.array([1.0, 1.0 + 1e-6])))
    assert found.radius < RADIUS_FACTOR * found.scale
    assert found.own_radius >= RADIUS_FACTOR
    assert found.supports(Status.PRIMAL_INFEASIBLE, 1e-8)
