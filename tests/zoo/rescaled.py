"""The rescaled twin of a case: the same problem in other units, row by row and column by column."""

from __future__ import annotations

import zlib

import numpy as np

from orbsoc.conic.problem import Problem
from tests.zoo.case import Array, ZooCase

DECADES = 4.0
"""Factors are 10^u with u uniform in [−DECADES, DECADES]."""

CLARABEL_FAILS = {
    "lp_fixed_by_equality_scaled": "stationarity of 1e-7 costs its objective 2e-6: the residual is relative to ‖x‖",
    "lie_far_feasible_set_scaled": "stops after one iteration with Gx + s − h = 2e-5: relative to ‖x‖ of 1e5",
}
"""Twins on which Clarabel 0.11.1 at 1e-8 misses the known answer, and how; the known answer alone is the reference."""


def _factors(rng: np.random.Generator, size: int) -> Array:
    return 10.0 ** rng.uniform(-DECADES, DECADES, size)


def rescale(problem: Problem, rows: Array, cone_rows: Array, columns: Array) -> Problem:
    """The problem in x̂ = x / columns, its rows multiplied; the optimal value stays.

    `cone_rows` must be constant on each second-order cone, which is then mapped to itself.
    """

    def scaled(matrix: Array, left: Array) -> Array:
        return left[:, None] * matrix * columns[None, :]

    return Problem(
        P=scaled(problem.P.toarray(), columns) if problem.P.nnz else None,
        c=problem.c * columns,
        A=scaled(problem.A.toarray(), rows),
        b=problem.b * rows,
        G=scaled(problem.G.toarray(), cone_rows),
        h=problem.h * cone_rows,
        cones=problem.cones,
    )


def rescaled_twin(case: ZooCase) -> ZooCase:
    """`case` with rows and columns scaled by factors between 1e-4 and 1e4, chosen by its name; same known answer."""
    rng = np.random.default_rng(zlib.crc32(case.name.encode()))
    problem = case.problem
    cone_rows = _factors(rng, problem.m)
    for cone in problem.cones.second_order():
        cone_rows[cone] = cone_rows[cone.start]
    rows, columns = _factors(rng, problem.p), _factors(rng, problem.n)
    return ZooCase(
        name=f"{case.name}_scaled",
        problem=rescale(problem, rows, cone_rows, columns),
        expected=case.expected,
        objective=case.objective,
        scaled=True,
        clarabel_fails=CLARABEL_FAILS.get(f"{case.name}_scaled"),
    )
