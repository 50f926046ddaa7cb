"""Convex problems in sequence: planes about the last safe flight, and the instants at which a solution broke a condition worst.

At first all planes have the normal of one side. Once a flight keeps every condition at every instant it is the reference, and
planes touch the keep-out where it is seen from there: the reference keeps them, so that the next safe flight costs no more.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
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
WIDTHS = (0.05, 0.3, 0.6, 0.8, 0.9, 1.0)
"""Of the keep-out, by which it grows."""
ACROSS = 1.5
"""Of the keep-out, by which a flight is first kicked out of the orbital plane."""
OPPOSITE = -0.99
"""Cosine of an angle: directions with a larger one between them have two ways from one to the other."""
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
    forms: Forms | None = None
    """Of its problems, where these are not of the approach as it is given."""
    drawn: bool = False
    """Whether it began about a draw."""

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
    places = np.array([approach.start[:3], gate]) / approach.outer_m
    for name, way in ways.items():
        known = any(each[0] @ way > 1.0 - 1e-9 for each in found.values())
        if not known and (places @ way >= 1.0).all():
            found[name] = np.tile(way, (approach.times_s.size, 1))
    return found


def turns(approach: Approach) -> dict[str, Array]:
    """Ways about the keep-out, normals (K, 3): from the start's direction to the gate's, over some of the arcs before it, the short
    way, or below and above where both are opposite."""
    ends = np.array([approach.start[:3], approach.scenario.gate.position()]) / approach.outer_m
    first, last = ends / np.linalg.norm(ends, axis=1)[:, None]
    vertices: dict[str, tuple[Array, ...]] = {"the short way": (first, last)}
    if first @ last < OPPOSITE:
        vertices = {
            name: (first, np.array([sign, 0.0, 0.0]), last)
            for name, sign in (("below", -1.0), ("above", 1.0))
        }
    count = int(np.searchsorted(approach.times_s, approach.scenario.gate.arrive_s - 1e-6))
    half, arcs = count // 2, np.arange(approach.times_s.size)
    spans = dict.fromkeys([(1, count - 1), (2, count - 2), (1, half), (0, half), (1, 1), (half, half)])
    found: dict[str, Array] = {}
    for name, corners in vertices.items():
        for early, late in spans:
            if not 0 <= early <= late < count:
                continue
            shares = np.clip((arcs - early + 0.5) / (late - early + 1), 0.0, 1.0)
            shares[arcs < early], shares[arcs > late] = 0.0, 1.0
            ways = np.array([_turned(corners, float(share)) for share in shares])
            found[f"about it {name}, impulses {early + 1} to {late + 1}"] = ways
    return found


def _turned(corners: Sequence[Array], share: float) -> Array:
    """The direction at a share of the way by great circles from corner to corner, (3,)."""
    place = share * (len(corners) - 1)
    k = min(int(place), len(corners) - 2)
    one, other = corners[k], corners[k + 1]
    angle = float(np.arccos(np.clip(one @ other, -1.0, 1.0)))
    if angle < 1e-6:
        return one
    part = place - k
    return np.asarray((np.sin((1.0 - part) * angle) * one + np.sin(part * angle) * other) / np.sin(angle))


def attempt(
    approach: Approach,
    forms: Forms,
    name: str,
    normals: Array | None,
    solve: Solve,
    callback: Callable[[Iteration], None] | None,
    start: Found | None = None,
    *,
    any_safe: bool = False,
    rules: Rules = RULES,
    search: Search | None = None,
) -> Attempt:
    """The sequence whose first planes have normals (K, 3), or are about a safe flight with its instants, `start`, or about the
    flight that knows no keep-out.

    With `any_safe` it ends with the first safe flight; otherwise as the rules say.
    """
    search = search or Search(approach)
    built: list[Filled] = []

    def linearise(reference: Found) -> Subproblem[Found]:
        about = reference.safe or known or (reference.last if normals is None else None)
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
    known = None if start is None else start.safe
    if start is not None and known is not None:
        first = forms.begun(start.instants, Instants(keep_out=search.broken(known).instants.keep_out))
    rules = SHORT if any_safe else rules
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
    """Drifts that are looked at for longer and longer: at first none reaches the keep-out."""
    steps = [replace(approach, share=share) for share in SHARES]
    return _step_by_step(steps, forms, "drift by drift", None, solve, callback)


def beside(
    approach: Approach, flight: ImpulseProgramme, solve: Solve, callback: Callable[[Iteration], None] | None
) -> Attempt:
    """About the flight after a kick across the orbital plane: from planes that hold no direction across it nothing leaves it, and
    drifts may pass beside the keep-out for less."""
    dv = flight.dv_m_s.copy()
    dv[0, 2] += ACROSS * float(np.max(approach.outer_m)) * approach.mean_motion_rad_s
    kicked = ImpulseProgramme(flight.times_s, dv)
    return about(approach, "across the orbital plane", kicked, solve, callback)


def about(
    approach: Approach,
    name: str,
    flight: ImpulseProgramme,
    solve: Solve,
    callback: Callable[[Iteration], None] | None,
) -> Attempt:
    """About a flight that need not be safe, in the orbital plane and across it."""
    solid = replace(approach, across=True)
    forms = Forms(solid)
    start = Found(flight, forms.begun(at_nodes(solid), Instants()))
    found = attempt(solid, forms, name, None, solve, callback, start)
    return replace(found, forms=forms)


def widened(
    approach: Approach,
    forms: Forms,
    name: str,
    normals: Array | None,
    solve: Solve,
    callback: Callable[[Iteration], None] | None,
) -> Attempt:
    """A keep-out that grows from a point, about which drifts pass with planes of these normals (K, 3) or as they come."""
    steps = [replace(approach, narrow=narrow) for narrow in WIDTHS]
    return _step_by_step(steps, forms, name, normals, solve, callback)


def _step_by_step(
    steps: Sequence[Approach],
    forms: Forms,
    name: str,
    normals: Array | None,
    solve: Solve,
    callback: Callable[[Iteration], None] | None,
) -> Attempt:
    """Sequences in a row, each harder than the one before and about its safe flight; the last is the approach itself.

    It ends with the first sequence that finds nothing safe.
    """
    start: Found | None = None
    solved: list[Iteration] = []
    for step in steps:
        last = step is steps[-1]
        found = attempt(step, forms, name, normals, solve, callback, start, any_safe=not last)
        solved += found.subproblems
        start, normals = found.reference, None
        if start.safe is None or (not last and found.reason is not ExitReason.CONVERGED):
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
