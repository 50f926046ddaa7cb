"""ECOS, on problems with a linear cost. Source: Domahidi, Chu & Boyd 2013."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy import sparse as _scipy_sparse

from benchmarks.answer import Answer, Solver, Variant
from benchmarks.peers.installed import module
from benchmarks.peers.rows import rows, scattered
from orbsoc.conic.problem import Problem

sparse: Any = _scipy_sparse  # published without types

CLAIMS = {0: "SOLVED", 1: "PRIMAL_INFEASIBLE", 2: "DUAL_INFEASIBLE"}
"""By exit flag; 10 and more are "close to"."""


def solver() -> Solver:
    ecos, release = module("ecos")

    def solve(problem: Problem, tol: float) -> Answer:
        kept = np.isfinite(problem.h)
        some = bool(kept.any())
        result = ecos.solve(
            problem.c,
            sparse.csc_matrix(rows(problem.G, kept)) if some else None,
            problem.h[kept] if some else None,
            {"l": int(kept[: problem.cones.l].sum()), "q": list(problem.cones.q), "e": 0},
            sparse.csc_matrix(problem.A) if problem.p else None,
            problem.b if problem.p else None,
            verbose=False,
            abstol=tol,
            reltol=tol,
            feastol=tol,
        )
        info = result["info"]
        return Answer(
            np.asarray(result["x"]),
            np.asarray(result["y"]) if problem.p else np.zeros(0),
            scattered(np.asarray(result["z"]), kept) if some else np.zeros(problem.m),
            str(info["infostring"]),
            int(info["iter"]),
            float(info["timing"]["tsetup"]),
            float(info["timing"]["tsolve"]),
            CLAIMS.get(int(info["exitFlag"]), ""),
        )

    return Solver("ECOS", release, (Variant("", solve),), applies=_linear)


def _linear(problem: Problem) -> bool:
    """A quadratic cost it could have as a cone only: an objective exact to 1e-8 then fixes Rx to its root at best."""
    return problem.P.nnz == 0
