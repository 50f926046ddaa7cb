"""Burns whose cones hold a rate of the attitude: within the bound of a scenario, and as fast as the finest grid follows.

Relaxed to |u| ≤ 1, a turn that the cones slow down takes the short way through the inside of the ball, at part of the thrust.
Where that happens, thrust that is missing gets a price above its worth, linearised about the last iterate (the convex–concave
procedure, Yuille & Rangarajan 2003), and the sequence ends on the sphere again.
"""

from __future__ import annotations

from collections.abc import Generator, Iterator
from dataclasses import replace
from typing import TypeVar

import numpy as np

from orbsoc.guidance.scp import ExitReason, Outcome

from .. import tuning
from ..model.attitude_rate import RateBound, peak_rate
from ..model.problems import Iterate
from ..starts.directions import Start
from ..starts.steering_law import grid_resolves, unit_on
from ..targets.rows import Row
from .run import Attempt, Claim, Findings, Search, SearchResult, Standing, fly_and_verify, verified
from .setup import InsertionSetup

R = TypeVar("R")
Attempts = Generator[Attempt, None, R]
"""Attempts as they are made, and what they lead to."""
TURNING = Start("turning within the bound")
QUICK = Start("as fast a turn as the finest grid follows")


def within_bound(search: Search, result: SearchResult, *, refine: bool = True) -> Findings:
    """The burn without the bound where its flight keeps it; else, or where that is a smooth law, one whose cones hold the bound."""
    setup, free = result.setup, result.best
    kept = _kept(setup, free)
    if kept is not None:
        yield kept
        if free.claim is not Claim.SMOOTH_TURN or (refine and (yield from _quick_within(search, result))):
            return
    yield from _on_grids(search, setup, free.iterate, refine=refine)


def too_quick(_search: Search, result: SearchResult) -> Findings:
    """The burn that reaches the target, and by how much it turns too fast."""
    bound, free = result.setup.rate_bound, result.best
    assert bound is not None
    arc = free.trajectory
    excess = 2.0 * peak_rate(arc.grid, arc.controls) / arc.duration - bound
    iterate = replace(free.iterate, slack=((Row.ATTITUDE_RATE, excess),))
    message = "the burn that reaches the target turns faster than is allowed, and none that turns more slowly was found"
    yield replace(
        free,
        note="the same, and the bound on the attitude rate",
        outcome=Outcome(ExitReason.INFEASIBLE, iterate, (), message),
        claim=Claim.BEST_FOUND,
        verification=None,
        standing=Standing.AS_ASKED,
    )


def quick_turn(search: Search, result: SearchResult) -> Iterator[Attempt]:
    """From a smooth law with a bound on the attitude rate that no scenario asked for, on few nodes; the finest grid follows what
    that finds. The bound is raised until a flight no longer confirms the burn."""
    best = result.best
    setup, arc = result.setup.unbounded.at(best.ignition_s), best.trajectory
    method = setup.scenario.method
    most = min(tuning.QUICK_RULES.max_iterations, search.rules.max_iterations)
    search = replace(search, rules=replace(tuning.QUICK_RULES, max_iterations=most))
    nodes = min(
        int(np.ceil(tuning.GROWTH * method.nodes)),
        max(tuning.FEWEST_NODES, int(tuning.COARSE * method.max_nodes)),
    )
    slow = 2.0 * peak_rate(arc.grid, arc.controls) / arc.duration
    low, high, rate = slow, np.inf, tuning.FIRST * slow
    reference = setup.resampled(best.iterate, min(nodes, method.max_nodes))
    for tried in range(tuning.MOST_TRIED):
        made, _price = yield from _at_rate(search, setup, reference, rate, QUICK, claim=Claim.FAST_TURN)
        attempt = made.on_the_way
        if made.is_near:
            reference = made.iterate
            allowed = setup.scenario.verification.thrust_excess
            if grid_resolves(made.law, method.max_nodes, allowed):  # before it is corrected in flight
                attempt = yield from _finished(setup, made, steps=tuning.QUICK_STEPS)
        yield attempt
        if result.rank(attempt) < result.rank(best):
            best, low = attempt, rate
        else:
            high = rate
        if high < tuning.CLOSE * low or (tried == tuning.MOST_IDLE and best is result.best):
            return
        rate = tuning.FASTER * low if high == np.inf else float(np.sqrt(low * high))


def _kept(setup: InsertionSetup, free: Attempt) -> Attempt | None:
    """A burn that was found without the bound, where its flight keeps it."""
    found = None if free.verification is None else fly_and_verify(setup, free.iterate)
    if found is None or not found.verified:
        return None
    outcome = replace(free.outcome, iterations=())
    note = f"{free.note}, judged with the bound"
    return replace(free, note=note, outcome=outcome, verification=found, standing=Standing.AS_ASKED)


def _quick_within(search: Search, result: SearchResult) -> Attempts[bool]:
    """Whether the fastest turn that a grid follows keeps the bound: then it is the answer."""
    best = result.best
    for each in quick_turn(search, result):
        yield each
        best = min(best, each, key=result.rank)
    kept = _kept(result.setup, best)
    if kept is not None and best is not result.best:
        yield kept
    return kept is not None


def _on_grids(search: Search, setup: InsertionSetup, reference: Iterate, *, refine: bool) -> Attempts[None]:
    """From coarse to fine, as long as a finer grid finds a shorter or better burn."""
    method, nodes = setup.scenario.method, setup.scenario.method.nodes
    last: float | None = None
    while True:
        ended = yield from _on_grid(search, setup, setup.resampled(reference, nodes))
        if ended is None:
            return
        reference, is_verified = ended
        aim = _aim(setup, reference)
        converged = is_verified and last is not None and last - aim < tuning.WORTH_A_GRID * abs(last)
        if converged or not refine or nodes == method.max_nodes:
            return
        last = aim if is_verified else None
        nodes = min(method.max_nodes, int(np.ceil(tuning.GROWTH * nodes)))


def _on_grid(
    search: Search, setup: InsertionSetup, reference: Iterate
) -> Attempts[tuple[Iterate, bool] | None]:
    """The burn on one grid, and whether its flight confirms it; None where the bound and the target do not go together."""
    bound = setup.rate_bound
    assert bound is not None
    share, price = 1.0 - tuning.MARGIN, 0.0
    ended: tuple[Iterate, bool] | None = None
    for _ in range(tuning.ROUNDS):
        made, price = yield from _at_rate(search, setup, reference, share * bound, TURNING, price=price)
        reference = made.iterate
        if not made.is_near:
            yield made.on_the_way
            return ended
        attempt = yield from _finished(setup, made)
        found = attempt.verification
        faster = np.inf if found is None else found.peak_rate_rad_s * setup.units.time_s / bound
        yield attempt if faster <= 1.0 else attempt.on_the_way
        if found is None:
            return ended
        ended = reference, found.verified
        if faster <= 1.0:
            return ended
        if faster > tuning.TOO_FAST:
            return None
        share *= (1.0 - tuning.MARGIN) / faster
    return ended


def _at_rate(
    search: Search,
    setup: InsertionSetup,
    reference: Iterate,
    rate: float,
    start: Start,
    *,
    price: float = 0.0,
    claim: Claim = Claim.BEST_FOUND,
) -> Attempts[tuple[Attempt, float]]:
    """The burn on the grid of a reference whose cones hold a rate, at full thrust, not flown; and the price that this took."""

    def turning(reference: Iterate, price: float) -> Attempt:
        note = start.name if price == 0.0 else f"{start.name}, at full thrust"
        within, whole = replace(setup, turn=RateBound(rate, price)), replace(reference, slack=())
        return search.sequence(within, whole, note, start=start, firm=True, claim=claim)

    made = turning(reference, price)
    while _is_loose(made) and made.is_near and price < tuning.HIGHEST_PRICE:
        yield made.on_the_way
        price = max(tuning.FIRST_PRICE, 4.0 * price)
        made = turning(made.iterate, price)
    return made, price


def _finished(setup: InsertionSetup, attempt: Attempt, *, steps: int | None = None) -> Attempts[Attempt]:
    """The attempt with its flight where that confirms it; else its directions on a grid that follows them, corrected in flight."""
    flown = replace(attempt, verification=fly_and_verify(setup, attempt.iterate))
    if setup.scenario.problem != "min_time" or flown.verified:
        return flown
    nodes = max(attempt.nodes, setup.nodes_that_follow(attempt.law))
    unit = unit_on(setup.burn, setup.target, attempt.law, nodes, tuning.REACHED, steps=steps)
    if unit is None:
        return flown
    yield attempt.on_the_way
    message = f"{attempt.outcome.message}; its directions were then corrected in flight"
    outcome = Outcome(ExitReason.CONVERGED, setup.by_interpolant(unit, nodes), (), message)
    note = f"{attempt.start.name}, corrected in flight"
    return verified(setup, replace(attempt, note=note, outcome=outcome))


def _is_loose(attempt: Attempt) -> bool:
    return float(np.linalg.norm(attempt.trajectory.controls, axis=1).min()) < 1.0 - tuning.LOOSE


def _aim(setup: InsertionSetup, iterate: Iterate) -> float:
    """What a finer grid makes smaller: the burn time, or the energy with its sign changed."""
    arc = iterate.trajectory
    if setup.scenario.problem == "min_time":
        return arc.duration
    return float(1.0 / np.linalg.norm(arc.end[:3]) - 0.5 * arc.end[3:] @ arc.end[3:])
