"""QOCO. Source: Chari & Açıkmeşe 2025."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy import sparse as _scipy_sparse

from benchmarks.answer import Answer, Solve, Solver, Variant
from benchmarks.peers.installed import module
from benchmarks.peers.rows import rows, scattered
from orbsoc.conic.problem import Problem

sparse: Any = _scipy_sparse  # published without types


QOCO_REGULARISED = {"kkt_static_reg_P": 1e-6, "ir_tol": 1e-4}
"""For problems where QOCO 0.3's defaults end in QOCO_NUMERICAL_ERROR with NaN, as on all of mission 004's.

There, many variables are in no cost and no cone, so their pivot is the regularisation of P alone, 1e-13. It puts
a²/1e-13 on the equality rows, and what rounding leaves of that, about eps·a²/1e-13, swamps those rows' own
regularisation, 1e-8. By all signs what counts is reg_P · reg_A against eps: of the 52 subproblems, none verifies at
a product of 1e-18, 30 at 1e-16 (1e-8 each), 49 at 1e-15 and all at 1e-14 (1e-6 and 1e-8), where refinement makes up
for it. `kkt_dynamic_reg`, `kkt_static_reg_G` and more refinement do not help; `ir_tol` = 1e-4 instead of 1e-6 is 6 %
faster and verifies as well. `ruiz_iters` > 0 ends in NaN whenever a row of G is empty, as is that of the constant
head of ‖u‖ ≤ 1: two variables and one such cone, or one empty R₊ row, are enough to see it.
"""


LONGEST_CONE = 200
"""QOCO stores the blocks of cones densely: one of 531 takes it a second, one of 1677 most of a minute."""


def solver() -> Solver:
    qoco, release = module("qoco")

    def variant(label: str, **settings: Any) -> Variant:
        return Variant(label, _qoco_with(qoco, settings))

    return Solver(
        "QOCO",
        release,
        (
            variant(""),
            variant("ruiz_iters = 3", ruiz_iters=3),
            variant("kkt_static_reg_P = 1e-6, ir_tol = 1e-4", **QOCO_REGULARISED),
            variant(
                "kkt_static_reg_P = 1e-6, ir_tol = 1e-4, ruiz_iters = 3", **QOCO_REGULARISED, ruiz_iters=3
            ),
        ),
        timed=lambda problem: max(problem.cones.q, default=0) <= LONGEST_CONE,
    )


def _qoco_with(qoco: Any, chosen: dict[str, Any]) -> Solve:
    def solve(problem: Problem, tol: float) -> Answer:
        kept = np.isfinite(problem.h)
        engine = qoco.QOCO()
        m = int(kept.sum())
        engine.setup(
            problem.n,
            m,
            problem.p,
            sparse.csc_matrix(problem.P) if problem.P.nnz else None,
            problem.c,
            sparse.csc_matrix(problem.A) if problem.p else None,
            problem.b if problem.p else None,
            sparse.csc_matrix(rows(problem.G, kept)) if m else None,
            problem.h[kept] if m else None,
            int(kept[: problem.cones.l].sum()),
            len(problem.cones.q),
            np.asarray(problem.cones.q, dtype=np.int32),
            abstol=tol,
            reltol=tol,
            **chosen,
        )
        result = engine.solve()
        return Answer(
            np.array(result.x, dtype=np.float64),
            np.array(result.y, dtype=np.float64)[: problem.p],
            scattered(np.array(result.z, dtype=np.float64)[:m], kept),
            str(result.status),
            int(result.iters),
            float(result.setup_time_sec),
            float(result.solve_time_sec),
            "SOLVED" if str(result.status) == "QOCO_SOLVED" else "",
        )

    return solve
