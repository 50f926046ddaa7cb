"""HiGHS: linear programmes by simplex, else by interior points with crossover; quadratic ones by active sets.

Source: Huangfu & Hall 2018.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy import sparse as _scipy_sparse

from benchmarks.answer import Answer, Solve, Solver, Variant, no_cones
from benchmarks.peers.installed import module
from orbsoc.conic.problem import Problem

sparse: Any = _scipy_sparse  # published without types

CLAIMS = {"kOptimal": "SOLVED", "kInfeasible": "PRIMAL_INFEASIBLE", "kUnbounded": "DUAL_INFEASIBLE"}
LIMIT_S = 20.0


def solver() -> Solver:
    highspy, release = module("highspy")
    return Solver(
        "HiGHS",
        release,
        (Variant("", _with(highspy, "choose")), Variant("solver = ipm", _with(highspy, "ipm"))),
        no_cones,
    )


def _with(highspy: Any, algorithm: str) -> Solve:
    def solve(problem: Problem, tol: float) -> Answer:
        engine = highspy.Highs()
        for option, value in (
            ("output_flag", False),
            ("presolve", "off"),
            ("threads", 1),
            ("parallel", "off"),
            ("solver", algorithm if not problem.P.nnz else "choose"),
            ("primal_feasibility_tolerance", tol),
            ("dual_feasibility_tolerance", tol),
            ("ipm_optimality_tolerance", tol),
            ("time_limit", LIMIT_S),
        ):
            engine.setOptionValue(option, value)
        engine.passModel(_model(highspy, problem))
        before = engine.getRunTime()
        engine.run()
        solve_s = engine.getRunTime() - before
        info, found = engine.getInfo(), engine.getSolution()
        status = engine.getModelStatus().name
        duals = -np.asarray(found.row_dual) if found.dual_valid else np.full(problem.p + problem.m, np.nan)
        if status == "kInfeasible":
            _, there, ray = engine.getDualRay()
            duals = -np.asarray(ray) if there else duals
        x = np.asarray(found.col_value) if found.value_valid else np.full(problem.n, np.nan)
        counts = (info.simplex_iteration_count, info.ipm_iteration_count, info.qp_iteration_count)
        return Answer(
            x,
            duals[: problem.p],
            duals[problem.p :],
            status,
            sum(max(0, int(count)) for count in counts),
            0.0,
            solve_s,
            CLAIMS.get(status, ""),
        )

    return solve


def _model(highspy: Any, problem: Problem) -> Any:
    """All rows as rows, no bounds: the multipliers of bounds would be lost in the reduced costs."""
    lp = highspy.HighsLp()
    lp.num_col_, lp.num_row_ = problem.n, problem.p + problem.m
    lp.col_cost_ = problem.c
    lp.col_lower_, lp.col_upper_ = np.full(problem.n, -np.inf), np.full(problem.n, np.inf)
    lp.row_lower_ = np.concatenate([problem.b, np.full(problem.m, -np.inf)])
    lp.row_upper_ = np.concatenate([problem.b, problem.h])
    matrix = sparse.vstack([problem.A, problem.G], format="csc")
    lp.a_matrix_.format_ = highspy.MatrixFormat.kColwise
    lp.a_matrix_.start_, lp.a_matrix_.index_, lp.a_matrix_.value_ = matrix.indptr, matrix.indices, matrix.data
    model = highspy.HighsModel()
    model.lp_ = lp
    if problem.P.nnz:
        lower = sparse.tril(problem.P, format="csc")
        hessian = highspy.HighsHessian()
        hessian.dim_ = problem.n
        hessian.format_ = highspy.HessianFormat.kTriangular
        hessian.start_, hessian.index_, hessian.value_ = lower.indptr, lower.indices, lower.data
        model.hessian_ = hessian
    return model
