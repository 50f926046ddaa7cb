"""The ways to a burn as data, in the order in which they are tried, and those that set out from a start: thrust along the velocity,
laws that are flown onto the orbit, laws that turn smoothly, constant directions."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial

import numpy as np

from orbsoc.guidance.scp import ExitReason, Outcome
from orbsoc.orbit import PropagationError

from .. import tuning
from ..model.problems import Iterate
from ..model.proof import proof_of_infeasibility
from ..starts.directions import Start, impulse, starts
from ..starts.steering_law import Law, corrected, smoothed, unit_on
from .ignition import later_burns
from .run import Attempt, Claim, Findings, Search, SearchResult, Standing, Strategy, attempt_of, verified
from .setup import InsertionSetup
from .turning import quick_turn, too_quick, within_bound

NOTHING = Start("no start: the vehicle is on its target orbit")


def null_burn(_search: Search, result: SearchResult) -> Findings:
    """A burn of 0 s, where the vehicle is on its target orbit."""
    setup = result.setup
    coarse = setup.along(setup.burn.start[3:]).trajectory
    states = np.tile(setup.burn.start, (coarse.grid.size, 1))
    still = Iterate(replace(coarse, states=states, end=setup.burn.start, duration=0.0))
    outcome = Outcome(ExitReason.CONVERGED, still, (), "the vehicle is on its target orbit: nothing to burn")
    attempt = verified(setup, attempt_of(setup, NOTHING.name, outcome, NOTHING, Claim.NOTHING_TO_BURN))
    if attempt.verified:
        yield attempt


def cold_start(search: Search, result: SearchResult) -> Findings:
    """Thrust along the velocity, refined until its flight confirms it."""
    setup = result.setup.unbounded
    attempt = search.sequence(setup, setup.cold_start(), "cold start")
    soft = attempt.outcome.reason is ExitReason.SUBPROBLEM_INFEASIBLE and setup.free_perigee
    if soft:
        yield attempt.on_the_way
        note = "restart with slack: a subproblem was infeasible"
        attempt = search.sequence(setup, setup.cold_start(), note, soft=True)
    yield from flown_and_refined(search, setup, attempt, soft=soft)


def proof(_search: Search, result: SearchResult) -> Findings:
    """A bound that no burn escapes."""
    setup = result.setup
    shortest = setup.scenario.problem == "min_time"
    duration = setup.burn.longest if shortest else setup.scenario.burn.guess_s / setup.units.time_s
    found = proof_of_infeasibility(setup.burn, setup.target, duration)
    if found is not None:
        yield found


def laws_tried(result: SearchResult) -> list[Start]:
    """Starts that are laws, in the order in which they were tried."""
    return list(dict.fromkeys(each.start for each in result.attempts if each.start.law is not None))


def next_law(search: Search, result: SearchResult) -> Findings:
    """From the next start that is flown onto the target orbit; the first one is refined."""
    setup, tried = result.setup.unbounded, laws_tried(result)
    for start in starts(setup.burn, setup.target, after=len(tried)):
        if start.reaches:
            yield from law(search, result, start, refine=not any(each.reaches for each in tried))
            return
        yield _missed(setup, start)


def law(search: Search, result: SearchResult, start: Start, *, refine: bool) -> Iterator[Attempt]:
    """The sequence from a law that reaches the orbit, and its directions corrected in flight."""
    setup = result.setup.unbounded
    assert start.law is not None
    reference = replace(setup.by_law(start.law, setup.scenario.method.nodes), slack=())
    attempt = verified(setup, search.sequence(setup, reference, start.name, firm=True, start=start))
    yield attempt
    moved = None if attempt.verified else _corrected(setup, attempt)
    if moved is not None:
        yield moved
    if refine:
        yield from _refined(search, setup, moved or attempt, firm=True)


def constant_directions(search: Search, result: SearchResult) -> Findings:
    """Thrust along one direction for the scenario's burn time."""
    setup = result.setup.unbounded
    for name, direction in (
        ("thrust towards the target's velocity", impulse(setup.burn, setup.target)),
        ("thrust against the velocity", -setup.burn.start[3:]),
    ):
        if float(np.linalg.norm(direction)) < 1e-6:
            continue
        attempt = search.sequence(setup, setup.along(direction), name, soft=True, start=Start(name))
        for made in flown_and_refined(search, setup, attempt, soft=True):
            yield made
            if made.verified:
                return


def flown_and_refined(
    search: Search, setup: InsertionSetup, attempt: Attempt, *, soft: bool
) -> Iterator[Attempt]:
    """The attempt with its flight, and finer grids."""
    attempt = verified(setup, attempt)
    yield attempt
    yield from _refined(search, setup, attempt, soft=soft)


def _refined(
    search: Search, setup: InsertionSetup, attempt: Attempt, *, soft: bool = False, firm: bool = False
) -> Iterator[Attempt]:
    """Finer grids, each from the flight of the one before, until the flight confirms the burn or there is none."""
    method = setup.scenario.method
    while attempt.verification is not None and not attempt.verified and attempt.nodes < method.max_nodes:
        if firm and attempt.verification.thrust_excess > tuning.REVERSES and attempt.nodes > method.nodes:
            return
        nodes = min(method.max_nodes, int(np.ceil(tuning.GROWTH * attempt.nodes)))
        reference = setup.resampled(attempt.iterate, nodes)
        note = f"refined: {attempt.verification.failures[0]}"
        made = search.sequence(setup, reference, note, soft=soft, firm=firm, start=attempt.start)
        before, attempt = attempt.verification.failures, verified(setup, made)
        moved = _corrected(setup, attempt) if firm and not attempt.verified else None
        yield attempt if moved is None else attempt.on_the_way
        if moved is not None:
            attempt = moved
            yield moved
        if attempt.verification is not None and attempt.verification.failures == before:
            return  # to three digits: it is not the grid that fails


def _corrected(setup: InsertionSetup, attempt: Attempt) -> Attempt | None:
    """The attempt with its thrust directions corrected until the flight ends on the orbit; None where that fails."""
    if not attempt.is_near:
        return None
    law, miss = corrected(setup.burn, setup.target, attempt.law, iterations=8)
    if miss > tuning.REACHED:
        return None
    message = f"{attempt.outcome.message}; the thrust directions were then corrected in flight"
    outcome = Outcome(ExitReason.CONVERGED, setup.by_interpolant(law, attempt.nodes), (), message)
    return verified(setup, replace(attempt, note="corrected in flight", outcome=outcome, verification=None))


def _missed(setup: InsertionSetup, start: Start) -> Attempt:
    """A start that did not find the orbit, with what it leaves."""
    assert start.law is not None
    try:
        iterate = setup.by_law(start.law, setup.scenario.method.nodes)
    except PropagationError:
        iterate = setup.cold_start()
    message = f"{start.name}: corrected in flight, the closest burn misses the orbit by {start.miss:.1e}"
    return attempt_of(setup, start.name, Outcome(ExitReason.INFEASIBLE, iterate, (), message), start)


def is_not_the_shortest(result: SearchResult) -> bool:
    """Whether nothing is verified, or something longer than where a sequence converged."""
    ends = [
        each.trajectory.duration
        for each in result.attempts
        if each.outcome.reason is ExitReason.CONVERGED and each.outcome.iterations
    ]
    longer = bool(ends) and result.trajectory.duration > (1.0 + tuning.WORTH_A_LAW) * min(ends)
    return longer or not result.verified


def smooth_law(
    _search: Search, result: SearchResult, shares: tuple[float, ...] = tuning.SHORTENED
) -> Findings:
    """From the law that was tried last, a smooth one, shortened: a plan where the shortest burn reverses its thrust."""
    setup, known, start = result.setup.unbounded, result.best, laws_tried(result)[-1]
    assert start.law is not None
    drawn = replace(known.law, coefficients=known.law.coefficients[: tuning.SMOOTHED])
    nodes = setup.scenario.method.max_nodes
    # the correction on the grid lengthens the interpolant, too
    for too_long in (tuning.TOO_LONG, 0.1 * tuning.TOO_LONG):
        for first in (drawn, start.law):
            found = smoothed(setup.burn, setup.target, first, nodes, too_long, shares)
            attempt = None if found is None else _smooth_attempt(setup, found, start)
            if attempt is not None:
                yield attempt
                if attempt.verified and result.rank(attempt) < result.rank(known):
                    return


def _smooth_attempt(setup: InsertionSetup, law: Law, start: Start) -> Attempt | None:
    """On the coarsest grid that follows a law: the interpolant of its nodal directions, corrected and made of unit length by turns."""
    nodes = setup.nodes_that_follow(law)
    unit = unit_on(setup.burn, setup.target, law, nodes, tuning.REACHED)
    if unit is None:
        return None
    message = "a smooth turn of the thrust reaches the orbit"
    outcome = Outcome(ExitReason.CONVERGED, setup.by_interpolant(unit, nodes), (), message)
    note = "a law that turns smoothly, shortened"
    return verified(setup, attempt_of(setup, note, outcome, start, Claim.SMOOTH_TURN))


BEST, SMOOTH, FAST = (frozenset({each}) for each in (Claim.BEST_FOUND, Claim.SMOOTH_TURN, Claim.FAST_TURN))


def _is_open(result: SearchResult) -> bool:
    return not result.verified and result.proof is None


def _is_shortest_burn(result: SearchResult) -> bool:
    return result.scenario.problem == "min_time"


def _was_flown(number: int, result: SearchResult) -> bool:
    """Whether the law flown last is that of a number, and left something to be desired."""
    flown = sum(each.reaches for each in laws_tried(result))
    return _is_shortest_burn(result) and flown == number and is_not_the_shortest(result)


def _has_a_bound_to_keep(result: SearchResult) -> bool:
    return result.setup.rate_bound is not None and result.proof is None and not _was_judged(result)


def _was_judged(result: SearchResult) -> bool:
    return result.best.standing is Standing.AS_ASKED


def _only_turns_too_fast(result: SearchResult) -> bool:
    found = result.verification
    return _has_a_bound_to_keep(result) and found is not None and not found.below_ground


def _may_wait(result: SearchResult) -> bool:
    return result.scenario.burn.ignition == "free" and not result.verified


def _may_turn_faster(result: SearchResult) -> bool:
    return result.setup.rate_bound is None and result.claim is Claim.SMOOTH_TURN


def _later(search: Search, result: SearchResult) -> Findings:
    return later_burns(result, lambda setup, start, shares: search.run(setup, from_a_law(start, shares)))


NULL_BURN = Strategy("a burn of 0 s", _is_shortest_burn, null_burn, frozenset({Claim.NOTHING_TO_BURN}))
TOO_QUICK = Strategy("the burn that turns too fast", _only_turns_too_fast, too_quick, BEST)


def _smooth(number: int, shares: tuple[float, ...] = tuning.SHORTENED) -> Strategy:
    run = partial(smooth_law, shares=shares)
    return Strategy("a law that turns smoothly", partial(_was_flown, number), run, SMOOTH)


def from_a_law(start: Start, shares: tuple[float, ...]) -> tuple[Strategy, ...]:
    """From one law that reaches the orbit, on one grid: for many neighbouring ignitions. A smooth one is shortened by `shares`."""
    return (
        Strategy(
            "a law", lambda _: True, lambda search, result: law(search, result, start, refine=False), BEST
        ),
        _smooth(1, shares),
        Strategy(
            "a turn within the bound",
            _has_a_bound_to_keep,
            partial(within_bound, refine=False),
            BEST | SMOOTH,
        ),
        TOO_QUICK,
    )


STRATEGIES = (
    NULL_BURN,
    Strategy("a later ignition", _may_wait, _later, BEST | SMOOTH),
    Strategy("thrust along the velocity", _is_open, cold_start, BEST),
    Strategy(
        "a proof of infeasibility",
        lambda result: result.verification is None,
        proof,
        frozenset({Claim.INFEASIBLE}),
    ),
    *(
        each
        for number in range(1, tuning.MOST_FLOWN + 1)
        for each in (
            Strategy(
                "a law flown onto the orbit",
                lambda result: _is_open(result) and _is_shortest_burn(result),
                next_law,
                BEST,
            ),
            _smooth(number),
        )
    ),
    Strategy(
        "constant directions",
        lambda result: _is_open(result) and not _is_shortest_burn(result),
        constant_directions,
        BEST,
    ),
    Strategy("a turn within the bound", _has_a_bound_to_keep, within_bound, BEST | SMOOTH | FAST),
    TOO_QUICK,
    Strategy("about the fastest turn", _may_turn_faster, quick_turn, FAST),
)
"""Each applies or not to what the ones before it found."""
