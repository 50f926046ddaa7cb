"""A mission in flight, as the guidance loop of `orbsoc fly` sees it: a vehicle, programmes that it follows, and a guidance that
answers when it is asked.

The loop owns time: when a computation begins, when it has ended, and from when on its answer is flown. A mission owns the motion,
the navigation and the plan. Times are seconds from the scenario's state.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np

from .outer_loop import OuterLoop
from .scp import Solve
from .verdict import VerdictLine


class Programme(Protocol):
    """What the vehicle does until another programme takes over."""

    @property
    def end_s(self) -> float:
        """When there is nothing left to do."""
        ...


@dataclass(frozen=True, slots=True)
class Trigger:
    """Why guidance plans anew, and when it begins to; `number` counts from 1 in the order of time."""

    number: int
    at_s: float
    cause: str
    urgent: bool = False
    """Whether it stops a computation that is going on: its answer would be of another vehicle."""


PERIOD = "period"
"""The cause of a trigger that comes at its time."""


@dataclass(frozen=True, slots=True, eq=False)
class Answer:
    """What guidance came to: a programme that begins at `from_s` by its own account, or None with the reason in `words`."""

    programme: Programme | None
    from_s: float
    words: str
    figures: Mapping[str, float] = field(default_factory=dict)
    decisions: tuple[Decision, ...] = ()
    """What was tried on the way to it, in order; empty where there was one thing to try."""
    around: OuterLoop | None = None
    """What was counted around its first solves; of further ones, and without it of all, each problem's generation is assumed."""


@dataclass(frozen=True, slots=True)
class Decision:
    """One branch of a decision: what was sought, what became of it, and how many conic problems were solved for it."""

    sought: str
    found: str
    word: str
    solves: int


@dataclass(frozen=True, slots=True)
class Sensed:
    """What navigation hands to guidance: the time, and the estimate in the mission's own form."""

    at_s: float
    estimate: Any


class Vehicle(Protocol):
    """The vehicle as it really is: its state, its engine, the forces on it."""

    @property
    def time_s(self) -> float: ...

    def advance(self, programme: Programme, until_s: float) -> None:
        """Let it follow a programme until a time."""
        ...

    def sense(self, random: np.random.Generator) -> Sensed:
        """What navigation makes of it now."""
        ...


class ClosedLoop(Protocol):
    """A scenario ready to be flown any number of times. Every flight depends on its seed and number alone."""

    @property
    def first(self) -> Programme:
        """What was planned on the ground."""
        ...

    @property
    def period_s(self) -> float:
        """Of the guidance cycle: an answer to one of its triggers is due before the next one."""
        ...

    @property
    def allowance_s(self) -> float:
        """How long after its trigger an answer is to take over."""
        ...

    @property
    def columns(self) -> Mapping[str, str]:
        """The figures of `outcome` in order, with their units."""
        ...

    @property
    def shown(self) -> Sequence[tuple[str, str]]:
        """Two of them, with their labels, that show where flights end."""
        ...

    def vehicle(self, seed: int, number: int) -> Vehicle:
        """The vehicle of a flight at time 0; that of flight 0 has no error that is drawn once."""
        ...

    def next_trigger(self, last: Trigger | None, programme: Programme) -> Trigger | None:
        """The first trigger after another one, None for the first of all; None where none is left under a programme."""
        ...

    def answer(
        self, trigger: Trigger, sensed: Sensed, programme: Programme, solve: Solve, allowance_s: float
    ) -> Answer:
        """Plan anew, to take over `allowance_s` after the trigger. Depends on its arguments alone."""
        ...

    def outcome(self, vehicle: Vehicle, programme: Programme) -> Mapping[str, float]:
        """The end of a flight in figures, `columns`; `ON_TARGET` is 1 where what was asked for was reached."""
        ...

    def verdict(self, flown: FlownCycles) -> Sequence[VerdictLine]:
        """The mission's own lines about one flight, *Answer* first."""
        ...


ON_TARGET = "on_target"
"""1 of a flight that ended as asked for, else 0."""


class FlownCycles(Protocol):
    """What a verdict may ask of a flight."""

    @property
    def outcome(self) -> Mapping[str, float]: ...

    @property
    def answers(self) -> Sequence[tuple[Trigger, Answer, bool]]:
        """Of every trigger that was answered: the answer, and whether it was flown."""
        ...
