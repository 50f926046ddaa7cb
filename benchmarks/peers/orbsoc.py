"""orbsoc itself, as a user calls it."""

from __future__ import annotations

import orbsoc
from benchmarks.answer import Answer, Solver, Variant
from orbsoc.conic.problem import Problem
from orbsoc.conic.solution import Status

CLAIMS = (Status.SOLVED, Status.PRIMAL_INFEASIBLE, Status.DUAL_INFEASIBLE)


def solve(problem: Problem, tol: float) -> Answer:
    s = orbsoc.solve(problem, tol=tol)
    claim = s.status.name if s.status in CLAIMS else ""
    return Answer(s.x, s.y, s.z, s.status.name, s.iterations, s.setup_s, s.solve_s, claim, s.message)


def solver() -> Solver:
    return Solver("orbsoc", orbsoc.__version__, (Variant("", solve),))
