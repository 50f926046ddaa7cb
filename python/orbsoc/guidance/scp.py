"""Sequential convex programming: solve a convex subproblem about a reference, move the reference, repeat.

The loop knows nothing of orbits. A mission hands it `linearise`, which turns a reference into a conic problem
and a way to read the next reference off its solution; the loop owns tolerances, stop rules and the record of
what happened, and ends with a typed reason.
"""

from __future__ import annotations

import enum
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from math import isfinite, nan
from typing import Any, Generic, Protocol, TypeVar

from orbsoc.conic.problem import Problem
from orbsoc.conic.settings import Settings
from orbsoc.conic.solution import Solution, Status

I = TypeVar("I")


class Solve(Protocol):
    """Any conic solver with the call shape of `orbsoc.solve`."""

    def __call__(self, problem: Problem, settings: Settings | None = None, /) -> Solution: ...


def solver(solve: Solve | None = None) -> Solve:
    """`solve`, by default `orbsoc.solve`."""
    from orbsoc.solving.solver import solve as solve_in_rust

    return solve or solve_in_rust


def uninterrupted(solve: Solve | None = None) -> Solve:
    """A solver, `orbsoc.solve` by default, that raises KeyboardInterrupt where a solve was interrupted."""
    used = solver(solve)

    def solved(problem: Problem, settings: Settings | None = None, /) -> Solution:
        solution = used(problem, settings)
        if solution.status is Status.INTERRUPTED:
            raise KeyboardInterrupt
        return solution

    return solved


class ExitReason(enum.Enum):
    """Why the loop ended; the value is the phrase for a person."""

    CONVERGED = "converged"
    INFEASIBLE = "converged, but the constraints cannot be met together"
    SUBPROBLEM_INFEASIBLE = "a subproblem has no feasible point"
    SUBPROBLEM_FAILED = "a subproblem could not be solved"
    MAX_ITERATIONS = "iteration limit reached"
    INTERRUPTED = "interrupted"


@dataclass(frozen=True, slots=True, kw_only=True)
class Rules:
    """When to stop, and how exactly to solve subproblems on the way. Steps and slack in the mission's units.

    Converged: change < `step_tol` and slack < `slack_tol` in a subproblem asked for at `tight_tol` and solved, or
    short of it with verified residuals ≤ `final_residual`. Infeasible: the same with slack ≥ `infeasible_slack`.
    Subproblems are solved at `loose_tol` until a change falls below `tighten_below`; one that its solver left
    short of its tolerance still shows the way while its verified residuals are ≤ `usable_residual`.
    """

    step_tol: float = 1e-7
    slack_tol: float = 1e-7
    infeasible_slack: float = 1e-6
    max_iterations: int = 30
    loose_tol: float = 1e-8
    tight_tol: float = 1e-10
    tighten_below: float = 1e-4
    usable_residual: float = 1e-5
    final_residual: float = 1e-8

    def __post_init__(self) -> None:
        for name in self.__dataclass_fields__:
            value = getattr(self, name)
            if not value > 0:
                raise ValueError(f"rules: {name} = {value!r} must be positive")


@dataclass(frozen=True, slots=True, eq=False)
class Step(Generic[I]):
    """What the solution of one subproblem says: the next reference and how far it moved.

    `change` is the largest change of the iterate, `slack` the total violation the subproblem had to allow (0
    when it allows none), `figures` the mission's own numbers for the iteration table, units in their names.
    """

    iterate: I
    change: float
    slack: float
    figures: Mapping[str, float]


@dataclass(frozen=True, slots=True, eq=False)
class Subproblem(Generic[I]):
    """A conic problem about a reference, and how to read its solution."""

    problem: Problem
    read: Callable[[Solution], Step[I]]


@dataclass(frozen=True, slots=True, eq=False)
class Iteration:
    """One row of the convergence table. `change` and `slack` are NaN when the subproblem gave no point.

    A mission that is one conic problem has one: `Iteration(1, tolerance, problem, solution)`.
    """

    number: int
    tolerance: float
    problem: Problem = field(repr=False)
    solution: Solution = field(repr=False)
    change: float = 0.0
    slack: float = 0.0
    figures: Mapping[str, float] = field(default_factory=dict)

    @property
    def settings(self) -> Settings:
        """The settings that it was solved with."""
        return Settings(tol=self.tolerance)

    def to_dict(self) -> dict[str, Any]:
        """A row of `subproblems` in plan.json; times are wall-clock, measured on this machine."""
        problem, solution = self.problem, self.solution
        measured = {"change": self.change, "slack": self.slack, **self.figures}
        return {
            "iterations": solution.iterations,
            "status": solution.status.name,
            "n": problem.n,
            "p": problem.p,
            "m": problem.m,
            "nnz_kkt": solution.nnz_kkt,
            "nnz_l": solution.nnz_l,
            "setup_us": 1e6 * solution.setup_s,
            "solve_us": 1e6 * solution.solve_s,
            "refinements": solution.refinements,
            "tolerance": self.tolerance,
            **{name: value if isfinite(value) else None for name, value in measured.items()},
        }


@dataclass(frozen=True, slots=True, eq=False)
class Outcome(Generic[I]):
    """How the loop ended: the reason, the last reference it accepted, every iteration, and a sentence."""

    reason: ExitReason
    iterate: I
    iterations: tuple[Iteration, ...]
    message: str


def sequential_convex(
    reference: I,
    linearise: Callable[[I], Subproblem[I]],
    *,
    solve: Solve,
    rules: Rules | None = None,
    callback: Callable[[Iteration], None] | None = None,
) -> Outcome[I]:
    """Iterate from `reference` until a rule stops the loop; `callback` sees every iteration as it ends.

    Ctrl-C, in the loop, in `callback` or inside the solver, ends it with INTERRUPTED and what was reached so far.
    Errors of `linearise` (bad data) propagate; a solver that does not converge is a reason, never an exception.
    """
    rules = rules or Rules()
    iterations: list[Iteration] = []
    tolerance = rules.loose_tol

    def ended(reason: ExitReason, message: str) -> Outcome[I]:
        return Outcome(reason, reference, tuple(iterations), message)

    number = 0
    try:
        for number in range(1, rules.max_iterations + 1):
            subproblem = linearise(reference)
            solution = solve(subproblem.problem, Settings(tol=tolerance))
            step = subproblem.read(solution) if _usable(solution, rules) else None
            figures = (nan, nan, {}) if step is None else (step.change, step.slack, step.figures)
            iterations.append(Iteration(number, tolerance, subproblem.problem, solution, *figures))
            if callback is not None:
                callback(iterations[-1])
            if step is None:
                return ended(*_failure(number, solution))
            reference = step.iterate
            settled = step.change < rules.step_tol and tolerance <= rules.tight_tol
            if settled and within_residual(solution, rules.final_residual):
                if step.slack < rules.slack_tol:
                    return ended(
                        ExitReason.CONVERGED,
                        f"converged in {number} iterations: last change {step.change:.1e}, slack {step.slack:.1e}",
                    )
                if step.slack >= rules.infeasible_slack:
                    return ended(
                        ExitReason.INFEASIBLE,
                        f"the steps converged in {number} iterations (last change {step.change:.1e}) at a point"
                        f" that violates the constraints by {step.slack:.1e} in total",
                    )
            if step.change < rules.tighten_below:
                tolerance = rules.tight_tol
    except KeyboardInterrupt:
        return ended(ExitReason.INTERRUPTED, f"interrupted in iteration {number}")
    last = iterations[-1]
    return ended(
        ExitReason.MAX_ITERATIONS,
        f"no convergence in {rules.max_iterations} iterations: last change {last.change:.1e}"
        f" (needs < {rules.step_tol:.0e}), slack {last.slack:.1e} (needs < {rules.slack_tol:.0e})",
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class TrustRules:
    """When `trust_region` stops, and how it moves its radius, in the unit of the mission's steps.

    Converged: a subproblem promises less than `least_gain` of the cost. A step counts if it brings `accepted` of what was
    promised; the radius shrinks to `shrink` of the step below `poor`, and grows by `grow` above `good`.
    """

    radius: float
    least_gain: float = 1e-8
    least_radius: float = 1e-6
    max_iterations: int = 40
    accepted: float = 0.05
    poor: float = 0.25
    good: float = 0.75
    shrink: float = 0.4
    grow: float = 2.5


@dataclass(frozen=True, slots=True, eq=False)
class Proposal(Generic[I]):
    """What the subproblems about a reference say: the next one, its cost if the linearisation held, how far it is, and
    what was solved. Without an iterate the last solve has failed."""

    iterate: I | None
    cost: float
    distance: float
    subproblems: tuple[Iteration, ...]


def trust_region(
    start: I,
    propose: Callable[[I, float], Proposal[I]],
    restore: Callable[[I], I | None],
    cost: Callable[[I], float],
    *,
    rules: TrustRules,
    callback: Callable[[Iteration], None] | None = None,
) -> Outcome[I]:
    """Descend from a feasible reference: propose within a radius, restore feasibility, and accept by what was gained.

    `propose` solves one conic problem or several about a reference, within a radius; `restore` moves an iterate to the
    nearest feasible one, or gives up with None. `callback` sees every solved problem. Source: Conn, Gould & Toint, Trust-
    Region Methods, algorithm 6.1.1, on a cost that needs no merit function since every reference is feasible.
    """
    reference, value, radius = start, cost(start), rules.radius
    solved: list[Iteration] = []

    def ended(reason: ExitReason, message: str) -> Outcome[I]:
        return Outcome(reason, reference, tuple(solved), message)

    try:
        for number in range(1, rules.max_iterations + 1):
            proposal = propose(reference, radius)
            for each in proposal.subproblems:
                solved.append(replace(each, number=len(solved) + 1, change=proposal.distance))
                if callback is not None:
                    callback(solved[-1])
            if proposal.iterate is None:
                return ended(*_failure(len(solved), solved[-1].solution))
            promised = value - proposal.cost
            if promised <= rules.least_gain * max(1.0, abs(value)):
                return ended(
                    ExitReason.CONVERGED,
                    f"converged after {number} linearisations and {len(solved)} conic problems: the last promised"
                    f" {max(promised, 0.0):.1e} of {value:.6g}",
                )
            trial = restore(proposal.iterate)
            gain = -float("inf") if trial is None else value - cost(trial)
            if trial is not None and gain >= rules.accepted * promised:
                reference, value = trial, value - gain
            if gain < rules.poor * promised:
                radius = rules.shrink * min(radius, proposal.distance)
            elif gain > rules.good * promised:
                radius = max(radius, rules.grow * proposal.distance)
            if radius < rules.least_radius:
                return ended(
                    ExitReason.MAX_ITERATIONS,
                    f"no step of more than {rules.least_radius:g} gains anything at {value:.9g}, though {promised:.1e} is"
                    " promised",
                )
    except KeyboardInterrupt:
        return ended(ExitReason.INTERRUPTED, f"interrupted after {len(solved)} conic problems")
    return ended(
        ExitReason.MAX_ITERATIONS,
        f"no convergence after {rules.max_iterations} linearisations, at {value:.9g}",
    )


def _usable(solution: Solution, rules: Rules) -> bool:
    """Whether to move to this solution: solved, or close enough by its residuals on the original data."""
    near = (Status.SOLVED, Status.SOLVED_INACCURATE, Status.NUMERICAL_LIMIT, Status.MAX_ITERATIONS)
    return solution.status in near and within_residual(solution, rules.usable_residual)


def within_residual(solution: Solution, limit: float) -> bool:
    """Whether a solution is called solved, or its residuals on the original data are within `limit`."""
    if solution.status is Status.SOLVED:
        return True
    evidence = solution.certificate
    residuals = (evidence.primal_residual, evidence.dual_residual, evidence.gap)
    return all(residual <= limit for residual in residuals)


def _failure(number: int, solution: Solution) -> tuple[ExitReason, str]:
    status = solution.status
    if status is Status.INTERRUPTED:
        return ExitReason.INTERRUPTED, f"interrupted in iteration {number}"
    which = f"the subproblem of iteration {number}"
    if status is Status.PRIMAL_INFEASIBLE:
        return ExitReason.SUBPROBLEM_INFEASIBLE, f"{which} has no feasible point: {solution.message}"
    return ExitReason.SUBPROBLEM_FAILED, f"{which} ended with {status.name}: {solution.message}"
