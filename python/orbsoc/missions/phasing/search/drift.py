"""Weeks of drift: the number of revolutions, the dates of departure and arrival, and the impulses, in mean elements.

For each number of revolutions the impulses are descended to by cones, from a spread of small ones. The multipliers of the end
say what other dates would save, to first order, and the dates move there. The cheapest is what the true motion starts from.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import ceil, floor, tau

import numpy as np

from orbsoc.guidance.scp import ExitReason, Solve, TrustRules
from orbsoc.orbit.array import Array

from ..model.approach import states_at
from ..model.mean_approach import MeanApproach, onward
from ..model.mean_motion import RADIUS_M, mean_elements, secular_rates, wrapped
from ..scenario import Scenario
from .descent import Descended, PhasingImpulses, descend

A_TURN = 12
"""Instants a revolution."""
WHOLE = 3
"""Revolutions at each end that have all their instants, and of those between one in `EVERY_TURN`."""
EVERY_TURN = 40
DATES_A_TURN = 60
"""Dates that are tried, a revolution."""
SHORT_TURNS = 60
"""Fewer revolutions than that depend on how long they take: earlier and later dates are starts of their own."""
WORTH = 1.08
"""Of the cheapest: what costs more is not looked at again with other dates."""
DEARER = 2
"""Numbers of revolutions in a row that cost more than the best of their side, after which that side is left."""
MOVED = 6
"""Of the cheapest transfers: those whose dates are moved in a round."""
AGAIN = 3
"""Transfers after the cheapest, for where the true motion has no flight near that one."""
MARGIN_KM = 10.0
"""Within the limits, which are of osculating orbits: J2 takes their perigees that far from the mean ones."""
RULES = TrustRules(radius=1e3, least_gain=1e-4, max_iterations=12)
FINE_RULES = TrustRules(radius=1e3, least_gain=1e-6, max_iterations=20)
FINE_DEG = np.arange(-15.0, 15.1, 2.5)
"""About each impulse, where the last descent in mean elements may place it."""


@dataclass(frozen=True, slots=True, eq=False)
class Transfer:
    """What was found in mean elements: dates, revolutions, and impulses (N, 3), m/s, inertial, at times (N,)."""

    start_s: float
    end_s: float
    revolutions: int
    mean_cost_m_s: float
    tried: int
    """Descents in mean elements."""
    times_s: Array
    dv_m_s: Array


@dataclass(frozen=True, slots=True, eq=False)
class Dates:
    """Times (M,) at which a body may be left or met, and the mean elements (M, 6) that a coast from there has."""

    times_s: Array
    elements: Array

    def at_longitude(self, longitude: float, zero_s: float) -> Array:
        """Elements (M, 6) of coasts from all dates at a longitude; the last is the time after `zero_s`."""
        timed = self.elements.copy()
        timed[:, 5] = self.times_s - zero_s
        return onward(timed, longitude - self.elements[:, 5])


@dataclass(frozen=True, slots=True, eq=False)
class Try:
    """A descent in mean elements between two of the dates."""

    begin: int
    end: int
    turns: int
    descended: Descended
    outside: bool
    """Whether an orbit between its impulses leaves the scenario's limits."""

    @property
    def cost_m_s(self) -> float:
        return self.descended.roll.cost_m_s


class DriftSearch:
    """Of the transfers that the window allows the cheapest in mean elements."""

    def __init__(self, scenario: Scenario, solve: Solve) -> None:
        self.scenario, self.solve = scenario, solve
        self.starts, self.ends = (_dates(scenario, name) for name in ("chaser", "target"))
        self.tries: dict[tuple[int, int, int], Try | None] = {}

    def find(self) -> Iterator[Transfer]:
        """The cheapest, and at most `AGAIN` after it where that is asked for; none where no number of revolutions has a flight."""
        nominal = len(self.starts.times_s) // 2, len(self.ends.times_s) // 2
        places = [nominal]
        if self._advance(*nominal) < tau * SHORT_TURNS and nominal[0]:
            early, late = nominal[0] // 8, len(self.ends.times_s) - 1 - nominal[1] // 8
            places += [(early, late), (early, nominal[1]), (nominal[0], late)]
        for begin, end in places:
            self._scan(begin, end)
        while True:
            found = sorted(filter(None, self.tries.values()), key=lambda each: (each.outside, each.cost_m_s))
            if not found:
                return
            found = [each for each in found if each.outside == found[0].outside]
            moved = [self._moved(each) for each in found if each.cost_m_s < WORTH * found[0].cost_m_s][:MOVED]
            if not any(moved):
                yield from (self._transfer(self._fine(each)) for each in found[: 1 + AGAIN])
                return

    def _advance(self, begin: int, end: int) -> float:
        """Of the chaser's longitude if it coasted."""
        took = self.ends.times_s[end] - self.starts.times_s[begin]
        return float(secular_rates(self.starts.elements[begin]).sum() * took)

    def _scan(self, begin: int, end: int) -> None:
        """All numbers of revolutions between those of chaser and target, and beyond while they cost less."""
        took = self.ends.times_s[end] - self.starts.times_s[begin]
        if took <= 0.0:
            return
        first = self._first(begin, end)
        turns = sorted(
            (float(secular_rates(each).sum()) * took - first) / tau
            for each in (self.starts.elements[begin], self.ends.elements[end])
        )
        low, high = max(floor(turns[0]), 0), ceil(turns[1])
        for number in range(low, high + 1):
            self._try(begin, end, number)
        for number, step in ((low - 1, -1), (high + 1, 1)):
            best, since = float("inf"), 0
            while number >= 0 and since < DEARER:
                found = self._try(begin, end, number)
                cost = float("inf") if found is None else found.cost_m_s
                best, since = (cost, 0) if cost < best else (best, since + 1)
                if cost > 1.5 * self._least():
                    break
                number += step

    def _least(self) -> float:
        return min((each.cost_m_s for each in self.tries.values() if each), default=float("inf"))

    def _first(self, begin: int, end: int) -> float:
        """The longitude from start to end without its whole turns."""
        return float((self.ends.elements[end, 5] - self.starts.elements[begin, 5]) % tau)

    def _try(self, begin: int, end: int, turns: int) -> Try | None:
        if (begin, end, turns) not in self.tries:
            total = self._first(begin, end) + tau * turns
            self.tries[begin, end, turns] = self._descended(begin, end, turns, _instants(total), None)
        return self.tries[begin, end, turns]

    def _descended(
        self, begin: int, end: int, turns: int, at: Array, start: Array | None, rules: TrustRules = RULES
    ) -> Try | None:
        """From impulses (K, 3) at the instants, or from small ones in the first and the last revolution."""
        approach = self._approach(begin, end, at)
        if start is None:
            few = np.unique([*range(0, A_TURN, 3), *(at.size - 1 - np.arange(0, A_TURN, 3))])
            few = few[(few >= 0) & (few < at.size)]
            least = self._approach(begin, end, at[few]).restore(np.zeros((few.size, 3)), least_m_s=1.0)
            if least is None:
                return None
            start = np.zeros((at.size, 3))
            start[few] = least.dv_m_s
        roll = approach.restore(start)
        if roll is None:
            return None
        found = descend(approach, roll, solve=self.solve, rules=rules)
        if found.outcome.reason is ExitReason.INTERRUPTED:
            raise KeyboardInterrupt
        return Try(begin, end, turns, found, self._outside(approach, found.roll.dv_m_s))

    def _outside(self, approach: MeanApproach, dv_m_s: Array) -> bool:
        limits, after = self.scenario.limits, approach.between(dv_m_s)
        ecc = np.hypot(after[:, 1], after[:, 2])
        low, high = (1e-3 * (after[:, 0] * (1.0 + sign * ecc) - RADIUS_M) for sign in (-1.0, 1.0))
        return bool(
            np.any(low < limits.perigee_height_km + MARGIN_KM)
            or np.any(high > limits.apogee_height_km - MARGIN_KM)
        )

    def _approach(self, begin: int, end: int, at: Array) -> MeanApproach:
        zero_s = float(self.starts.times_s[begin])
        first, last = self.starts.elements[begin].copy(), self.ends.elements[end].copy()
        longitude, first[5], last[5] = first[5], 0.0, self.ends.times_s[end] - zero_s
        times = at / float(secular_rates(first).sum())
        return MeanApproach(self.scenario, times, first, last, True, longitude + at)

    def _moved(self, found: Try) -> bool:
        """Try what the multipliers say of other dates; whether that was new and cheaper."""
        approach, roll, last = found.descended.approach, found.descended.roll, found.descended.last
        assert isinstance(approach, MeanApproach)
        assert isinstance(last.impulses, PhasingImpulses)
        if not last.rounds:
            return False
        pull = last.impulses.pull(last.solution)
        zero_s = float(self.starts.times_s[found.begin])
        starts = self.starts.at_longitude(float(approach.longitudes[0]), zero_s) - approach.start
        ends_at = float(self.ends.elements[found.end, 5])
        ends = self.ends.at_longitude(ends_at, zero_s) - approach.goal
        by_start = approach.by_start(roll.dv_m_s)
        begin = int(np.argmin(-(starts @ by_start.T) @ pull))
        end = int(np.argmin((ends * approach.lengths) @ pull))
        moved = (self.starts.elements[begin, 5] - self.starts.elements[found.begin, 5],
                 self.ends.elements[end, 5] - self.ends.elements[found.end, 5])  # fmt: skip
        total = float(approach.longitudes[-1] - approach.longitudes[0]) + moved[1] - moved[0]
        turns = round((total - self._first(begin, end)) / tau)
        if turns < 0 or (begin, end, turns) in self.tries:
            return False
        again = self._try(begin, end, turns)
        return again is not None and again.cost_m_s < found.cost_m_s - 1e-3

    def _fine(self, found: Try) -> Try:
        """With instants closer about the impulses."""
        approach, roll = found.descended.approach, found.descended.roll
        assert isinstance(approach, MeanApproach)
        old = approach.longitudes - approach.longitudes[0]
        fired = np.flatnonzero(np.any(roll.dv_m_s, axis=1))
        near = (old[fired][:, None] + np.deg2rad(FINE_DEG)).ravel()
        at = np.unique(np.concatenate([old, near[(near > 0.0) & (near < old[-1])]]))
        at = at[np.append(np.diff(at) > 1e-3, True)]
        start = np.zeros((at.size, 3))
        for k in fired:
            start[int(np.argmin(abs(at - old[k])))] += roll.dv_m_s[k]
        again = self._descended(found.begin, found.end, found.turns, at, start, FINE_RULES)
        better = again is not None and (again.outside, again.cost_m_s) < (found.outside, found.cost_m_s)
        return again if again is not None and better else found

    def _transfer(self, found: Try) -> Transfer:
        approach, roll = found.descended.approach, found.descended.roll
        assert isinstance(approach, MeanApproach)
        times, dv = approach.flown(roll.dv_m_s)
        begin_s, end_s = float(self.starts.times_s[found.begin]), float(self.ends.times_s[found.end])
        times = np.clip(begin_s + times, begin_s, end_s)
        return Transfer(begin_s, end_s, found.turns, found.cost_m_s, len(self.tries), times, dv)


def _instants(total: float) -> Array:
    """Longitudes after the start, the end's the last."""
    turns = ceil(total / tau)
    kept = [n for n in range(turns) if n < WHOLE or n >= turns - WHOLE or n % EVERY_TURN == 0]
    found = np.concatenate([tau * (n + np.arange(A_TURN) / A_TURN) for n in kept])
    return np.append(found[found < total - 0.1], total)


def _dates(scenario: Scenario, name: str) -> Dates:
    """About the nominal date, which is the middle one."""
    window = scenario.window
    middle = window.start_s if name == "chaser" else window.end_s
    assert middle is not None
    body = scenario.chaser if name == "chaser" else scenario.target
    half = 3600.0 * window.dates_h
    if name == "chaser" and body.motion == "osculating":  # it coasts: when it starts to says nothing
        half = 0.0
    count = ceil(half / body.elements.period_s() * DATES_A_TURN)
    times = middle + half * np.linspace(-1.0, 1.0, 2 * count + 1) if count else np.array([middle])
    elements = mean_elements(states_at(scenario, name, times), scenario.forces_on(0.0))
    rate = float(secular_rates(elements).sum(axis=-1).mean())
    expected = elements[count, 5] + rate * (times - middle)
    elements[:, 5] = expected + wrapped(elements[:, 5] - expected)
    return Dates(times, elements)
