"""Convex problems in sequence: planes about the last safe flight, and the instants at which a solution broke a condition worst.

At first all planes have the normal of one side. Once a flight keeps every condition at every instant it is the reference, and
planes touch the keep-out where it is seen from there: the reference keeps them, so that the next safe flight costs no more.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from orbsoc.conic.settings import Settings
from orbsoc.conic.solution import Solution
from orbsoc.guidance.impulses import ImpulseProgramme
from orbsoc.guidance.scp import ExitReason, Iteration, Rules, Solve, Step, Subproblem, sequential_convex
from orbsoc.orbit.array import Array

from ..model.approach import Approach
from ..model.instants import Instant, Instants, at_nodes
from ..model.nearest import Search
from ..model.problem import Filled, Forms, flown
from ..model.rows import Reference

RULES = Rules(
    step_tol=1e-4, slack_tol=2e-3, infeasible_slack=1e-2, max_iterations=40, loose_tol=1e-8, tight_tol=1e-8,
    usable_residual=1e-5, final_residual=1e-6,
)  # fmt: skip
"""A step is the relative change of the cost of safe flights; a flight that breaks a condition counts as a step of 1."""
SHORT = replace(RULES, max_iterations=15)
SHARES = (0.5, 0.6, 0.7, 0.8, 0.9, 1.0)
"""Of the drifts' horizon, by which they grow."""
SAFE_M = 1.5e-3
"""By which a safe flight may break a condition; the rows ask for `ROOM_M` more than the scenario."""


@dataclass(frozen=True, slots=True, eq=False)
class Found:
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
    reference: Found
    subproblems: tuple[Iteration, ...]
    why: str = ""
    """Of an infeasible problem: the conditions that contradict each other."""

    @property
    def found(self) -> bool:
        """Whether a safe flight was found, though perhaps not the last of its sequence."""
        return self.reference.safe is not None and self.reason is not ExitReason.INTERRUPTED


def sides(approach: Approach) -> dict[str, Array]:
    """Where the keep-out is passed at first, normals (K, 3): on the gate's side, below, above."""
    gate = approach.scenario.gate.position()
    ways = {
        "on the gate's side": gate / np.linalg.norm(gate),
        "below": np.array([-1.0, 0.0, 0.0]),
        "above": np.array([1.0, 0.0, 0.0]),
    }
    found: dict[str, Array] = {}
    places = np.array([approach.start[:3], gate]) / (approach.axes_m + approach.scenario.keep_out.margin_m)
    for name, way in ways.items():
        known = any(each[0] @ way > 1.0 - 1e-9 for each in found.values())
        if not known and (places @ way >= 1.0).all():
            found[name] = np.tile(way, (approach.times_s.size, 1))
    return found


def attempt(
    approach: Approach,
    forms: Forms,
    name: str,
    normals: Array | None,
    solve: Solve,
    callback: Callable[[Iteration], None] | None,
    start: ImpulseProgramme | None = None,
    *,
    any_safe: bool = False,
) -> Attempt:
    """The sequence whose first planes have normals (K, 3), or are about `start`, or about the flight that knows no keep-out.

    With `any_safe` it ends with the first safe flight.
    """
    search = Search(approach)
    built: list[Filled] = []

    def linearise(reference: Found) -> Subproblem[Found]:
        about = reference.safe or start or (reference.last if normals is None else None)
        states = None if about is None else flown(approach, about)
        own = normals if reference.safe is None else None
        asked = (
            reference.instants
            if about is not None or own is not None
            else reference.instants.without("keep_out")
        )
        filled = forms.form.filled(asked, Reference(approach, about, states), own, normals)
        built.append(filled)

        def read(solution: Solution) -> Step[Found]:
            found, slack = filled.programme(solution), filled.entered(solution)
            broken = search.broken(found, own)
            cost = cost_of(approach, found)
            safe = broken.worst_m <= SAFE_M
            settled = safe or broken.worst_m <= slack + SAFE_M
            change = 1.0
            if any_safe:
                change = 0.0 if safe else 1.0
            elif settled and np.isfinite(reference.cost):
                change = abs(reference.cost - cost) / max(cost, 1e-3)
            more = forms.fitted(filled, solution, broken.instants)
            step = Found(found if safe else reference.safe, more, cost if settled else reference.cost, found)
            return Step(step, change, slack, {"cost_m_s": cost, "broken_m": broken.worst_m})

        return Subproblem(filled.problem, read)

    first = forms.begun(at_nodes(approach), away(approach, normals))
    if start is not None:
        first = forms.begun(first, Instants(keep_out=search.broken(start).instants.keep_out))
    rules = SHORT if any_safe else RULES
    outcome = sequential_convex(Found(None, first), linearise, solve=solve, rules=rules, callback=callback)
    why = ""
    if outcome.reason is ExitReason.SUBPROBLEM_INFEASIBLE:
        why = built[-1].why(outcome.iterations[-1].solution)
    return Attempt(name, outcome.reason, outcome.message, outcome.iterate, outcome.iterations, why)


def away(approach: Approach, normals: Array | None) -> Instants:
    """For all time: seen along the track, drifts that do not come back in a revolution must not later."""
    if normals is None or np.isfinite(approach.horizon_s):
        return Instants()
    along = np.flatnonzero(np.abs(normals[: approach.guarded, 1]) > 0.5).tolist()
    return Instants(away=tuple(Instant(k, float(approach.times_s[k])) for k in along))


def lengthened(
    approach: Approach, forms: Forms, solve: Solve, callback: Callable[[Iteration], None] | None
) -> Attempt:
    """Sequences in a row, each with drifts that are looked at for longer, about the safe flight of the one before.

    At first no drift reaches the keep-out. It ends with the first sequence that finds nothing safe.
    """
    start: ImpulseProgramme | None = None
    solved: list[Iteration] = []
    for share in SHARES:
        longer = replace(approach, share=share)
        found = attempt(longer, forms, "drift by drift", None, solve, callback, start, any_safe=share < 1.0)
        solved += found.subproblems
        start = found.reference.safe
        if start is None or found.reason is not ExitReason.CONVERGED:
            found = replace(found, reference=replace(found.reference, safe=None))
            break
    return replace(found, subproblems=tuple(solved))


def solve_convex(
    approach: Approach, forms: Forms, instants: Instants, solve: Solve
) -> tuple[Filled, Iteration]:
    """The problem without keep-out about straight lines: the first flight, or, with the speed limit left out too, which is not
    convex either, the one whose dual objective is below the cost of every programme at these instants."""
    filled = forms.form.filled(
        instants.without("keep_out", "away"), Reference(approach, None, None), None, None
    )
    return filled, Iteration(1, 1e-8, filled.problem, solve(filled.problem, Settings(tol=1e-8)))


def cost_of(approach: Approach, programme: ImpulseProgramme) -> float:
    """As the scenario counts it, m/s."""
    norms = approach.scenario.engine.cost == "norms"
    return programme.total_m_s if norms else programme.total_absolutes_m_s
