"""Convex problems in sequence: planes about the last safe flight, and the instants at which a solution broke a condition worst.

At first all planes have the normal of one side. Once a flight keeps every condition at every instant it is the reference, and
planes touch the keep-out where it is seen from there: the reference keeps them, so that the next safe flight costs no more.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from orbsoc.conic.settings import Settings
from orbsoc.conic.solution import Solution, Status
from orbsoc.guidance.impulses import ImpulseProgramme, Impulses
from orbsoc.guidance.scp import ExitReason, Iteration, Rules, Solve, Step, Subproblem, sequential_convex
from orbsoc.orbit.array import Array

from ..model.approach import Approach
from ..model.nearest import Search
from ..model.problem import ENTERED, Instants, assemble, at_nodes, flown

RULES = Rules(
    step_tol=1e-4, slack_tol=2e-3, infeasible_slack=1e-2, max_iterations=40, loose_tol=1e-8, tight_tol=1e-8,
    usable_residual=1e-5, final_residual=1e-6,
)  # fmt: skip
"""A step is the relative change of the cost of safe flights; a flight that breaks a condition counts as a step of 1."""
SAFE_M = 1.5e-3
"""By which a safe flight may break a condition; the rows ask for `ROOM_M` more than the scenario."""


@dataclass(frozen=True, slots=True, eq=False)
class Reference:
    """The last safe flight and its cost, the instants that the next problem asks for, and the last flight, safe or not."""

    safe: ImpulseProgramme | None
    instants: Instants
    cost: float = float("inf")
    last: ImpulseProgramme | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Attempt:
    """A sequence that began on one side: why it ended, and its last flight."""

    side: str
    reason: ExitReason
    message: str
    reference: Reference
    subproblems: tuple[Iteration, ...]
    why: str = ""
    """Of an infeasible problem: the conditions that contradict each other."""

    @property
    def found(self) -> bool:
        """Whether a safe flight was found, though perhaps not the last of its sequence."""
        return self.reference.safe is not None and self.reason is not ExitReason.INTERRUPTED


def sides(approach: Approach) -> dict[str, Array | None]:
    """Where the keep-out is passed at first, (R, T, N): where the flight without it passes, on the gate's side, below, above."""
    gate = approach.scenario.gate.position()
    ways = {
        "on the gate's side": gate / np.linalg.norm(gate),
        "below": np.array([-1.0, 0.0, 0.0]),
        "above": np.array([1.0, 0.0, 0.0]),
    }
    found: dict[str, Array | None] = {"as it comes": None}
    places = np.array([approach.start[:3], gate]) / (approach.axes_m + approach.scenario.keep_out.margin_m)
    for name, way in ways.items():
        known = any(each is not None and each @ way > 1.0 - 1e-9 for each in found.values())
        if not known and (places @ way >= 1.0).all():
            found[name] = way
    return found


def attempt(
    approach: Approach,
    name: str,
    side: Array | None,
    solve: Solve,
    callback: Callable[[Iteration], None] | None,
) -> Attempt:
    """The sequence that begins on a side, or without one with planes about the flight that knows no keep-out."""
    search = Search(approach)
    built: list[Impulses] = []
    # for all time: seen along the track, drifts that do not come back in a revolution must not later
    away = side if np.isinf(approach.horizon_s) and side is not None and abs(side[1]) > 0.5 else None

    def linearise(reference: Reference) -> Subproblem[Reference]:
        about = reference.safe or (reference.last if side is None else None)
        after = None if about is None else flown(approach, about)
        normal = side if reference.safe is None else None
        impulses = assemble(approach, reference.instants, after, about, normal, away)
        built.append(impulses)

        def read(solution: Solution) -> Step[Reference]:
            found = impulses.programme(solution)
            broken = search.broken(found, normal)
            cost = cost_of(approach, found)
            slack = (
                float(impulses.builder.value(solution, ENTERED)[0]) if impulses.builder.has(ENTERED) else 0.0
            )
            safe = broken.worst_m <= SAFE_M
            settled = safe or broken.worst_m <= slack + SAFE_M
            change = (
                abs(reference.cost - cost) / max(cost, 1e-3)
                if settled and np.isfinite(reference.cost)
                else 1.0
            )
            more = reference.instants.with_more(broken.instants)
            step = Reference(
                found if safe else reference.safe, more, cost if settled else reference.cost, found
            )
            return Step(step, change, max(slack, 0.0), {"cost_m_s": cost, "broken_m": broken.worst_m})

        return Subproblem(impulses.builder.build(), read)

    first = Reference(None, at_nodes(approach))
    outcome = sequential_convex(first, linearise, solve=solve, rules=RULES, callback=callback)
    why = ""
    if outcome.reason is ExitReason.SUBPROBLEM_INFEASIBLE:
        why = built[-1].builder.why(outcome.iterations[-1].solution)
    return Attempt(name, outcome.reason, outcome.message, outcome.iterate, outcome.iterations, why)


def lower_bound(approach: Approach, instants: Instants, solve: Solve) -> tuple[float | None, Iteration]:
    """Below the cost of every programme at these instants, keep-out and speed limit left out, for they are not convex; and
    the solve. None where it was not solved."""
    without = replace(instants, keep_out=(), speed=())
    problem = assemble(approach, without, None).builder.build()
    solution = solve(problem, Settings(tol=1e-8))
    row = Iteration(1, 1e-8, problem, solution)
    return (solution.dual_objective if solution.status is Status.SOLVED else None), row


def cost_of(approach: Approach, programme: ImpulseProgramme) -> float:
    """As the scenario counts it, m/s."""
    norms = approach.scenario.engine.cost == "norms"
    return programme.total_m_s if norms else programme.total_absolutes_m_s
