"""A proof that no time will do never covers a time that does, and is given where there is none."""

from __future__ import annotations

import numpy as np
import pytest

import orbsoc
from orbsoc.conic.problem import Cones, Problem
from orbsoc.guidance.impulses import Family, Nowhere, nowhere_feasible


def family(least: float, turns: float = 1.0, moved: float = 0.0) -> Family:
    """x = cos t + moved and y = sin t x reach y ≥ `least`: sin t (cos t + moved), at most 1/2 + |moved|."""

    def build(t_s: float) -> Problem:
        return Problem(
            c=[0.0, 0.0, 0.0],
            A=[[1.0, 0.0, 0.0], [-np.sin(turns * t_s), 1.0, 0.0]],
            b=[np.cos(turns * t_s) + moved, 0.0],
            G=[[0.0, 0.0, -1.0], [0.0, -1.0, 0.0], [0.0, 0.0, 0.0]],
            h=[0.0, -least, 0.0],
            cones=Cones(1, [2]),
        )

    bend = turns**2
    return Family(build, (0.0, 2.0 / turns), np.full(3, 100.0), matrix_bend=bend, side_bend=bend)


@pytest.mark.parametrize("seed", range(20))
def test_a_proof_is_given_exactly_where_no_time_will_do(seed: int) -> None:
    random = np.random.default_rng(seed)
    turns, moved = float(random.uniform(0.01, 10.0)), float(random.uniform(-0.5, 0.5))
    t = np.linspace(0.0, 2.0, 200_001)
    most = float((np.sin(t) * (np.cos(t) + moved)).max())
    gap = float(10.0 ** random.uniform(-4.0, 0.0))
    assert isinstance(nowhere_feasible(family(most + gap, turns, moved), orbsoc.solve), Nowhere)
    assert nowhere_feasible(family(most - gap, turns, moved), orbsoc.solve) is None
    assert nowhere_feasible(family(most - 1e-9, turns, moved), orbsoc.solve) is None
