"""A skipped residual check of a linear solve does not let an attempt diverge (decision 0005)."""

from __future__ import annotations

import numpy as np

import orbsoc


def test_an_error_that_was_not_checked_does_not_excuse_the_next_one() -> None:
    """Nothing but h, in cones of unlike sizes: an error that raises the residual raises the refinement tolerance of the next iteration."""
    h = np.zeros(12)
    h[2:9] = [
        3707.7304026986044, 26731.82146830528, -8042.454927466083, 19326.652847828365, 9037.204563968013,
        6519.924227195336, -12337.309641618725,
    ]  # fmt: skip
    problem = orbsoc.Problem(c=[0.0], G=np.zeros((12, 1)), h=h, cones=orbsoc.Cones(l=3, q=[6, 3]))
    solution = orbsoc.solve(problem, tol=1e-5)
    assert solution.status is orbsoc.Status.SOLVED
    assert solution.iterations <= 4  # 9, in two attempts, where the last error was trusted at any tolerance
    np.testing.assert_allclose(solution.s, h, atol=1e-4 * h.max())
