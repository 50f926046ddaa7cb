"""orbsoc as a solver of CVXPY: `cvxpy_problem.solve(solver=orbsoc.CVXPY())`.

CVXPY states min ½xᵀPx + cᵀx + d, Âx + s = b̂, s ∈ {0}ᵖ × R₊ˡ × Q^q₁ × …, with bounds on x apart. Its first p rows are
A here, the others G; a finite bound becomes a row of R₊ after CVXPY's own, two equal bounds a row of A. Multipliers
have the same order and sign on both sides; those of bounds have no place in CVXPY.

CVXPY asks for solver options as keywords of `solve`: they are the fields of `orbsoc.Settings`.
"""

from __future__ import annotations

from collections.abc import Mapping, MutableMapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from orbsoc.conic import csc
from orbsoc.conic.csc import Array, Csc, Matrix
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

    Linear and quadratic objectives; zero, nonnegative and second-order cones; bounds of variables. After a solve
    `problem.solver_stats` has iterations and times, its `extra_stats` the whole `orbsoc.Solution`. Infeasible
    problems carry their certificate in the dual values. At a limit of iterations or time the status is
    "user_limit" and the best iterate is in the variables; where the arithmetic gives no more, CVXPY's SolverError
    says how far it came. Two of these with equal settings are equal, so CVXPY compiles a problem once for both.
    """

    MIP_CAPABLE = False
    BOUNDED_VARIABLES = True
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
        """Solve the arrays of `apply`, with the analysis of the last solve where the pattern is the same.

        Raises TypeError for an unknown option, ProblemError for data that are no problem, KeyboardInterrupt.
        """
        options = {key: value for key, value in solver_opts.items() if key != "use_quad_obj"}
        settings = resolve(self.settings, options | ({"verbose": True} if verbose else {}))
        problem = _standard_form(data)
        cached = solver_cache.get(NAME) if warm_start and solver_cache is not None else None
        solver = _updated(cached, problem, settings) or Solver(problem, settings)
        if solver_cache is not None:
            solver_cache[NAME] = solver
        solution = solver.solve()
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
        """Multipliers by constraint, those of bounds left out."""
        dims = inverse_data[self.DIMS]
        bounds = solution.z.size - dims.nonneg - sum(dims.soc)
        y = solution.y[: dims.zero]
        z = np.delete(solution.z, slice(dims.nonneg, dims.nonneg + bounds))
        values: dict[Any, Any]
        values = utilities.get_dual_values(y, utilities.extract_dual_value, inverse_data[self.EQ_CONSTR])
        values |= utilities.get_dual_values(z, utilities.extract_dual_value, inverse_data[self.NEQ_CONSTR])
        return values


@dataclass(frozen=True, slots=True)
class _Rows:
    """A block of rows and its right-hand side."""

    matrix: Matrix
    side: Array


def _standard_form(data: Mapping[str, Any]) -> Problem:
    dims, rows, side = data[ConicSolver.DIMS], data[_s.A], data[_s.B]
    p, l = dims.zero, dims.zero + dims.nonneg
    fixed, bounded = _bounds(data, data[_s.C].size)
    equalities = [_Rows(rows[:p], side[:p]), fixed]
    inequalities = [_Rows(rows[p:l], side[p:l]), bounded, _Rows(rows[l:], side[l:])]
    A, b = _stacked(equalities)
    G, h = _stacked(inequalities)
    cones = Cones(l=dims.nonneg + bounded.side.size, q=dims.soc)
    return Problem(P=data.get(_s.P), c=data[_s.C], A=A, b=b, G=G, h=h, cones=cones)


def _bounds(data: Mapping[str, Any], n: int) -> tuple[_Rows, _Rows]:
    """Bounds on x as equalities (where the two are one) and inequalities."""
    lower = _bound(data.get(_s.LOWER_BOUNDS), -np.inf, n)
    upper = _bound(data.get(_s.UPPER_BOUNDS), np.inf, n)
    fixed = lower == upper
    below, above = ~fixed & (lower != -np.inf), ~fixed & (upper != np.inf)
    inequalities = csc.stacked(_unit_rows(below, -1.0), _unit_rows(above, 1.0))
    sides = np.concatenate([-lower[below], upper[above]])
    return _Rows(_unit_rows(fixed, 1.0), lower[fixed]), _Rows(inequalities, sides)


def _bound(given: Any, absent: float, n: int) -> Array:
    return np.full(n, absent) if given is None else np.broadcast_to(np.asarray(given, dtype=float), n)


def _unit_rows(which: Any, value: float) -> Csc:
    """The rows `value`·eᵢᵀ of the variables i where `which` is true."""
    columns = np.flatnonzero(which)
    shape = (columns.size, which.size)
    return csc.from_entries(np.full(columns.size, value), np.arange(columns.size), columns, shape)


def _stacked(blocks: list[_Rows]) -> tuple[Matrix, Array]:
    matrix = blocks[0].matrix
    for block in blocks[1:]:
        if block.side.size:
            matrix = csc.stacked(matrix, block.matrix)
    return matrix, np.concatenate([block.side for block in blocks])


def _updated(cached: Any, problem: Problem, settings: Settings) -> Solver | None:
    """The last solve's analysis with new data (the same bits as a new one), or None if it is of another pattern."""
    if not isinstance(cached, Solver) or cached.settings != settings or cached.problem.cones != problem.cones:
        return None
    try:
        cached.update(**{name: getattr(problem, name) for name in "PcAbGh"})
    except ProblemError:
        return None
    return cached
