"""SCS, a first-order method: here for scale, at a tolerance it was not made for. Source: O'Donoghue 2021."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy import sparse as _scipy_sparse

from benchmarks.answer import Answer, Solver, Variant
from benchmarks.peers.installed import module
from benchmarks.peers.rows import rows, scattered
from orbsoc.conic.problem import Problem

sparse: Any = _scipy_sparse  # published without types

CLAIMS = {1: "SOLVED", -2: "PRIMAL_INFEASIBLE", -1: "DUAL_INFEASIBLE"}
LIMIT_S = 2.0
"""Time limit of a solve; also limited to 200 000 iterations."""


def solver() -> Solver:
    scs, release = module("scs")

    def solve(problem: Problem, tol: float) -> Answer:
        kept = np.isfinite(problem.h)
        cones = problem.cones
        engine = scs.SCS(
            {
                "P": sparse.triu(problem.P, format="csc") if problem.P.nnz else None,
                "c": problem.c,
                "A": sparse.vstack([problem.A, rows(problem.G, kept)], format="csc"),
                "b": np.concatenate([problem.b, problem.h[kept]]),
            },
            {"z": problem.p, "l": int(kept[: cones.l].sum()), "q": list(cones.q)},
            verbose=False,
            eps_abs=tol,
            eps_rel=tol,
            eps_infeas=tol,
            max_iters=200_000,
            time_limit_secs=LIMIT_S,
            linear_solver="qdldl",
        )
        result = engine.solve(warm_start=False)
        info = result["info"]
        y = np.asarray(result["y"])
        return Answer(
            np.asarray(result["x"]),
            y[: problem.p],
            scattered(y[problem.p :], kept),
            str(info["status"]),
            int(info["iter"]),
            1e-3 * float(info["setup_time"]),
            1e-3 * float(info["solve_time"]),
            CLAIMS.get(int(info["status_val"]), ""),
        )

    return Solver("SCS", release, (Variant("", solve),), sampled=True)
