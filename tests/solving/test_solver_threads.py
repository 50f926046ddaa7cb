"""One solver serves one solve at a time, and says so."""

from __future__ import annotations

from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import orbsoc
from orbsoc.conic.problem import Cones, Problem

PROBLEM = Problem(c=[1.0, 1.0], G=-np.eye(2), h=[-1.0, -2.0], cones=Cones(l=2))


def test_solving_inside_ones_own_callback_is_an_error_that_says_what_to_do() -> None:
    solver = orbsoc.Solver(PROBLEM)
    seen: list[str] = []

    def callback(_progress: Mapping[str, float]) -> bool:
        with pytest.raises(RuntimeError, match="use one Solver for each thread") as caught:
            solver.solve()
        seen.append(str(caught.value))
        return False

    solution = solver.solve(callback=callback)
    assert solution.status is orbsoc.Status.SOLVED
    assert len(seen) == solution.iterations
    assert solver.solve().status is orbsoc.Status.SOLVED


def test_separate_solves_in_many_threads_have_the_same_bits() -> None:
    alone = orbsoc.solve(PROBLEM)
    with ThreadPoolExecutor(4) as pool:
        for solution in pool.map(lambda _: orbsoc.solve(PROBLEM), range(40)):
            np.testing.assert_array_equal(solution.x, alone.x, strict=True)
