"""PIQP, with sparse and with dense matrices: linear and quadratic programmes. Source: Schwan, Jiang, Kuhn & Jones 2023."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse as _scipy_sparse

from benchmarks.answer import Answer, Array, Solver, Variant, no_cones
from benchmarks.peers.installed import module
from orbsoc.conic.problem import Problem

sparse: Any = _scipy_sparse  # published without types

CLAIMS = {
    "PIQP_SOLVED": "SOLVED",
    "PIQP_PRIMAL_INFEASIBLE": "PRIMAL_INFEASIBLE",
    "PIQP_DUAL_INFEASIBLE": "DUAL_INFEASIBLE",
}
DENSE_ENTRIES = 60_000
"""The dense solver takes part where A and G, written out, have no more entries."""


def sparse_solver() -> Solver:
    return _solver("PIQP sparse", dense=False)


def dense_solver() -> Solver:
    return _solver("PIQP dense", dense=True)


def _solver(name: str, *, dense: bool) -> Solver:
    piqp, release = module("piqp")
    make = piqp.DenseSolver if dense else piqp.SparseSolver

    def applies(problem: Problem) -> bool:
        return no_cones(problem) and not (dense and _entries(problem) > DENSE_ENTRIES)

    def matrix(values: Any) -> Any:
        return np.asfortranarray(values.toarray()) if dense else sparse.csc_matrix(values)

    def solve(problem: Problem, tol: float) -> Answer:
        split = Split.of(problem)
        engine = make()
        settings = engine.settings
        settings.verbose, settings.compute_timings = False, True
        settings.eps_abs = settings.eps_rel = tol
        settings.eps_duality_gap_abs = settings.eps_duality_gap_rel = tol
        some = split.general.size > 0
        engine.setup(
            P=matrix(problem.P),
            c=problem.c,
            A=matrix(problem.A) if problem.p else None,
            b=problem.b if problem.p else None,
            G=matrix(sparse.csr_array(problem.G)[split.general]) if some else None,
            h_u=problem.h[split.general] if some else None,
            x_l=split.lower,
            x_u=split.upper,
        )
        status = engine.solve().name
        result = engine.result
        return Answer(
            np.array(result.x),
            np.array(result.y)[: problem.p],
            split.multipliers(problem.m, np.array(result.z_u), np.array(result.z_bl), np.array(result.z_bu)),
            status,
            int(result.info.iter),
            float(result.info.setup_time),
            float(result.info.solve_time),
            CLAIMS.get(status, ""),
        )

    return Solver(name, release, (Variant("", solve),), applies)


def _entries(problem: Problem) -> int:
    return problem.n * (problem.p + problem.m)


@dataclass(frozen=True, slots=True, eq=False)
class Split:
    """Rows of G as PIQP likes them: with one entry as bounds of a variable (the first of each side), others general.

    `general`: rows. `lower_rows`, `upper_rows`: rows that became bounds, of the variables `lower_at`, `upper_at`, their
    entries being `lower_by` < 0 and `upper_by` > 0. `lower`, `upper` (n,): the bounds.
    """

    general: NDArray[np.intp]
    lower_rows: NDArray[np.intp]
    lower_at: NDArray[np.intp]
    lower_by: Array
    upper_rows: NDArray[np.intp]
    upper_at: NDArray[np.intp]
    upper_by: Array
    lower: Array
    upper: Array

    @classmethod
    def of(cls, problem: Problem) -> Split:
        G = sparse.csr_array(problem.G)
        G.eliminate_zeros()
        constrains = np.isfinite(problem.h)
        single = np.flatnonzero((np.diff(G.indptr) == 1) & constrains)
        at: NDArray[np.intp] = G.indices[G.indptr[single]]
        by: Array = G.data[G.indptr[single]]
        sides: list[tuple[Any, Any, Any]] = []
        for side in (by < 0.0, by > 0.0):
            _, first = np.unique(at[side], return_index=True)
            sides.append((single[side][first], at[side][first], by[side][first]))
        (low, low_at, low_by), (up, up_at, up_by) = sides
        bounds = np.concatenate([low, up])
        general = np.setdiff1d(np.flatnonzero(constrains), bounds)
        lower, upper = np.full(problem.n, -np.inf), np.full(problem.n, np.inf)
        lower[low_at], upper[up_at] = problem.h[low] / low_by, problem.h[up] / up_by
        return cls(general, low, low_at, low_by, up, up_at, up_by, lower, upper)

    def multipliers(self, m: int, general: Array, below: Array, above: Array) -> Array:
        """z (m,) of all rows from PIQP's multipliers of general rows, lower and upper bounds (n,)."""
        z = np.zeros(m)
        z[self.general] = general[: self.general.size]
        z[self.lower_rows] = below[self.lower_at] / -self.lower_by
        z[self.upper_rows] = above[self.upper_at] / self.upper_by
        return z
