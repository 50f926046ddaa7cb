"""The solver's panels of L: single solves and batches have other ones than the recorded streams, and the same bits."""

from __future__ import annotations

import numpy as np
import pytest

import orbsoc
from orbsoc import _core
from orbsoc.conic.problem import Problem
from tests.zoo import ZooCase, cases, rescaled_twins

SETTINGS = orbsoc.Settings()
VECTORS = ("x", "y", "z", "s")


def of_two_levels(tasks: int, rows: int, shared: int, window: int, seed: int) -> Problem:
    """Least squares of several tasks: each row has its task's offset, and one of two windows of shared columns."""
    rng = np.random.default_rng(seed)
    m = 2 * tasks * rows
    task, second = np.divmod(np.arange(m), 2 * rows)
    A = np.zeros((m, m + tasks + shared))
    A[:, :m] = -np.eye(m)
    A[np.arange(m), m + task] = 1.0
    first = m + tasks + (second >= rows) * (shared - window)
    for column in range(window):
        A[np.arange(m), first + column] = rng.normal(size=m)
    P = np.diag(np.r_[np.ones(m), np.zeros(tasks + shared)])
    return Problem(P=P, c=np.zeros(A.shape[1]), A=A, b=rng.normal(size=m))


def same_bits_everywhere(problem: Problem) -> orbsoc.Solution:
    """The single solve, after it was found to have the bits of a batch's and of one on the streams' own panels."""
    single = orbsoc.solve(problem)
    batch = orbsoc.solve_batch(problem, c=problem.c[None])
    exact = _core.ExactEngine(problem, SETTINGS, 64).solve()
    assert single.status.name == batch.status[0].name == exact.status
    for name in VECTORS:
        entries = getattr(single, name).tobytes()
        assert getattr(batch, name)[0].tobytes() == entries, f"{name} of the batch"
        assert getattr(exact, name).tobytes() == entries, f"{name} on exact panels"
    return single


@pytest.mark.parametrize("case", [*cases(), *rescaled_twins()], ids=lambda case: case.name)
def test_a_problem_of_the_zoo_has_the_same_bits_on_all_panels(case: ZooCase) -> None:
    same_bits_everywhere(case.problem)


@pytest.mark.parametrize("tasks", [1, 4, 9])
@pytest.mark.parametrize("rows", [2, 4, 7])
@pytest.mark.parametrize(("shared", "window"), [(6, 5), (8, 5), (12, 11), (12, 9), (20, 19)])
def test_columns_that_nearly_share_their_rows_have_the_same_bits_on_all_panels(
    tasks: int, rows: int, shared: int, window: int
) -> None:
    problem = of_two_levels(tasks, rows, shared, window, seed=tasks + rows)
    assert same_bits_everywhere(problem).status is orbsoc.Status.SOLVED
