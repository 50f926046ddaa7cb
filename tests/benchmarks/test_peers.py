"""What every peer is told is the same problem, and what it answers is in our signs."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import sparse

import orbsoc
from benchmarks import peers
from orbsoc.problem import Cones, Problem


def disc(P: object = None) -> Problem:
    """min ½xᵀPx + x₁ + 2x₂ + x₃ over ‖(x₁, x₂)‖ ≤ 1, x₃ ≥ 0, x₁ = x₂ + ½, and a row that does not constrain."""
    G = np.array([[0, 0, -1], [1, 1, 1], [0, 0, 0], [-1, 0, 0], [0, -1, 0]], dtype=float)
    h = [0.0, np.inf, 1.0, 0.0, 0.0]
    return Problem(P=P, c=[1.0, 2.0, 1.0], A=[[1.0, -1.0, 0.0]], b=[0.5], G=G, h=h, cones=Cones(2, [3]))


@pytest.mark.parametrize("name", ["orbsoc", "clarabel", "ecos", "qoco"])
def test_a_solver_that_is_there_answers_in_our_signs(name: str) -> None:
    found, missing = peers.solvers((name,))
    if not found:  # ECOS and QOCO are in the bench lock only: then the answer is a line that says so
        assert name in missing[0]
        assert "make bench" in missing[0]
        return
    answer = found[0].variants[0].solve(disc(), 1e-8)
    assert orbsoc.verify(disc(), answer).worst <= 1e-7
    assert answer.z[1] == 0.0
    assert answer.iterations > 0
    assert answer.solve_s > 0.0


def test_an_unknown_solver_is_named() -> None:
    with pytest.raises(ValueError, match=r"'mosek'.*clarabel"):
        peers.solvers(("mosek",))


@pytest.mark.parametrize(
    "P", [np.diag([2.0, 0.0, 3.0]), np.array([[2.0, 1.0, 0.0], [1.0, 2.0, 0.0], [0.0, 0.0, 0.0]])]
)
def test_the_epigraph_of_a_quadratic_cost_is_the_same_problem(P: np.ndarray) -> None:
    problem = disc(P)
    kept = np.isfinite(problem.h)
    rows = sparse.csr_array(problem.G)[kept]
    c, A, G, h, q = peers._with_epigraph(problem, rows, problem.h[kept], [3])
    conic = orbsoc.solve(Problem(c=c, A=A, b=problem.b, G=G, h=h, cones=Cones(1, q)), tol=1e-10)
    direct = orbsoc.solve(problem, tol=1e-10)
    assert conic.objective == pytest.approx(direct.objective, abs=1e-8)
    assert conic.x[-1] == pytest.approx(0.5 * direct.x @ P @ direct.x, abs=1e-4)
