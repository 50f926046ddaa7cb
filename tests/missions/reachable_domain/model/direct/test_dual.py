"""Newton on the dual of the condensed subproblem: against the interior-point method, for each kind of complementary cone pair."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import orbsoc
from orbsoc.guidance.scp import Rules
from orbsoc.missions.reachable_domain.model.direct.arcs import Arcs
from orbsoc.missions.reachable_domain.model.direct.condensed import CondensedBatch, condense
from orbsoc.missions.reachable_domain.model.direct.dual import DualSolutions, solve_dual
from orbsoc.missions.reachable_domain.model.direct.guess import towards_planes
from orbsoc.missions.reachable_domain.model.direct.sequence import Ending, sequences
from orbsoc.missions.reachable_domain.model.direct.subproblems import Subproblems
from orbsoc.missions.reachable_domain.model.direct.terminal import LargestOrbit, LargestTilt, Target
from orbsoc.missions.reachable_domain.search.continuation.domain import Domain
from orbsoc.orbit.planes import normals
from tests.missions.reachable_domain.cases import domain, paper, perigees

COLLOCATION = domain().tools.collocation(12)
PLANES = normals(np.deg2rad([28.18, 24.3, 20.3]), np.deg2rad([335.36, 334.25, 322.25]))
APART, TOUCHING = perigees(100.0, 200.0, 100.0), perigees(420.0, 400.0, 430.0)
TIGHT = 1e-10
AZIMUTHS = [30.0, 30.0, 40.0]
"""Where the furthest orbits with perigees of 400, 500 and 400 km are circular."""


@cache
def converged(kind: str) -> tuple[Target, Arcs]:
    """Targets whose cone pair is inactive, on the boundary, or at the vertex, and the arcs that they converge to."""
    if kind == "vertex":
        target: Target = LargestTilt(domain().frame, np.deg2rad(AZIMUTHS), perigees(400.0, 500.0, 400.0))
        normal = domain().frame.tilted(np.full(3, np.deg2rad(10.0)), np.deg2rad(AZIMUTHS))
    else:
        target, normal = LargestOrbit(PLANES, APART if kind == "apart" else TOUCHING), PLANES
    found = sequences(
        COLLOCATION, target, towards_planes(COLLOCATION, normal), solve=Subproblems.in_process(dual=False)
    )
    assert (found.ending == Ending.CONVERGED).all()
    return target, found.arcs


def subproblem(target: Target, about: Arcs) -> CondensedBatch:
    return condense(COLLOCATION.end_map(about), target.rows(about.ends))


def newton(batch: CondensedBatch, near: np.ndarray) -> DualSolutions:
    return solve_dual(batch, near[:, : batch.base.p], near[:, 3:], np.full(len(batch), TIGHT))


def nudged(arcs: Arcs) -> Arcs:
    """The same arcs a little off: the subproblem about them has another solution."""
    draw = np.random.default_rng(5)
    return Arcs(
        arcs.positions + 2e-4 * draw.normal(size=arcs.positions.shape),
        arcs.controls,
        arcs.ends + 2e-4 * draw.normal(size=arcs.ends.shape),
        arcs.multipliers,
    )


@pytest.mark.parametrize("kind", ["apart", "touching", "vertex"])
def test_newton_and_the_interior_point_method_find_one_solution(kind: str) -> None:
    """From the multipliers of a subproblem nearby, and with every residual of `orbsoc.verify` at its tolerance."""
    target, arcs = converged(kind)
    about = nudged(arcs)
    batch = subproblem(target, about)
    found = newton(batch, about.multipliers)
    assert found.solved.all()
    assert (found.steps >= 1).all()
    assert (found.steps <= 5).all()
    for k in range(len(batch)):
        problem = batch.problem(k)
        theirs = orbsoc.solve(problem, tol=1e-9)
        assert theirs.status is orbsoc.Status.SOLVED
        assert batch.c[k] @ found.x[k] == pytest.approx(theirs.objective, abs=3e-9)
        np.testing.assert_allclose(found.x[k], theirs.x, atol=1e-4)  # flat optimum, as the other solution's
        residual = problem.A @ found.x[k] - problem.b
        assert np.abs(residual).max() <= TIGHT * (1.0 + np.abs(problem.b).max())
        np.testing.assert_allclose(np.linalg.norm(found.x[k].reshape(-1, 3), axis=1), 1.0, atol=1e-12)
        slack = (problem.h - problem.G @ found.x[k])[-3:]
        assert np.hypot(*slack[1:]) - slack[0] <= TIGHT * (1.0 + np.abs(slack).max())
        if kind == "apart":
            assert not found.z[k].any()
        else:
            assert found.z[k][0] > 1e-3
            assert (np.abs(slack).max() < 1e-9) == (kind == "vertex")


def test_a_bound_that_begins_to_bind_is_found_from_no_multiplier() -> None:
    """The perigee's multiplier is zero at a low bound; at one above the perigee Newton finds it."""
    low, arcs = converged("apart")
    assert isinstance(low, LargestOrbit)
    raised = LargestOrbit(PLANES, perigees(340.0, 330.0, 330.0))
    batch = subproblem(raised, arcs)
    near = arcs.multipliers.copy()
    near[:, 3:] = 0.0
    found = newton(batch, near)
    assert found.solved.all()
    assert (found.z[:, 0] > 1e-4).all()
    for k in range(3):
        assert batch.c[k] @ found.x[k] == pytest.approx(
            orbsoc.solve(batch.problem(k), tol=1e-9).objective, abs=3e-9
        )


def test_what_newton_cannot_solve_is_not_called_solved() -> None:
    """A subproblem without a feasible point, and multipliers of the wrong kind."""
    target, arcs = converged("touching")
    far = LargestOrbit(normals(np.deg2rad([60.0] * 3), np.deg2rad([335.0] * 3)), TOUCHING)
    assert not newton(subproblem(far, arcs), arcs.multipliers).solved.any()
    wrong = arcs.multipliers.copy()
    wrong[:, 3:] = [5.0, 0.1, 0.0]  # as on a circular orbit
    found = newton(subproblem(target, arcs), wrong)
    assert not found.solved.any()


def test_the_interior_point_method_answers_for_the_rest() -> None:
    target, arcs = converged("touching")
    near = arcs.multipliers.copy()
    near[0], near[1, 3:] = np.nan, [5.0, 0.1, 0.0]
    batch = subproblem(target, nudged(arcs))
    rules = Rules()
    tight = np.ones(3, bool)
    mixed = Subproblems.in_process()(batch, near, tight, rules)
    alone = Subproblems.in_process(dual=False)(batch, near, tight, rules)
    assert mixed.usable.all()
    assert mixed.exact.all()
    np.testing.assert_allclose(mixed.controls, alone.controls, atol=1e-4)
    np.testing.assert_allclose(mixed.multipliers, alone.multipliers, atol=1e-5)
    assert mixed.iterations[2] < 6 < mixed.iterations[0]


def test_sweeps_with_and_without_the_dual_agree_on_every_verdict() -> None:
    planes = ([16.3, 22.3, 28.3, 24.3], [332.25, 346.25, 350.25, 334.25])
    both = [
        Domain.of(paper(), solve=Subproblems.in_process(dual=dual)).solve_planes(*planes)
        for dual in (True, False)
    ]
    assert list(both[0]["status"]) == list(both[1]["status"])
    np.testing.assert_allclose(both[0]["a_km"], both[1]["a_km"], rtol=1e-7)
    inner = [table["solver_iterations"][table.reached()].sum() for table in both]
    assert inner[0] < 0.5 * inner[1]
