"""Clarabel. Source: Goulart & Chen 2024."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
from scipy import sparse as _scipy_sparse

from benchmarks.answer import Answer, Solver, Variant
from benchmarks.peers.installed import module
from benchmarks.peers.rows import rows, scattered
from orbsoc.conic.problem import Problem

sparse: Any = _scipy_sparse  # published without types


CLAIMS = {"Solved": "SOLVED", "PrimalInfeasible": "PRIMAL_INFEASIBLE", "DualInfeasible": "DUAL_INFEASIBLE"}


def solver() -> Solver:
    clarabel, release = module("clarabel")

    def solve(problem: Problem, tol: float) -> Answer:
        """Clarabel's clock gives set-up and solve as one sum: the solve is timed from outside, around its one call
        (a few µs of binding count against it), and the set-up is what then remains of the sum."""
        kept = np.isfinite(problem.h)
        settings = clarabel.DefaultSettings()
        settings.verbose, settings.presolve_enable, settings.max_threads = False, False, 1
        settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = tol
        cones = problem.cones
        inequalities = int(kept[: cones.l].sum())
        blocks = [clarabel.ZeroConeT(problem.p)] if problem.p else []
        blocks += [clarabel.NonnegativeConeT(inequalities)] if inequalities else []
        blocks += [clarabel.SecondOrderConeT(q) if q > 1 else clarabel.NonnegativeConeT(1) for q in cones.q]
        P = sparse.triu(problem.P, format="csc")
        A = sparse.vstack([problem.A, rows(problem.G, kept)], format="csc")
        engine = clarabel.DefaultSolver(P, problem.c, A, np.r_[problem.b, problem.h[kept]], blocks, settings)
        started = time.perf_counter()
        result = engine.solve()
        solve_s = time.perf_counter() - started
        multipliers = np.asarray(result.z)
        return Answer(
            np.asarray(result.x),
            multipliers[: problem.p],
            scattered(multipliers[problem.p :], kept),
            str(result.status),
            int(result.iterations),
            max(float(result.solve_time) - solve_s, 0.0),
            solve_s,
            CLAIMS.get(str(result.status), ""),
        )

    return Solver("Clarabel", release, (Variant("", solve),))
