"""The search for two burns under a bound on the attitude rate: first without it; where those burns turn too fast, within it.

What was found without the bound is drawn together until it turns slowly enough, brought back onto the orbit, and shortened by convex
problems that hold the bound. Burns of constant attitude turn not at all, so that a start is seldom missing.
"""

from __future__ import annotations

from dataclasses import dataclass

from ..search.setup import InsertionSetup
from .limits import Limits
from .motion import Motion
from .restoration import REACHED, restored
from .search import FLOWN, SHORTENED, Attempt, Found, Search, Start, flown_starts, fly_and_verify, limits_of

TURNING = "turning within the bound"


@dataclass(frozen=True, slots=True)
class BoundedSearch(Search):
    """A search whose burns turn no faster than the scenario allows."""

    def run(self, ready: InsertionSetup) -> Found:
        free = Search.run(self, ready.unbounded)
        found = Found(ready, list(free.attempts), proof=free.proof, interrupted=free.interrupted)
        if free.best is None or free.best.miss > REACHED or found.interrupted or found.proof is not None:
            found.best = free.best
            return found
        kept = fly_and_verify(ready, free.best.transfer)
        if kept is not None and kept.verified:
            found.best, found.verification = free.best, kept
            return found
        try:
            self._within(ready, found, free)
        except KeyboardInterrupt:
            found.interrupted = "interrupted in the search within the attitude rate"
        if found.best is None:
            found.best = free.best
        return found

    def _within(self, ready: InsertionSetup, found: Found, free: Found) -> None:
        """From what was found without the bound; from the starts themselves where that leads to nothing."""
        limits, motion = limits_of(ready), Motion.of(ready)
        drawn = [
            Start(each.start, restored(motion, ready.target, limits, each.transfer))
            for each in _last_of_each(free)
        ]
        self._each(ready, limits, found, drawn)
        if found.verification is None and not found.interrupted:
            self._each(ready, limits, found, flown_starts(ready, limits, FLOWN))

    def _each(self, ready: InsertionSetup, limits: Limits, found: Found, starts: list[Start]) -> None:
        for start in [each for each in starts if each.flown.reaches][:SHORTENED]:
            if not found.interrupted:
                self._shorten(ready, limits, found, Start(f"{start.name}, {TURNING}", start.flown))


def _last_of_each(free: Found) -> list[Attempt]:
    """The last attempt from each start that reaches the orbit, shortest first."""
    last = {each.start: each for each in free.attempts}
    return sorted(
        (each for each in last.values() if each.miss <= REACHED), key=lambda each: each.transfer.burning
    )
