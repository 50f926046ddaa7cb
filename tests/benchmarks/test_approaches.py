"""Approaches without interior: orbsoc has an answer to each, and what counts as lost is found."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

import orbsoc
from benchmarks.approaches import GRIDS, answered, grade, grid, lost, robust, tally
from benchmarks.grading import Graded
from benchmarks.peers import orbsoc as ours
from orbsoc.conic.solution import Status

EVERY = 6


@pytest.mark.parametrize("row", GRIDS)
def test_grids_without_interior_are_answered(row: tuple[float, float, float, float]) -> None:
    for asked in list(grid(*row))[::EVERY]:
        found = grade(ours.solver(), asked, tol=1e-8)
        assert answered(found), (asked.name, found.status, found.residual)
        assert found.status != Status.NUMERICAL_LIMIT.name


def test_robust_rendezvous_end_solved_or_proved_infeasible() -> None:
    statuses = [orbsoc.solve(robust(seed).problem).status for seed in range(20)]
    assert set(statuses) == {Status.SOLVED, Status.PRIMAL_INFEASIBLE}


def _row(solver: str, **changes: Any) -> Graded:
    row = Graded(
        "approaches", "one", "", solver, "", "", 1e-8, "", "SOLVED", "SOLVED", "", 10, 0.0, 0.0,
        pres=1e-9, dres=1e-9, gap=1e-9, radius=float("nan"),
    )  # fmt: skip
    return replace(row, **changes)


def test_lost_is_what_a_peer_answers_and_orbsoc_does_not() -> None:
    good, poor = _row("Clarabel", status="AlmostSolved", claim="", gap=8e-6), _row("Clarabel", gap=2e-5)
    limit = _row("orbsoc", status="NUMERICAL_LIMIT", claim="", gap=3e-5)
    assert len(lost([limit], [[good]])) == 1
    assert lost([limit], [[poor]]) == []
    assert lost([_row("orbsoc")], [[good]]) == []


def test_iterations_are_compared_where_both_have_an_answer() -> None:
    mine = [_row("orbsoc", iterations=12), _row("orbsoc", iterations=90)]
    theirs = [_row("Clarabel", iterations=8), _row("Clarabel", iterations=30, gap=1.0, claim="")]
    found = tally(mine, theirs)
    assert (found.answered, found.iterations, found.over_reference, found.worst) == (2, 12.0, 1.5, 1.5)
