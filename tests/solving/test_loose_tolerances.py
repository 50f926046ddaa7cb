"""A loose tolerance says how exact a solution must be; what proves that there is none is as good as at a tight one."""

from __future__ import annotations

import numpy as np
import pytest

import orbsoc
from orbsoc.conic.problem import Cones, Problem
from orbsoc.conic.solution import Status

LOOSE = (1e-3, 1e-4, 1e-6)


def crossed_bounds(seed: int) -> Problem:
    """A flat quadratic in a box, one of whose sides lies beyond the other by a tenth or a hundredth."""
    rng = np.random.default_rng(seed)
    n, rank = int(rng.integers(5, 60)), int(rng.integers(1, 8))
    factor = rng.standard_normal((n, rank))
    h = np.ones(2 * n)
    h[n] = -1.0 - 10.0 ** -rng.integers(1, 3)
    G = np.vstack([np.eye(n), -np.eye(n)])
    return Problem(P=factor @ factor.T, c=rng.standard_normal(n), G=G, h=h, cones=Cones(l=2 * n))


def sloping_ray(seed: int) -> Problem:
    """A cost that falls by a hundredth along a ray inside a polyhedron and a cone, and is flat there to second order."""
    rng = np.random.default_rng(seed)
    n, m, q = int(rng.integers(6, 40)), int(rng.integers(4, 40)), int(rng.integers(3, 8))
    ray = rng.standard_normal(n)
    ray /= np.linalg.norm(ray)

    def across(rows: np.ndarray) -> np.ndarray:
        return rows - np.outer(rows @ ray, ray)

    factor = across(rng.standard_normal((n // 2, n)))
    slopes = np.where(rng.random(m) < 0.5, rng.uniform(0.0, 1.0, m), 0.0)
    halfspaces = across(rng.standard_normal((m, n))) - np.outer(slopes, ray)
    cone = np.vstack([-0.5 * ray, across(rng.standard_normal((q, n)))])
    return Problem(
        P=factor.T @ factor,
        c=across(rng.standard_normal((1, n)))[0] - 1e-2 * ray,
        G=np.vstack([halfspaces, cone]),
        h=np.concatenate([rng.uniform(0.1, 1.0, m), [1.0], np.zeros(q)]),
        cones=Cones(l=m, q=[q + 1]),
    )


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize(
    ("draw", "status"),
    [(crossed_bounds, Status.PRIMAL_INFEASIBLE), (sloping_ray, Status.DUAL_INFEASIBLE)],
    ids=["crossed bounds", "sloping ray"],
)
def test_infeasibility_takes_no_longer_to_prove(draw, status: Status, seed: int) -> None:
    problem = draw(seed)
    tight = orbsoc.solve(problem)
    assert tight.status is status, tight.message
    for tol in LOOSE:
        loose = orbsoc.solve(problem, tol=tol)
        assert loose.status is status, (tol, loose.message)
        assert loose.iterations <= tight.iterations, tol
