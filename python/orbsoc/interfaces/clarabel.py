"""Clarabel behind the call shape of `orbsoc.solve`: an independent answer to the same problem.

Clarabel solves min ½xᵀPx + qᵀx, Âx + s = b̂, s ∈ {0}ᵖ × K with Px + q + Âᵀẑ = 0, ẑ ∈ ℝᵖ × K. With Â = (A; G) and
b̂ = (b; h) its multipliers are those of orbsoc in the same order and sign, ẑ = (y, z). Its presolve is off, and rows with
h = +inf are left out here (slack +inf, multiplier 0 on return).
Source: Goulart & Chen, "Clarabel: an interior-point solver for conic programs with quadratic objectives", 2024.
"""

from __future__ import annotations

import time
from dataclasses import replace
from typing import Any

import clarabel as _clarabel
import numpy as np
from numpy.typing import NDArray

from orbsoc.conic import csc
from orbsoc.conic.csc import Array, Csc
from orbsoc.conic.problem import Cones, Problem
from orbsoc.conic.settings import Settings
from orbsoc.conic.solution import Solution, Status
from orbsoc.conic.verify import Residuals, check_certificate, objectives

clarabel: Any = _clarabel  # published without types

STATUS = {
    "Solved": Status.SOLVED,
    "AlmostSolved": Status.SOLVED_INACCURATE,
    "PrimalInfeasible": Status.PRIMAL_INFEASIBLE,
    "DualInfeasible": Status.DUAL_INFEASIBLE,
    "MaxIterations": Status.MAX_ITERATIONS,
    "MaxTime": Status.MAX_TIME,
    "CallbackTerminated": Status.INTERRUPTED,
}
"""Clarabel's statuses as those of orbsoc; all others, "almost" infeasible ones included, are NUMERICAL_LIMIT."""


def solve(problem: Problem, settings: Settings | None = None, **overrides: Any) -> Solution:
    """Solve with Clarabel, one thread; `overrides` are fields of `Settings`, as in `solve(problem, tol=1e-10)`.

    `tol` is Clarabel's tol_gap_abs, tol_gap_rel and tol_feas, `tol_inaccurate` its reduced ones. Clarabel judges
    scaled data, so its status is checked on the original data, and lowered with a message where the numbers do
    not support it. Raises TypeError for an unknown setting, ValueError for a setting out of range.
    """
    chosen = replace(settings or Settings(), **overrides)
    started = time.perf_counter()
    kept = np.isfinite(problem.h)
    P, stacked, side, cones = _standard_form(problem, kept)
    engine = clarabel.DefaultSolver(P, problem.c, stacked, side, cones, _settings(chosen))
    ready = time.perf_counter()
    result = engine.solve()
    finished = time.perf_counter()

    multipliers = np.asarray(result.z)
    z, s = np.zeros(problem.m), np.full(problem.m, np.inf)
    z[kept] = multipliers[problem.p :]
    s[kept] = np.asarray(result.s)[problem.p :]
    name = str(result.status)
    point = Solution(
        status=STATUS.get(name, Status.NUMERICAL_LIMIT),
        x=np.asarray(result.x),
        y=multipliers[: problem.p],
        z=z,
        s=s,
        objective=float("nan"),
        dual_objective=float("nan"),
        iterations=int(result.iterations),
        refinements=0,
        setup_s=ready - started,
        solve_s=finished - ready,
        certificate=_NO_RESIDUALS.certificate(),
        message="",
        nnz_kkt=int(engine.get_info().linsolver.nnzA),
        nnz_l=int(engine.get_info().linsolver.nnzL),
    )
    residuals = check_certificate(problem, point)
    status, message = _supported(point.status, name, residuals, chosen)
    ray = status in (Status.PRIMAL_INFEASIBLE, Status.DUAL_INFEASIBLE)
    primal, dual = (float("nan"), float("nan")) if ray else objectives(problem, point)
    return replace(
        point,
        status=status,
        message=message,
        objective=primal,
        dual_objective=dual,
        certificate=residuals.certificate(),
    )


_NO_RESIDUALS = Residuals(*[float("nan")] * 8)


def _settings(chosen: Settings) -> Any:
    out: Any = clarabel.DefaultSettings()
    out.tol_gap_abs = out.tol_gap_rel = out.tol_feas = chosen.tol
    out.reduced_tol_gap_abs = out.reduced_tol_gap_rel = out.reduced_tol_feas = chosen.tol_inaccurate
    out.max_iter = chosen.max_iterations
    out.time_limit = chosen.max_time_s
    out.verbose = chosen.verbose
    out.presolve_enable = False
    out.max_threads = 1
    return out


def _standard_form(problem: Problem, kept: NDArray[np.bool_]) -> tuple[Csc, Csc, Array, list[Any]]:
    """Clarabel's P (upper triangle), Â, b̂ and cones."""
    stacked = csc.stacked(problem.A, csc.selected_rows(problem.G, kept))
    side = np.concatenate([problem.b, problem.h[kept]])
    cones = _cones(problem.p, int(kept[: problem.cones.l].sum()), problem.cones)
    return csc.upper(problem.P), stacked, side, cones


def _cones(equalities: int, inequalities: int, cones: Cones) -> list[Any]:
    first = [clarabel.ZeroConeT(equalities)] if equalities else []
    second = [clarabel.NonnegativeConeT(inequalities)] if inequalities else []
    return first + second + [_second_order(size) for size in cones.q]


def _second_order(size: int) -> Any:
    return clarabel.SecondOrderConeT(size) if size > 1 else clarabel.NonnegativeConeT(1)


def _supported(claimed: Status, name: str, residuals: Residuals, chosen: Settings) -> tuple[Status, str]:
    """The strongest status that the residuals support, with what to say about it."""
    tolerance = chosen.tol if claimed is Status.SOLVED else chosen.tol_inaccurate
    if residuals.supports(claimed, tolerance):
        return claimed, f"Clarabel: {name}"
    if claimed in (Status.PRIMAL_INFEASIBLE, Status.DUAL_INFEASIBLE):
        own = f"{residuals.own_radius:.3g} times the problem's own scale"
        reason = f"its certificate excludes points below {residuals.radius:.3g} only, {own}"
        return Status.NUMERICAL_LIMIT, f"Clarabel: {name}, but {reason}"
    line, value = residuals.worst_line()
    reason = f"on the original data {line} is {value:.3g}, above {tolerance:.3g}"
    if residuals.supports(Status.SOLVED_INACCURATE, chosen.tol_inaccurate):
        return Status.SOLVED_INACCURATE, f"Clarabel: {name}, but {reason}"
    return Status.NUMERICAL_LIMIT, f"Clarabel: {name}, but {reason}"
