"""A chaser that fires impulses, as it is: about the Earth with J2 beside its target, with errors of navigation and of its engine.

What the closed loops of rendezvous missions share. Guidance plans again a lead before each impulse, for the state in which navigation
sees the chaser then; an answer that is not there at the impulse's time has missed its window, and the impulse planned last is fired.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from orbsoc.orbit import EARTH
from orbsoc.orbit.array import Array
from orbsoc.orbit.perturbations import J2, Force, PointMass, fast_coast
from orbsoc.orbit.relative import absolute_state, relative_state

from .closed_loop import Sensed, Trigger
from .impulses import ImpulseProgramme
from .setting_out import Lead
from .uncertainty import Uncertainty

FORCES: tuple[Force, ...] = (PointMass(EARTH), J2(EARTH))
EVERY_S = 20.0
"""Between looks at the distance from a path that turns in half an hour, and is flat at its largest."""
BEFORE = "before an impulse"
"""The cause of a trigger."""


@dataclass(frozen=True, slots=True, eq=False)
class Impulses:
    """A programme up to the end of the mission; impulses that were fired stay in it."""

    programme: ImpulseProgramme
    end_s: float

    def left(self, from_s: float) -> int:
        """Place of the first impulse at a time or later."""
        return int(np.searchsorted(self.programme.times_s, from_s - 1e-9))


def next_burn(last: Trigger | None, flying: Impulses, lead_s: float) -> Trigger | None:
    """A lead before the next impulse that leaves that much time after the one before it."""
    number, after_s = (0, -1e-9) if last is None else (last.number, last.at_s + 1e-9)
    times = flying.programme.times_s
    for k, at_s in enumerate(times.tolist()):
        begins_s = at_s - lead_s
        if begins_s > after_s and begins_s > (times[k - 1] if k else -1e-9):
            return Trigger(number + 1, begins_s, BEFORE)
    return None


class LeadTimes(Lead):
    """What the loops of rendezvous missions have alike: they begin before an impulse."""

    def next_trigger(self, last: Trigger | None, programme: Impulses) -> Trigger | None:
        return next_burn(last, programme, self.period_s)


@dataclass(slots=True, eq=False)
class Chaser:
    """Inertial states of target and chaser (2, 6) at `time_s`. `after` are relative states (6,) after each impulse that was fired,
    `spent_m_s` what was fired."""

    time_s: float
    pair: Array
    errors: Uncertainty
    random: np.random.Generator
    after: list[Array] = field(default_factory=list)
    spent_m_s: float = 0.0
    path: Callable[[float], Array] | None = None
    """Where it should be (3,) at a time, whose largest distance is noted in `error_m`."""
    error_m: float = 0.0

    @classmethod
    def at(
        cls,
        relative: Array,
        target: Array,
        errors: Uncertainty,
        random: np.random.Generator,
        path: Callable[[float], Array] | None = None,
    ) -> Chaser:
        """From a relative state (6,) about a target (6,), ECI."""
        pair = np.array([target, absolute_state(target, relative, _pull(target))])
        return cls(0.0, pair, errors, random, path=path)

    @property
    def relative(self) -> Array:
        """The state (6,) in (R, T, N)."""
        return relative_state(self.pair[0], self.pair[1], _pull(self.pair[0]))

    def advance(self, programme: Impulses, until_s: float) -> None:
        """Fire every impulse from now until just before a time, and drift between; at the end of the mission that of its last moment, too."""
        times, dv = programme.programme.times_s, programme.programme.dv_m_s
        last = until_s >= programme.end_s
        for at_s, impulse in zip(times.tolist(), dv, strict=True):
            if self.time_s <= at_s and (at_s < until_s or (last and at_s <= until_s)):
                self._drift(at_s)
                self._fire(impulse)
                self.time_s = float(np.nextafter(at_s, np.inf))  # fired once
        self._drift(until_s)

    def sense(self, random: np.random.Generator) -> Sensed:
        return Sensed(self.time_s, self.errors.navigated(self.relative, random))

    def _drift(self, until_s: float) -> None:
        while self.path is not None and until_s - self.time_s > EVERY_S:
            self._coast(self.time_s + EVERY_S)
        self._coast(until_s)

    def _coast(self, until_s: float) -> None:
        if until_s > self.time_s + 1e-6:
            self.pair = fast_coast(self.pair, np.array([0.0, until_s - self.time_s]), FORCES)[-1]
        self.time_s = max(self.time_s, until_s)
        if self.path is not None:
            off = float(np.linalg.norm(self.relative[:3] - self.path(self.time_s)))
            self.error_m = max(self.error_m, off)

    def _fire(self, impulse: Array) -> None:
        fired = self.errors.executed(impulse, self.random)
        relative = self.relative
        relative[3:] += fired
        self.pair[1] = absolute_state(self.pair[0], relative, _pull(self.pair[0]))
        self.spent_m_s += float(np.linalg.norm(fired))
        self.after.append(relative)


def _pull(target: Array) -> Array:
    """Its acceleration, (3,)."""
    return np.asarray(sum(force.acceleration(target[None])[0] for force in FORCES))
