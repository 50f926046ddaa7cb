"""What every peer is told is the same problem, and what it answers is in our signs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import orbsoc
from benchmarks import peers
from benchmarks.peers import piqp, qocogen
from orbsoc.conic.problem import Cones, Problem
from orbsoc.conic.verify import primal_infeasibility_radius


def disc(P: object = None) -> Problem:
    """min ½xᵀPx + x₁ + 2x₂ + x₃ over ‖(x₁, x₂)‖ ≤ 1, x₃ ≥ 0, x₁ = x₂ + ½, and a row that does not constrain."""
    G = np.array([[0, 0, -1], [1, 1, 1], [0, 0, 0], [-1, 0, 0], [0, -1, 0]], dtype=float)
    h = [0.0, np.inf, 1.0, 0.0, 0.0]
    return Problem(P=P, c=[1.0, 2.0, 1.0], A=[[1.0, -1.0, 0.0]], b=[0.5], G=G, h=h, cones=Cones(2, [3]))


def box(P: np.ndarray | None = None) -> Problem:
    """Bounds, one of them twice, a row with two entries, one that does not constrain, and an equality."""
    G = np.array(
        [[-2, 0, 0], [1, 1, 0], [0, 2, 0], [0, 0, -1], [-1, 0, 0], [-4, 0, 0], [0, 0, 1]], dtype=float
    )
    h = [2.0, 4.0, 6.0, 2.0, 1.5, 8.0, np.inf]
    return Problem(P=P, c=[1.0, -2.0, 1.0], A=[[1.0, -1.0, 1.0]], b=[0.5], G=G, h=h, cones=Cones(7))


@pytest.mark.parametrize("name", ["orbsoc", "clarabel", "ecos", "qoco", "scs"])
def test_a_solver_that_is_there_answers_in_our_signs(name: str) -> None:
    found, missing = peers.solvers((name,))
    if not found:  # ECOS, QOCO and SCS are in the bench lock only: then the answer is a line that says so
        assert name in missing[0]
        assert "make bench" in missing[0]
        return
    answer = found[0].variants[0].solve(disc(), 1e-8)
    assert orbsoc.verify(disc(), answer).worst <= 1e-7
    assert answer.z[1] == 0.0
    assert answer.iterations > 0
    assert answer.solve_s > 0.0


@pytest.mark.parametrize("name", ["piqp_sparse", "piqp_dense", "highs"])
@pytest.mark.parametrize("P", [None, np.diag([2.0, 0.0, 3.0])])
def test_a_solver_of_quadratic_programmes_answers_in_our_signs(name: str, P: np.ndarray | None) -> None:
    found, missing = peers.solvers((name,))
    if not found:
        assert "make bench" in missing[0]
        return
    problem = box(P)
    [solver] = found
    assert solver.applies(problem)
    assert not solver.applies(disc())
    answer = solver.variants[0].solve(problem, 1e-8)
    assert answer.claim == "SOLVED"
    assert orbsoc.verify(problem, answer).worst <= 1e-7


def test_ecos_stays_away_from_quadratic_costs() -> None:
    for solver in peers.solvers(("ecos",))[0]:
        assert solver.applies(disc())
        assert not solver.applies(disc(np.eye(3)))


def test_bounds_and_general_rows_are_told_apart_and_put_together_again() -> None:
    split = piqp.Split.of(box())
    assert split.general.tolist() == [1, 4, 5]  # one with two entries; the second bounds of variable 0
    assert split.lower.tolist() == [-1.0, -np.inf, -2.0]
    assert split.upper.tolist() == [np.inf, 3.0, np.inf]
    z = split.multipliers(7, np.array([5.0, 6.0, 7.0]), np.array([1.0, 0.0, 2.0]), np.array([0.0, 3.0, 0.0]))
    assert z.tolist() == [0.5, 5.0, 1.5, 2.0, 6.0, 7.0, 0.0]


@pytest.mark.parametrize("name", ["orbsoc", "clarabel", "ecos", "scs", "piqp_sparse", "highs"])
def test_a_claim_of_infeasibility_comes_in_our_words_with_its_proof(name: str) -> None:
    found, _ = peers.solvers((name,))
    problem = Problem(c=[1.0, 1.0], G=[[1.0, 1.0], [-1.0, -1.0]], h=[1.0, -2.0], cones=Cones(l=2))
    for solver in found:
        answer = solver.variants[0].solve(problem, 1e-8)
        assert answer.claim == "PRIMAL_INFEASIBLE"
        if name != "piqp_sparse":  # it keeps no certificate
            assert primal_infeasibility_radius(problem, answer.y, answer.z) > 1e3


def test_qocogen_takes_part_where_its_code_was_compiled_only(tmp_path: Path, monkeypatch: Any) -> None:
    monkeypatch.setattr(qocogen, "LIBRARIES", tmp_path)
    found, missing = peers.solvers(("qocogen",))
    assert bool(found) != bool(missing)
    assert not any(solver.applies(disc()) for solver in found)


def test_an_unknown_solver_is_named() -> None:
    with pytest.raises(ValueError, match=r"'mosek'.*clarabel"):
        peers.solvers(("mosek",))
