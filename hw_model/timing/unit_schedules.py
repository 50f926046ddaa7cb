"""What every lane and divider of the PL engine executes while a segment runs, and the same as slices to draw.

A lane is held for one cycle by each operation that begins on it, a divider until it takes the next. `exact_slices` joins
neighbours of one kind only; `coarse_slices`, for long solves, joins operations until a pause exceeds a share of the
segment.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from hw_model.platform.platform import Platform
    from hw_model.platform.sections import Latencies

    from .trace import Trace

PAUSE = 1 / 16
"""A pause that is longer than this share of the segment ends a coarse slice."""

Integers = NDArray[np.integer[Any]]
Flags = NDArray[np.bool_]


@dataclass(frozen=True)
class UnitSchedule:
    """One run of a segment. `began`: the PL cycle, from the start of the segment, in which each operation begins.

    `units`: lanes from 0, then dividers. `operations`: positions in `names`.
    """

    lanes: int
    began: Integers
    units: Integers
    operations: Integers
    names: tuple[str, ...]

    @cached_property
    def order(self) -> Integers:
        """Positions of the operations, unit by unit and in the order of time."""
        return np.lexsort((self.began, self.units))


UnitSchedules = Callable[["Trace", "Platform", int, str], UnitSchedule]
"""(trace, platform, pattern, stage) → what the units do in one run of that stage on that engine."""


@dataclass(frozen=True, slots=True, order=True)
class Slice:
    """An interval of one unit's time in PL cycles from the start of its segment.

    `operations` begin in it, and the unit is held in `busy` of its cycles; `mix` counts them by name, the most first.
    """

    unit: int
    begin: int
    end: int
    operations: int
    busy: int
    mix: tuple[tuple[str, int], ...]


def exact_slices(schedule: UnitSchedule, units: Latencies) -> list[Slice]:
    """Every operation; those of one kind without a pause between them are one slice."""
    return _slices(schedule, units, lambda pauses, changes: (pauses > 0) | changes)


def coarse_slices(schedule: UnitSchedule, units: Latencies, cycles: int) -> list[Slice]:
    """Intervals without a long pause, for a segment that takes `cycles`."""
    longest = PAUSE * cycles
    return _slices(schedule, units, lambda pauses, _: pauses > longest)


def _slices(
    schedule: UnitSchedule, units: Latencies, ends: Callable[[Integers, Flags], Flags]
) -> list[Slice]:
    """Slices that end where `ends(pauses between neighbours, whether their kinds differ)` is true."""
    if not len(schedule.began):
        return []
    order = schedule.order
    began, unit, kind = (
        item[order].astype(np.int64) for item in (schedule.began, schedule.units, schedule.operations)
    )
    held = np.where(unit < schedule.lanes, 1, _intervals(schedule, units)[kind])
    pauses = began[1:] - (began[:-1] + held[:-1])
    cuts = (unit[1:] != unit[:-1]) | ends(pauses, kind[1:] != kind[:-1])
    first = np.r_[0, np.flatnonzero(cuts) + 1]
    last = np.r_[first[1:], len(began)] - 1
    busy = np.add.reduceat(held, first)
    found: list[Slice] = []
    for start, stop, taken in zip(first.tolist(), last.tolist(), busy.tolist(), strict=True):
        end = int(began[stop] + held[stop])
        mix = _mix(kind[start : stop + 1], schedule.names)
        found.append(Slice(int(unit[start]), int(began[start]), end, stop - start + 1, taken, mix))
    return found


def _intervals(schedule: UnitSchedule, units: Latencies) -> Integers:
    """Cycles that an operation of each name holds a divider."""
    by_name = {"div": units.div_interval_cycles.value, "sqrt": units.sqrt_interval_cycles.value}
    return np.array([by_name.get(name, 1) for name in schedule.names], dtype=np.int64)


def _mix(kinds: Integers, names: tuple[str, ...]) -> tuple[tuple[str, int], ...]:
    if len(kinds) == 1:
        return ((names[int(kinds[0])], 1),)
    counts = np.bincount(kinds, minlength=len(names))
    found = sorted(((names[k], int(counts[k])) for k in np.flatnonzero(counts)), key=lambda pair: -pair[1])
    return tuple(found)
