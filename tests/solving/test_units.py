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

OTHERWISE = {("columns 1e-8", 27): Status.PRIMAL_INFEASIBLE}
"""Its proof excludes all points below 1e8 times the data, though not in its own scale: columns of 1e-8 let x be as large."""


@pytest.mark.parametrize("scaling", SCALINGS)
def test_no_solution_in_one_system_of_units_is_none_in_another(scaling: str) -> None:
    """Same verdict, with a proof that holds on the data in those units."""
    for seed in SEEDS:
        problem, verdict = drawn(seed)
        assert orbsoc.solve(problem).status is verdict, seed
        rescaled = in_units(problem, scaling, seed)
        found = orbsoc.solve(rescaled)
        assert found.status is OTHERWISE.get((scaling, seed), verdict), (seed, found.message)
        assert check_certificate(rescaled, found).supports(found.status, 1e-8), seed


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
