"""orbsoc as a solver of CVXPY: `cvxpy_problem.solve(solver=orbsoc.CVXPY())`.

CVXPY states min ½xᵀPx + cᵀx + d, Âx + s = b̂, s ∈ {0}ᵖ × R₊ˡ × Q^q₁ × …: its first p rows are A here, the others G.
Multipliers have the same order and sign on both sides.

A second solve of a problem keeps the analysis of the first while the pattern is the same, and starts from its solution
unless `warm_start=False` is given. CVXPY asks for solver options as keywords of `solve`: they are the fields of
`orbsoc.Settings`.
"""

from __future__ import annotations

from collections.abc import Mapping, MutableMapping
from typing import Any, NamedTuple

import numpy as np

from orbsoc.conic import csc
from orbsoc.conic.csc import Csc
from orbsoc.conic.errors import ProblemError
from orbsoc.conic.problem import Cones, Problem
from orbsoc.conic.settings import Settings
from orbsoc.conic.solution import Solution, Status
from orbsoc.solving.solver import Solver, resolve

try:
    import cvxpy.settings as _settings
    from cvxpy.constraints.second_order import SOC
    from cvxpy.error import SolverError
    from cvxpy.reductions import solution as _solution
    from cvxpy.reductions.solvers import utilities as _utilities
    from cvxpy.reductions.solvers.conic_solvers.conic_solver import ConicSolver
except ModuleNotFoundError as error:
    if error.name != "cvxpy":
        raise
    raise ImportError(
        "orbsoc.CVXPY needs CVXPY, which is not installed: pip install 'orbsoc[cvxpy]'"
    ) from error

# Published with few types.
_s: Any = _settings
cvxpy_solution: Any = _solution
utilities: Any = _utilities

STATUS = {
    Status.SOLVED: _s.OPTIMAL,
    Status.SOLVED_INACCURATE: _s.OPTIMAL_INACCURATE,
    Status.PRIMAL_INFEASIBLE: _s.INFEASIBLE,
    Status.DUAL_INFEASIBLE: _s.UNBOUNDED,
    Status.MAX_ITERATIONS: _s.USER_LIMIT,
    Status.MAX_TIME: _s.USER_LIMIT,
    Status.NUMERICAL_LIMIT: _s.SOLVER_ERROR,
}
"""Statuses of orbsoc as CVXPY's. INTERRUPTED has none: Ctrl-C goes on as KeyboardInterrupt."""

CITATION = """
@software{orbsoc,
  title  = {orbsoc: second-order cones on a system-on-chip, for orbits},
  author = {{The orbsoc developers}},
}
"""

CONSTRAINTS: list[Any] = [*ConicSolver.SUPPORTED_CONSTRAINTS, SOC]
NAME = "ORBSOC"


class CVXPY(ConicSolver):
    """The solver to hand to CVXPY; `settings` hold unless `problem.solve(..., tol=1e-9)` overrides one.

    Linear and quadratic objectives; zero, nonnegative and second-order cones. After a solve
    `problem.solver_stats` has iterations and times, its `extra_stats` the whole `orbsoc.Solution`. Infeasible
    problems carry their certificate in the dual values. At a limit of iterations or time the status is
    "user_limit" and the best iterate is in the variables; where the arithmetic gives no more, CVXPY's SolverError
    says how far it came. Two of these with equal settings are equal, so CVXPY compiles a problem once for both.
    """

    MIP_CAPABLE = False
    BOUNDED_VARIABLES = False  # CVXPY 1.9.3 raises where another solver left a value outside its bounds
    SUPPORTED_CONSTRAINTS = CONSTRAINTS

    def __init__(self, settings: Settings | None = None) -> None:
        base: Any = super()
        base.__init__()
        self.settings = resolve(settings, {})

    def __eq__(self, other: object) -> bool:
        return isinstance(other, CVXPY) and self.settings == other.settings

    def __hash__(self) -> int:
        return hash((CVXPY, self.settings))

    def name(self) -> str:
        """The name that CVXPY prints."""
        return NAME

    def import_solver(self) -> None:
        """Nothing is left to import: this module has done it."""

    def supports_quad_obj(self) -> bool:
        """Quadratic objectives stay quadratic."""
        return True

    def cite(self, data: Any) -> str:
        """A BibTeX entry."""
        del data
        return CITATION

    def apply(self, problem: Any) -> tuple[dict[str, Any], dict[str, Any]]:
        """CVXPY's cone program as arrays, and what `invert` needs."""
        base: Any = super()
        data, inverse_data = base.apply(problem)
        dims = data[self.DIMS]
        data["n_eq"], data["n_ineq"] = dims.zero, dims.nonneg  # as CVXPY's QP interface counts its rows
        return data, inverse_data

    def solve_via_data(
        self,
        data: Mapping[str, Any],
        warm_start: bool,
        verbose: bool,
        solver_opts: Mapping[str, Any],
        solver_cache: MutableMapping[str, Any] | None = None,
    ) -> Solution:
        """Solve the arrays of `apply`, with the analysis of the last solve where the pattern is the same, and from its
        solution if `warm_start` is true.

        Raises TypeError for an unknown option, ProblemError for data that are no problem, KeyboardInterrupt.
        """
        options = {key: value for key, value in solver_opts.items() if key != "use_quad_obj"}
        settings = resolve(self.settings, options | ({"verbose": True} if verbose else {}))
        found, cones = _standard_form(data), _cones(data)
        cached = solver_cache.get(NAME) if solver_cache is not None else None
        kept = _updated(cached, found, cones, settings)
        solver = kept.solver if kept else Solver(Problem(**found, cones=cones), settings)
        solution: Solution = solver.solve(warm_start=kept.solution if kept and warm_start else None)
        if solver_cache is not None:
            solved = solution if solution.status is Status.SOLVED else None
            solver_cache[NAME] = _Solved(solver, found["P"], cones, solved)
        if solution.status is Status.INTERRUPTED:
            raise KeyboardInterrupt
        return solution

    def invert(self, solution: Solution, inverse_data: Any) -> Any:
        """CVXPY's record of a solution."""
        status = STATUS[solution.status]
        if status == _s.SOLVER_ERROR:
            raise SolverError(f"Solver '{NAME}' failed: {solution.message}")
        attributes = {
            _s.SOLVE_TIME: solution.solve_s,
            _s.SETUP_TIME: solution.setup_s,
            _s.NUM_ITERS: solution.iterations,
            _s.EXTRA_STATS: solution,
        }
        if status == _s.UNBOUNDED:
            return cvxpy_solution.failure_solution(status, attributes)
        duals = self._dual_values(solution, inverse_data)
        if status == _s.INFEASIBLE:
            return cvxpy_solution.failure_solution(status, attributes, duals)
        value = solution.objective + inverse_data[_s.OFFSET]
        return cvxpy_solution.Solution(
            status, value, {inverse_data[self.VAR_ID]: solution.x}, duals, attributes
        )

    def _dual_values(self, solution: Solution, inverse_data: Any) -> dict[Any, Any]:
        """Multipliers by constraint."""
        values: dict[Any, Any]
        values = utilities.get_dual_values(
            solution.y, utilities.extract_dual_value, inverse_data[self.EQ_CONSTR]
        )
        values |= utilities.get_dual_values(
            solution.z, utilities.extract_dual_value, inverse_data[self.NEQ_CONSTR]
        )
        return values


class _Solved(NamedTuple):
    """What a problem keeps for its next solve."""

    solver: Solver
    cost: Csc | None
    cones: Cones
    solution: Solution | None


def _cones(data: Mapping[str, Any]) -> Cones:
    dims = data[ConicSolver.DIMS]
    return Cones(l=dims.nonneg, q=dims.soc)


def _standard_form(data: Mapping[str, Any]) -> dict[str, Any]:
    """P, c, A, b, G, h of CVXPY's arrays."""
    equalities, rows, sides = data[ConicSolver.DIMS].zero, data[_s.A], data[_s.B]
    A, G = csc.split_rows(rows, equalities)
    return {
        "P": data.get(_s.P), "c": data[_s.C], "A": A, "b": sides[:equalities], "G": G, "h": sides[equalities:],
    }  # fmt: skip


def _updated(cached: Any, found: Mapping[str, Any], cones: Cones, settings: Settings) -> _Solved | None:
    """The last solve's analysis with the new data (it gives the bits of a new one), or None where it does not fit."""
    if not isinstance(cached, _Solved) or cached.cones != cones or cached.solver.settings != settings:
        return None
    try:
        cached.solver.update(**{k: v for k, v in found.items() if k != "P" or not _equal(v, cached.cost)})
    except ProblemError:
        return None
    return cached


def _equal(one: Csc | None, other: Csc | None) -> bool:
    """Whether two costs have the same entries, stored in the same places."""
    if one is None or other is None:
        return one is other
    parts = ("indptr", "indices", "data")
    return all(np.array_equal(getattr(one, part), getattr(other, part)) for part in parts)
