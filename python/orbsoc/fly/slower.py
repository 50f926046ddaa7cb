"""How slow a computer may be: the same flight on slower ones, until it misses a window."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

from hw_model import HwModelError, partition_names, platform_names
from orbsoc.guidance.closed_loop import ClosedLoop
from orbsoc.hw.schedules import EngineError

from .computer import Computer
from .loop import Flight, Timing, fly
from .solver import OnboardSolver

CLOSE = 1.02
"""Ratio of a computer that is too slow to one that is not, from which on others are not tried."""
SLOWEST = 1e6
"""Times as slow as modelled, from which on no slower one is tried."""


@dataclass(frozen=True, slots=True)
class Enough:
    """The slowest computer with which a flight loses no re-plan: how many times as slow as the one that flew, and, where that one
    was too slow, the device and partition that are the slowest of those that would do. 0: none would."""

    factor: float
    name: str = ""

    @property
    def words(self) -> str:
        """In a phrase."""
        if self.factor == 0.0:
            return "no computer, however fast, would do"
        if self.factor >= SLOWEST:
            return "any computer would do"
        if self.factor >= 1.0:
            return f"one {self.factor:.3g} times as slow would do"
        named = f", as {self.name}" if self.name else ""
        return f"the slowest that would do is {1.0 / self.factor:.3g} times as fast{named}"


def enough_for(
    loop: ClosedLoop, flight: Flight, computer: Computer, solver: OnboardSolver, timing: Timing
) -> Enough:
    """Found by flying the same flight again on slower or faster ones; `slower` alone is changed, not what is computed."""

    def loses(slower: float) -> bool:
        again = fly(loop, computer.at(slower), solver, timing, seed=flight.seed, number=flight.number)
        return again.lost > 0

    at = computer.slower
    good, bad = (at, inf) if flight.lost == 0 else (0.0, at)
    if bad == inf:
        while bad == inf and good < SLOWEST * at:
            good, bad = (good, 4.0 * good) if loses(4.0 * good) else (4.0 * good, inf)
        if bad == inf:
            return Enough(inf)
    while good == 0.0 and bad > at / SLOWEST:
        good, bad = (good, bad / 4.0) if loses(bad / 4.0) else (bad / 4.0, bad)
    if good == 0.0:
        return Enough(0.0)
    while bad > CLOSE * good:
        middle = (good * bad) ** 0.5
        good, bad = (good, middle) if loses(middle) else (middle, bad)
    name = "" if flight.lost == 0 else _named(loop, flight, solver, timing)
    return Enough(good / at, name)


def _named(loop: ClosedLoop, flight: Flight, solver: OnboardSolver, timing: Timing) -> str:
    """The device and partition with the longest time for a re-plan that still lose none; empty where none is known."""
    found: list[tuple[float, str]] = []
    for device in platform_names():
        for partition in partition_names():
            other = Computer(device, partition)
            try:
                again = fly(loop, other, solver, timing, seed=flight.seed, number=flight.number)
            except (HwModelError, EngineError):  # its PL has no schedules, or does not hold the engine
                continue
            if again.lost == 0:
                found.append((again.longest_s, other.name))
    return max(found, default=(0.0, ""))[1]
