"""The ways to a burn as data, in the order in which they are tried."""

from __future__ import annotations

from functools import partial

from .. import tuning
from ..starts.directions import Start
from .burns import (
    cold_start,
    constant_directions,
    is_not_the_shortest,
    law,
    laws_tried,
    next_law,
    null_burn,
    proof,
    smooth_law,
)
from .ignition import later_burns
from .result import Claim, SearchResult, Standing
from .run import Findings, Search, Strategy
from .turning import quick_turn, too_quick, within_bound

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
    return later_burns(result, lambda setup, start: search.run(setup, from_a_law(start)))


NULL_BURN = Strategy("a burn of 0 s", _is_shortest_burn, null_burn, frozenset({Claim.NOTHING_TO_BURN}))
TOO_QUICK = Strategy("the burn that turns too fast", _only_turns_too_fast, too_quick, BEST)


def _smooth(number: int) -> Strategy:
    return Strategy("a law that turns smoothly", partial(_was_flown, number), smooth_law, SMOOTH)


def from_a_law(start: Start) -> tuple[Strategy, ...]:
    """From one law that reaches the orbit, on one grid: for many neighbouring ignitions."""
    return (
        Strategy(
            "a law", lambda _: True, lambda search, result: law(search, result, start, refine=False), BEST
        ),
        _smooth(1),
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
