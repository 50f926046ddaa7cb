"""Batches: 64 problems of one pattern with the numbers of different cases.

Where a family's pattern does not depend on its seed the cases are seeds; elsewhere one problem's vectors are scaled,
entry by entry, by up to two per cent.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np

from benchmarks.estimation import robust_kalman
from benchmarks.guidance import powered_descent, quadrotor, rendezvous
from benchmarks.recorded import first_insertions
from benchmarks.regression import huber, svm
from benchmarks.six_dof import six_dof
from benchmarks.statistics import lasso, portfolio, small_lp
from orbsoc.conic.problem import Problem

SIZE = 64
SCALED_BY = 0.02


@dataclass(frozen=True, slots=True)
class Batch:
    """`generate` makes `SIZE` problems of one sparsity pattern, the same every time; `kind` is "scp", "qp" or "lp"."""

    name: str
    kind: str
    generate: Callable[[], list[Problem]]


def _seeds(make: Callable[[int, int], Problem], size: int) -> list[Problem]:
    return [make(size, seed) for seed in range(SIZE)]


def _scaled(make: Callable[[int, int], Problem], size: int) -> list[Problem]:
    return list(perturbed(make(size, 0), SCALED_BY, SIZE, seed=size))


def perturbed(problem: Problem, share: float, count: int, *, seed: int) -> Iterator[Problem]:
    """Copies with every entry of c, b and h scaled by a factor drawn from [1 − share, 1 + share]; infinite h stays."""
    random = np.random.default_rng(seed)
    for _ in range(count):
        c, b, h = (
            vector * random.uniform(1.0 - share, 1.0 + share, vector.size)
            for vector in (problem.c, problem.b, problem.h)
        )
        yield Problem(P=problem.P, c=c, A=problem.A, b=b, G=problem.G, h=h, cones=problem.cones)


BATCHES = {
    batch.name: batch
    for batch in (
        Batch("powered descent, 10 nodes", "scp", partial(_seeds, powered_descent, 10)),
        Batch("powered descent, 20 nodes", "scp", partial(_seeds, powered_descent, 20)),
        Batch("powered descent, 50 nodes", "scp", partial(_seeds, powered_descent, 50)),
        Batch("powered descent, 100 nodes", "scp", partial(_seeds, powered_descent, 100)),
        Batch("insertion A, 12 nodes", "scp", partial(first_insertions, 12, SIZE)),
        Batch("insertion A, 30 nodes", "scp", partial(first_insertions, 30, SIZE)),
        Batch("insertion A, 60 nodes", "scp", partial(first_insertions, 60, SIZE)),
        Batch("rendezvous, 20 nodes", "scp", partial(_seeds, rendezvous, 20)),
        Batch("rendezvous, 60 nodes", "scp", partial(_seeds, rendezvous, 60)),
        Batch("6-DoF landing, 10 nodes", "scp", partial(_seeds, six_dof, 10)),
        Batch("6-DoF landing, 20 nodes", "scp", partial(_seeds, six_dof, 20)),
        Batch("6-DoF landing, 30 nodes", "scp", partial(_seeds, six_dof, 30)),
        Batch("quadrotor, 20 nodes", "scp", partial(_seeds, quadrotor, 20)),
        Batch("quadrotor, 50 nodes", "scp", partial(_seeds, quadrotor, 50)),
        Batch("robust Kalman filter, 50 steps", "scp", partial(_seeds, robust_kalman, 50)),
        Batch("portfolio, 100 assets", "qp", partial(_scaled, portfolio, 100)),
        Batch("lasso, 50 features", "qp", partial(_scaled, lasso, 50)),
        Batch("huber, 20 features", "qp", partial(_scaled, huber, 20)),
        Batch("svm, 20 features", "qp", partial(_scaled, svm, 20)),
        Batch("LP, 16 × 100", "lp", partial(_seeds, partial(small_lp, rows=100), 16)),
        Batch("LP, 16 × 128", "lp", partial(_seeds, partial(small_lp, rows=128), 16)),
        Batch("LP, 16 × 150", "lp", partial(_seeds, partial(small_lp, rows=150), 16)),
    )
}
