"""Grading one answer to one problem of a set: is it verified, does its claim hold, does it contradict what is known."""

from __future__ import annotations

import math
from dataclasses import dataclass

from benchmarks.answer import Answer
from orbsoc.conic.problem import Problem
from orbsoc.conic.solution import Status
from orbsoc.conic.verify import RADIUS_FACTOR, dual_infeasibility_radius, primal_infeasibility_radius, verify

LOOSE, TIGHT = 1e-6, 1e-8
"""A solution is verified when max(pres, dres, gap) is no larger."""
FALSE_ABOVE = 1e-5
"""A claim to have solved is false when max(pres, dres, gap) is larger."""
DEFAULTS = "default"
"""Settings of a row whose solver has only its tolerance set."""
MAY_BE_SOLVED = frozenset({"lpi_cplex2"})
"""Infeasible by so little that a point within the tolerance exists: SOLVED is accepted where the residuals support it."""


@dataclass(frozen=True, slots=True)
class Graded:
    """The row of one solver on one problem. `outcome` is empty when the solver came back, else what became of it."""

    set: str
    problem: str
    expected: str
    solver: str
    release: str
    settings: str
    tol: float
    outcome: str
    status: str
    claim: str
    message: str
    iterations: int
    setup_s: float
    solve_s: float
    pres: float
    dres: float
    gap: float
    radius: float
    """Certified radius over the scale of the data, for a claim of infeasibility; NaN otherwise."""

    @property
    def label(self) -> str:
        """The solver, and whether its defaults were given up."""
        return self.solver if self.settings == DEFAULTS else f"{self.solver}, other settings"

    @property
    def residual(self) -> float:
        return max(self.pres, self.dres, self.gap)

    def verified(self, tol: float) -> bool:
        """Solved to `tol`, whatever the solver says of itself; for a problem known to be infeasible, proved so."""
        solved = not self.outcome and self.residual <= tol
        if self.expected == Status.PRIMAL_INFEASIBLE.name:
            proved = self.claim == self.expected and self.certified
            return proved or (solved and self.problem in MAY_BE_SOLVED)
        return solved

    @property
    def certified(self) -> bool:
        """Whether the certificate of a claim of infeasibility excludes a ball as large as a claim needs."""
        return self.radius >= RADIUS_FACTOR

    def falsehood(self) -> str:
        """Why the claim is false; empty when it is not."""
        if self.claim == Status.SOLVED.name and not self.residual <= FALSE_ABOVE:
            return f"says solved, residual {self.residual:.1e}"
        allowed = (self.expected, "SOLVED") if self.problem in MAY_BE_SOLVED else (self.expected,)
        if self.claim and self.expected and self.claim not in allowed:
            return f"says {self.claim}, is {self.expected}"
        if self.solver == "orbsoc" and self.claim in (
            Status.PRIMAL_INFEASIBLE.name,
            Status.DUAL_INFEASIBLE.name,
        ):
            return "" if self.certified else f"claims infeasibility at radius {self.radius:.1f} × scale"
        return ""


def graded(
    problem: Problem,
    answer: Answer,
    *,
    where: tuple[str, str, str],
    who: tuple[str, str, str],
    tol: float,
) -> Graded:
    """The row of an answer; `where` is set, problem and expected answer, `who` solver, version and settings."""
    found = verify(problem, answer)
    return Graded(
        *where,
        *who,
        tol,
        outcome="",
        status=answer.status,
        claim=answer.claim,
        message=answer.message,
        iterations=answer.iterations,
        setup_s=answer.setup_s,
        solve_s=answer.solve_s,
        pres=found.pres,
        dres=found.dres,
        gap=found.gap,
        radius=_radius(problem, answer),
    )


def lost(*, where: tuple[str, str, str], who: tuple[str, str, str], tol: float, outcome: str) -> Graded:
    """The row of a solver that did not come back."""
    nothing = (math.nan, math.nan, math.inf, math.inf, math.inf, math.nan)
    return Graded(*where, *who, tol, outcome, "", "", "", 0, *nothing)


def _radius(problem: Problem, answer: Answer) -> float:
    """Over max(1, norms of the side concerned), as the table of claims has it."""
    h = problem.h[abs(problem.h) < math.inf]
    sides = [float(abs(side).max()) for side in (problem.b, h) if side.size]
    if answer.claim == Status.PRIMAL_INFEASIBLE.name:
        return primal_infeasibility_radius(problem, answer.y, answer.z) / max(1.0, *sides, 1.0)
    if answer.claim == Status.DUAL_INFEASIBLE.name:
        return dual_infeasibility_radius(problem, answer.x) / max(1.0, float(abs(problem.c).max()))
    return math.nan
