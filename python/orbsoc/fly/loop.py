"""One flight: the vehicle moves while the computer computes, and an answer is flown only when its computation has ended.

Guidance begins at its triggers, from what navigation says then, and plans to take over after an allowance. An answer that is there in
time takes over at the end of the allowance; a later one flies late; one that misses its window is not flown, and the last programme
flies on. A trigger that finds the computer busy is passed over, unless it is urgent: then the computation is given up.
"""

from __future__ import annotations

import enum
from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import inf

import numpy as np

from orbsoc.guidance.closed_loop import Answer, ClosedLoop, Programme, Trigger, Vehicle

from .computer import NOTHING, Computer, Price
from .solver import OnboardSolver


class Fate(enum.Enum):
    """What became of a trigger."""

    FLOWN = "flown"
    LATE = "flown late"
    MISSED = "missed its window"
    BUSY = "passed over: the computer was busy"
    GIVEN_UP = "given up for an urgent one"
    NO_ANSWER = "no answer"
    TOO_LATE = "there when the burn was over"

    @property
    def is_flown(self) -> bool:
        """Whether its answer took over."""
        return self in (Fate.FLOWN, Fate.LATE)

    @property
    def is_lost(self) -> bool:
        """Whether the computer was too slow for it."""
        return self in (Fate.MISSED, Fate.BUSY, Fate.TOO_LATE)


@dataclass(frozen=True, slots=True, eq=False)
class CycleRecord:
    """One trigger: its answer and price, None and nothing where the computer was busy, and from when on it was flown."""

    trigger: Trigger
    fate: Fate
    answer: Answer | None = None
    price: Price = NOTHING
    solves: int = 0
    iterations: int = 0
    counted: bool = False
    """Whether what guidance does around all of its solves was counted, and is in the price."""
    flown_s: float = inf

    @property
    def ready_s(self) -> float:
        """When its computation has ended."""
        return self.trigger.at_s + self.price.time_s


@dataclass(frozen=True, slots=True, eq=False)
class Flight:
    """A flight to its end: every trigger in order, the programmes that were flown, each from its time on, and the end."""

    seed: int
    number: int
    cycles: tuple[CycleRecord, ...]
    programmes: tuple[tuple[float, Programme], ...]
    vehicle: Vehicle
    outcome: Mapping[str, float]

    @property
    def answers(self) -> tuple[tuple[Trigger, Answer, bool], ...]:
        """Of every trigger that was answered."""
        return tuple((c.trigger, c.answer, c.fate.is_flown) for c in self.cycles if c.answer is not None)

    @property
    def replans(self) -> int:
        """Answers that were flown."""
        return sum(each.fate.is_flown for each in self.cycles)

    @property
    def lost(self) -> int:
        """Triggers for which the computer was too slow."""
        return sum(each.fate.is_lost for each in self.cycles)

    @property
    def longest_s(self) -> float:
        """Of the computations."""
        return max((each.price.time_s for each in self.cycles), default=0.0)


@dataclass(frozen=True, slots=True)
class Timing:
    """What time an answer has: the allowance that it is planned for, and the window; None: as long as the loop's period, and for
    an urgent one without end."""

    allowance_s: float
    window_s: float | None = None

    def window_of(self, trigger: Trigger, period_s: float) -> float:
        """How long after its trigger an answer may come."""
        if self.window_s is not None:
            return self.window_s
        return inf if trigger.urgent else period_s


def fly(
    loop: ClosedLoop,
    computer: Computer | None,
    solver: OnboardSolver,
    timing: Timing,
    *,
    seed: int = 0,
    number: int = 0,
) -> Flight:
    """Fly once; without a computer nothing is planned again. Depends on loop, timing, seed, number and the computer alone.

    Raises KeyboardInterrupt where a solve was interrupted, and what the computer raises.
    """
    return _Run(loop, computer, solver, timing, seed, number).to_the_end()


class _Run:
    def __init__(
        self,
        loop: ClosedLoop,
        computer: Computer | None,
        solver: OnboardSolver,
        timing: Timing,
        seed: int,
        number: int,
    ) -> None:
        self.loop, self.computer, self.solver, self.timing = loop, computer, solver, timing
        self.seed, self.number = seed, number
        self.vehicle = loop.vehicle(seed, number)
        self.flying = loop.first
        self.programmes: list[tuple[float, Programme]] = [(0.0, loop.first)]
        self.cycles: list[CycleRecord] = []
        self.busy_s = -inf
        self.pending: CycleRecord | None = None

    def to_the_end(self) -> Flight:
        last: Trigger | None = None
        while True:
            trigger = None if self.computer is None else self.loop.next_trigger(last, self.flying)
            begins_s = inf if trigger is None else trigger.at_s
            takes_s = inf if self.pending is None else self.pending.flown_s
            end_s = self.flying.end_s
            now_s = max(self.vehicle.time_s, min(begins_s, takes_s, end_s))
            self.vehicle.advance(self.flying, now_s)
            if takes_s <= now_s:
                self._take_over()
            elif trigger is not None and begins_s <= now_s:
                self._begin(trigger)
                last = trigger
            else:
                break
        if self.pending is not None:
            self._settle(Fate.TOO_LATE)
        outcome = self.loop.outcome(self.vehicle, self.flying)
        cycles = tuple(sorted(self.cycles, key=lambda each: each.trigger.number))
        return Flight(self.seed, self.number, cycles, tuple(self.programmes), self.vehicle, outcome)

    def _begin(self, trigger: Trigger) -> None:
        """A computation, unless the computer is at one that is not to be given up."""
        assert self.computer is not None
        if trigger.at_s < self.busy_s:
            if not trigger.urgent:
                self.cycles.append(CycleRecord(trigger, Fate.BUSY))
                return
            if self.pending is not None:
                self._settle(Fate.GIVEN_UP)
        self.solver.begin()
        sensed = self.vehicle.sense(np.random.default_rng([self.seed, self.number, trigger.number]))
        answer = self.loop.answer(trigger, sensed, self.flying, self.solver, self.timing.allowance_s)
        ran = self.solver.ran
        around = answer.around
        price = self.computer.price(ran, self.solver, around)
        ready_s = trigger.at_s + price.time_s
        self.busy_s = ready_s
        fate = Fate.FLOWN if ready_s <= answer.from_s else Fate.LATE
        if price.time_s > self.timing.window_of(trigger, self.loop.period_s):
            fate = Fate.MISSED
        elif answer.programme is None:
            fate = Fate.NO_ANSWER
        flown_s = max(answer.from_s, ready_s)
        iterations = sum(each.iterations for each in ran)
        counted = around is not None and around.solves == len(ran)
        record = CycleRecord(trigger, fate, answer, price, len(ran), iterations, counted, flown_s)
        if not fate.is_flown:
            self.cycles.append(_without_flight(record, fate))
            return
        if self.pending is not None:
            self._settle(Fate.GIVEN_UP)
        self.pending = record

    def _take_over(self) -> None:
        record = self.pending
        assert record is not None
        assert record.answer is not None
        assert record.answer.programme is not None
        if record.answer.programme.end_s <= self.vehicle.time_s:
            self._settle(Fate.TOO_LATE)
            return
        self.pending = None
        self.flying = record.answer.programme
        self.programmes.append((self.vehicle.time_s, self.flying))
        self.cycles.append(record)

    def _settle(self, fate: Fate) -> None:
        """The pending answer is not flown."""
        assert self.pending is not None
        self.cycles.append(_without_flight(self.pending, fate))
        self.pending = None


def _without_flight(record: CycleRecord, fate: Fate) -> CycleRecord:
    return replace(record, fate=fate, flown_s=inf)
