"""Problems of one pattern with other numbers: what is interleaved in the streams that are validated."""

from __future__ import annotations

import numpy as np
from scipy import sparse

from orbsoc.conic.problem import Problem


def same_pattern(problem: Problem, copies: int) -> list[Problem]:
    """The problem, and others with its pattern and a solution each: scaled cost, scaled rows, a moved point.

    Each cone's rows, and each equality, are scaled by a positive number of their own. Every number that is not 0 differs
    from the problem's; all are drawn from a seed.
    """
    return [problem, *(_other(problem, number) for number in range(1, copies))]


def _other(problem: Problem, number: int) -> Problem:
    random = np.random.default_rng([number, problem.n, problem.p, problem.m])
    cost, moved = random.uniform(0.3, 3.0), 0.3 * random.standard_normal(problem.n)
    equalities = sparse.diags_array(random.uniform(0.5, 2.0, problem.p))
    blocks = [*(1,) * problem.cones.l, *problem.cones.q]
    rows = sparse.diags_array(np.repeat(random.uniform(0.5, 2.0, len(blocks)), blocks))
    return Problem(
        P=sparse.diags_array(np.full(problem.n, cost)) @ problem.P,
        c=problem.c * cost,
        A=equalities @ problem.A,
        b=equalities @ (problem.b + problem.A @ moved),
        G=rows @ problem.G,
        h=rows @ (problem.h + problem.G @ moved),
        cones=problem.cones,
    )
