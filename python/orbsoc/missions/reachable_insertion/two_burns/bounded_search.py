"""The search for two burns under a bound on the attitude rate: first without it; where those burns turn too fast, within it.

What was found without the bound is drawn together until it turns slowly enough, brought back onto the orbit, and shortened by convex
problems that hold the bound. Burns of constant attitude turn not at all, so that a start is seldom missing.
"""

from __future__ import annotations

from dataclasses import dataclass

from ..made_ready import MadeReady
from .motion import Motion
from .restoration import REACHED, restored
from .search import FLOWN, SHORTENED, Attempt, Found, Search, Start, flown_starts, judged, limits_of

TURNING = "turning within the bound"


@dataclass(frozen=True, slots=True)
class BoundedSearch(Search):
    """A search whose burns turn no faster than the scenario allows."""

    def run(self, ready: MadeReady) -> Found:
        free = Search.run(self, ready.unbounded)
        found = Found(ready, list(free.attempts), proof=free.proof, interrupted=free.interrupted)
        if free.best is None or free.best.miss > REACHED or found.interrupted or found.proof is not None:
            found.best = free.best
            return found
        kept = judged(ready, free.best.transfer)
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

    def _within(self, ready: MadeReady, found: Found, free: Found) -> None:
        """From what was found without the bound; from the starts themselves where that leads to nothing."""
        limits, motion = limits_of(ready), Motion.of(ready)
        for attempt in _last_of_each(free)[:SHORTENED]:
            flown = restored(motion, ready.target, limits, attempt.transfer)
            if flown.reaches and not found.interrupted:
                self._shorten(ready, limits, found, Start(f"{attempt.start}, {TURNING}", flown))
        if found.verification is not None or found.interrupted:
            return
        for start in flown_starts(ready, limits, FLOWN):
            if start.flown.reaches:
                self._shorten(ready, limits, found, Start(f"{start.name}, {TURNING}", start.flown))
            if found.verification is not None or found.interrupted:
                return


def _last_of_each(free: Found) -> list[Attempt]:
    """The last attempt from each start that reaches the orbit, shortest first."""
    last = {each.start: each for each in free.attempts}
    return sorted(
        (each for each in last.values() if each.miss <= REACHED), key=lambda each: each.transfer.burning
    )
