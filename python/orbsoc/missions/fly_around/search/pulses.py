"""How many pulses: none fewer by proof, and a programme of that many by search."""

from __future__ import annotations

from bisect import bisect_left
from dataclasses import dataclass

import numpy as np

from orbsoc.guidance.scp import Solve
from orbsoc.orbit.array import Array

from ..model.flight import Flight
from ..model.margin import margin_m
from ..model.waypoints import count_in_tube
from ..scenario import Scenario
from .coasting import coasting_bound
from .fewest import COAST_SAMPLES, Bound, coast_end, even_bound, first_shares, partition
from .times import least_error
from .tube import Note, NoTube, Revolution, Tube, cheapest

HEADROOM = 0.02
"""Of the tolerance: the search for times ends where the least error is so far below it."""
MORE = 6
"""How many more pulses than the proof asks for are tried."""
COASTED = 0.7
"""Of the time in which the coast stays in the tube: where a first pulse is tried that is not at time 0."""
WITHIN_M = 1e-4
"""How far beyond its limit a programme's flight may be: `tube.CLOSE_M`, and what its rounds may leave."""
MOST_TIMES_RULE = 4
"""Beyond this multiple of the rule's number, the margin for the uncertainty is what stands in the way."""


@dataclass(frozen=True, slots=True, eq=False)
class Search:
    """What was proved and what was found, of flights within the tolerance less the margins."""

    pulses: int
    """Of the programme; of the last one tried where none was found."""
    found: Tube | None
    reason: str
    """Why there is no programme; empty where there is one."""
    margin_m: float
    """For the uncertainty."""
    room_m: float
    """For what J2 and drag add to the flight."""
    bounds: tuple[Bound, ...]
    """Proofs by number of pulses, fewest first."""
    impossible: int
    """The largest number of pulses that is proved not to do; −1 where nothing is proved."""
    impossible_below_m: float
    """With that many, the first at time 0, the error is at least this, the margin not included."""
    impossible_any_m: float
    """The same with the first pulse at any time."""
    impossible_margin_m: float
    """With that many, what the tolerance gives up to the uncertainty, J2 and drag."""

    @property
    def next_needs_m(self) -> float | None:
        """The tolerance below which that many pulses are proved not to do; None where nothing is proved."""
        return self.impossible_below_m + self.impossible_margin_m if self.impossible >= 0 else None

    @property
    def certified(self) -> bool:
        """Whether the programme has the fewest pulses by proof."""
        return self.found is not None and self.impossible == self.pulses - 1


class Searcher:
    """The bounds of a scenario by number of pulses, each made once.

    `bounds` are of flights whose first pulse is at time 0; `coasting` of those that coast before it as well.
    """

    def __init__(self, scenario: Scenario, solve: Solve, note: Note) -> None:
        self.scenario, self.solve, self.note = scenario, solve, note
        self.flight: Flight = scenario.flight
        self.start, self.end_s = scenario.start_state, scenario.duration_s
        self.rule = count_in_tube(self.flight, self.end_s, scenario.tolerance_m)
        self.bounds: dict[int, Bound] = {}
        self.coasting: dict[int, float] = {}
        self.room_m = 0.0
        """What the tolerance gives up to J2 and drag."""
        self._margins: dict[int, float] = {}

    def bound(self, pulses: int) -> Bound:
        """The even bound of a number of pulses ≥ 1."""
        if pulses not in self.bounds:
            self.bounds[pulses] = even_bound(
                self.flight, self.start[:3], self.end_s, pulses, solve=self.solve, note=self.note
            )
        return self.bounds[pulses]

    def least_any_m(self, pulses: int) -> float:
        """No flight with as many pulses at any times strays less.

        One that strays less than `least_m` = B coasts at most until the coast strays B, and its arcs hold the rest.
        """
        least = self.least_m(pulses)
        if pulses and pulses not in self.coasting:
            left = coast_end(self.flight, self.start, self.end_s, least)
            if left >= self.end_s:
                return 0.0
            rest = even_bound(
                self.flight, None, self.end_s, pulses, solve=self.solve, from_s=left, note=self.note
            )
            bound = float(np.minimum(least, rest.bound_m))  # NaN where a solve failed
            if not bound > self.limit(pulses):
                bound = coasting_bound(
                    self.flight, self.start, self.end_s, pulses, left, least, solve=self.solve
                )
            self.coasting[pulses] = bound
        return self.coasting[pulses] if pulses else least

    def refuted(self, pulses: int) -> bool:
        """Whether a number of pulses is proved too few, whenever the first one is."""
        limit = self.limit(max(pulses, 1))
        return self.least_m(pulses) > limit and self.least_any_m(pulses) > limit

    def least_m(self, pulses: int) -> float:
        """No flight with as many pulses, one at time 0, strays less; without any, it is the coast from the start."""
        if pulses == 0:
            states = self.flight.arc(self.start, self.end_s, COAST_SAMPLES)
            path = self.flight.ellipse.position(np.linspace(0.0, self.end_s, COAST_SAMPLES + 1))
            return float(np.linalg.norm(states[:, :3] - path, axis=1).max())
        return self.bound(pulses).bound_m

    def margin(self, pulses: int) -> float:
        """What the tolerance gives up to the scenario's uncertainty, with so long arcs."""
        uncertainty = self.scenario.uncertainty
        if uncertainty is None:
            return 0.0
        if pulses not in self._margins:
            times = partition(self.flight, self.end_s, first_shares(pulses))
            self._margins[pulses] = margin_m(self.flight, times, uncertainty)
        return self._margins[pulses]

    def limit(self, pulses: int) -> float:
        """The tolerance less the margin and the room."""
        return self.scenario.tolerance_m - self.margin(pulses) - self.room_m

    def possible(self, pulses: int) -> bool:
        """Whether nothing proves a number of pulses ≥ 1 too few."""
        return self.limit(pulses) > 0.0 and not self.refuted(pulses)

    def plausible(self, pulses: int) -> bool:
        """Whether a number of pulses is enough by the rule: errors go with the inverse of its square."""
        return self.limit(pulses) >= self.scenario.tolerance_m * (self.rule / pulses) ** 2

    def times(self, pulses: int) -> Array:
        """Where the search for times begins: the partition of the bound, or for more pulses than the rule's, of the rule."""
        if pulses in self.bounds or pulses <= self.rule:
            return self.bound(pulses).times_s[:-1]
        return partition(self.flight, self.end_s, first_shares(pulses))[:-1]

    def programme(self, pulses: int) -> Tube | NoTube:
        """The cheapest programme found with a number of pulses, on times of least error; its error may be too large.

        The first is at time 0, or, where that strays too far, after a coast.
        """
        found = self._programme(self.times(pulses), self.limit(pulses), coast=False)
        if self.within(pulses, found):
            return found
        left = coast_end(self.flight, self.start, self.end_s, self.limit(pulses))
        times = partition(self.flight, self.end_s, np.ones(pulses), COASTED * left)[:-1]
        later = self._programme(np.append(0.0, times), self.limit(pulses), coast=True)
        return later if self.within(pulses, later) else found

    def _programme(self, times_s: Array, limit: float, *, coast: bool) -> Tube | NoTube:
        whole = Revolution(self.flight, self.start, self.end_s, self.solve, self.note, coast=coast)
        near = least_error(whole, times_s, (1.0 - HEADROOM) * limit)
        if isinstance(near, NoTube) or near.error_m > limit:
            return near
        return cheapest(whole, near.programme.times_s, limit)

    def within(self, pulses: int, found: Tube | NoTube) -> bool:
        """Whether a programme is within its limit."""
        return isinstance(found, Tube) and found.error_m <= self.limit(pulses) + WITHIN_M


def search(searcher: Searcher, pulses: int | None) -> Search:
    """The fewest pulses, or a given number of them."""
    first = _first(searcher) if pulses is None else pulses
    if searcher.limit(first) <= 0.0:
        used = searcher.margin(first)
        takes = f"the margin for the uncertainty with {first} pulses, {used:.3f} m, takes all of tolerance_m"
        return _finished(searcher, first, None, takes)
    if first <= searcher.rule and not searcher.possible(first):
        return _finished(searcher, first, None, "")
    reason = ""
    tried = first
    for tried in range(first, first + (MORE if pulses is None else 1)):
        found = searcher.programme(tried)
        if isinstance(found, Tube) and searcher.within(tried, found):
            return _finished(searcher, tried, found, "")
        nearest = "" if isinstance(found, NoTube) else f"the least error found is {found.error_m:.4f} m"
        reason = found.reason if isinstance(found, NoTube) else nearest
    searcher.possible(tried)  # which may be a proof
    return _finished(searcher, tried, None, reason)


def _first(searcher: Searcher) -> int:
    """The least number of pulses that nothing proves too few, or one that the margin does not even allow."""
    most = MOST_TIMES_RULE * searcher.rule + MORE
    guess = bisect_left(range(searcher.rule, most), True, key=searcher.plausible) + searcher.rule
    if not searcher.limit(guess) > 0.0:
        return guess
    while not searcher.possible(guess):
        guess += 1
        if guess > most:
            return guess
    while guess > 1 and searcher.possible(guess - 1):
        guess -= 1
    return guess


def _finished(searcher: Searcher, pulses: int, found: Tube | None, reason: str) -> Search:
    """With the most that was proved: of the largest number of pulses whose bound is above the tolerance."""
    tried = sorted({0, *searcher.bounds}, reverse=True)
    most = next((count for count in tried if searcher.refuted(count)), -1)
    below = (searcher.least_m(most), searcher.least_any_m(most)) if most >= 0 else (0.0, 0.0)
    given_up = (searcher.margin(most) if most > 0 else 0.0) + searcher.room_m
    bounds = tuple(searcher.bounds[count] for count in sorted(searcher.bounds))
    margins = searcher.margin(pulses), searcher.room_m
    return Search(pulses, found, reason, *margins, bounds, most, *below, given_up)
