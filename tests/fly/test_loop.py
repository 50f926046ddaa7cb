"""When an answer is flown: after its computation, late if that is late, and never once its window has closed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pytest

from orbsoc.fly.computer import Price
from orbsoc.fly.loop import Fate, Flight, Timing, fly
from orbsoc.guidance.closed_loop import Answer, FlownCycles, Sensed, Trigger
from orbsoc.guidance.verdict import VerdictLine


@dataclass(frozen=True)
class Plan:
    name: str
    end_s: float


@dataclass
class Cart:
    """Remembers what it followed, and from when to when."""

    time_s: float = 0.0
    followed: list[tuple[str, float, float]] = field(default_factory=list)

    def advance(self, programme: Plan, until_s: float) -> None:
        if until_s > self.time_s:
            self.followed.append((programme.name, self.time_s, until_s))
        self.time_s = until_s

    def sense(self, random: np.random.Generator) -> Sensed:
        return Sensed(self.time_s, None)


@dataclass
class Track:
    """Plans at fixed times, each an answer of its own name that ends at 10 s."""

    times_s: Sequence[float]
    urgent_s: float = np.inf
    first: Plan = Plan("first", 10.0)
    period_s: float = 2.0
    columns: Mapping[str, str] = field(default_factory=dict)

    def vehicle(self, seed: int, number: int) -> Cart:
        return Cart()

    def next_trigger(self, last: Trigger | None, programme: Plan) -> Trigger | None:
        number = 0 if last is None else last.number
        if number >= len(self.times_s):
            return None
        at = self.times_s[number]
        return Trigger(number + 1, at, "period", urgent=at == self.urgent_s)

    def answer(
        self, trigger: Trigger, sensed: Sensed, programme: Plan, solve: Any, allowance_s: float
    ) -> Answer:
        return Answer(Plan(f"plan {trigger.number}", 10.0), sensed.at_s + allowance_s, "planned")

    def outcome(self, vehicle: Cart, programme: Plan) -> Mapping[str, float]:
        return {"time_s": vehicle.time_s}

    def verdict(self, flown: FlownCycles) -> Sequence[VerdictLine]:
        return ()


class Clock:
    """A computer that takes given times, one after the other."""

    def __init__(self, *took_s: float) -> None:
        self.took = list(took_s)

    def price(self, _ran: object, _solver: object, _around: object = None) -> Price:
        return Price(self.took.pop(0), 1)


class NoSolver:
    ran: tuple[Any, ...] = ()

    def begin(self) -> None:
        pass


def flown(track: Track, timing: Timing, *took_s: float) -> Flight:
    return fly(track, Clock(*took_s), NoSolver(), timing)  # type: ignore[arg-type]


def fates(flight: Flight) -> list[Fate]:
    return [each.fate for each in flight.cycles]


def test_an_answer_in_time_takes_over_when_its_allowance_is_over() -> None:
    flight = flown(Track([2.0]), Timing(0.5), 0.3)
    assert flight.vehicle.followed == [("first", 0.0, 2.0), ("first", 2.0, 2.5), ("plan 1", 2.5, 10.0)]
    assert fates(flight) == [Fate.FLOWN]


def test_a_late_answer_flies_late() -> None:
    flight = flown(Track([2.0]), Timing(0.5), 1.5)
    assert flight.programmes[1] == (3.5, Plan("plan 1", 10.0))
    assert fates(flight) == [Fate.LATE]


@pytest.mark.parametrize(("took_s", "fate"), [(1.0, Fate.LATE), (1.0 + 1e-9, Fate.MISSED)])
def test_beyond_its_window_the_last_programme_flies_on(took_s: float, fate: Fate) -> None:
    flight = flown(Track([2.0]), Timing(0.5, 1.0), took_s)
    assert fates(flight) == [fate]
    assert len(flight.programmes) == 1 + fate.is_flown
    assert flight.lost == (fate is Fate.MISSED)


def test_the_window_of_a_period_is_its_length_and_a_busy_computer_passes_a_trigger_over() -> None:
    flight = flown(Track([2.0, 4.0, 6.0]), Timing(0.5), 2.5, 0.1)
    assert fates(flight) == [Fate.MISSED, Fate.BUSY, Fate.FLOWN]


def test_an_urgent_trigger_ends_the_computation_that_is_going_on_and_has_no_window() -> None:
    flight = flown(Track([2.0, 3.0], urgent_s=3.0), Timing(0.0), 1.9, 4.0)
    assert fates(flight) == [Fate.GIVEN_UP, Fate.LATE]
    assert flight.programmes[-1][0] == 7.0


def test_an_answer_is_of_no_use_once_the_burn_is_over() -> None:
    flight = flown(Track([9.0], urgent_s=9.0), Timing(0.0), 3.0)
    assert fates(flight) == [Fate.TOO_LATE]
    assert flight.vehicle.time_s == 10.0


def test_without_a_computer_nothing_is_planned_again() -> None:
    flight = fly(Track([2.0, 4.0]), None, NoSolver(), Timing(0.0))  # type: ignore[arg-type]
    assert flight.cycles == ()
    assert flight.vehicle.followed == [("first", 0.0, 10.0)]
