"""Events of the PL's units for a viewer: one iteration operation by operation, all others coarsely.

A plan runs millions of operations, more than a viewer takes. So the longest iteration is drawn in full, up to
`MOST_SLICES`; every other run of a segment has coarse slices, which carry how many operations begin in them and which.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from fractions import Fraction
from functools import cache
from typing import TYPE_CHECKING, Any, NamedTuple

from hw_model.timing.unit_schedules import Slice, UnitSchedules, coarse_slices, exact_slices

if TYPE_CHECKING:
    from hw_model.platform.platform import Platform
    from hw_model.timing.timeline import Segment, Timeline
    from hw_model.timing.trace import Trace

MOST_SLICES = 80_000
"""Slices of the iteration that is drawn in full."""


class UnitEvent(NamedTuple):
    """A slice of a unit's track, in picoseconds of the run."""

    unit: int
    start_picoseconds: int
    end_picoseconds: int
    name: str
    run: Segment
    slice: Slice
    in_full: bool


def unit_events(
    timeline: Timeline, trace: Trace, platform: Platform, schedules: UnitSchedules
) -> Iterator[UnitEvent]:
    """Every slice of every unit, run by run."""
    units = platform.pl.units(trace.datapath)
    period = Fraction(10**6) / Fraction(platform.pl.clock_mhz.value)
    chosen, left = timeline.longest_iteration(), MOST_SLICES

    @cache
    def slices(pattern: int, stage: str, cycles: int, in_full: bool) -> list[Slice]:
        schedule = schedules(trace, platform, pattern, stage)
        return exact_slices(schedule, units) if in_full else coarse_slices(schedule, units, cycles)

    for first, cycles in _pl_runs(timeline):
        of_run = trace.solves[first.solve].pattern, first.stage, cycles
        in_full = (first.solve, first.iteration) == chosen and len(slices(*of_run, True)) <= left
        left -= len(slices(*of_run, True)) if in_full else 0
        for item in slices(*of_run, in_full):
            begin, end = (first.start_picoseconds + round(cycle * period) for cycle in (item.begin, item.end))
            yield UnitEvent(item.unit, begin, end, _name(item, first, in_full), first, item, in_full)


def unit_arguments(event: UnitEvent) -> dict[str, Any]:
    """What a viewer shows beside a slice."""
    item = event.slice
    found: dict[str, Any] = {"operations": item.operations, "busy_cycles": item.busy}
    if not event.in_full:
        found["busy_share"] = round(item.busy / (item.end - item.begin), 4)
        found |= {"executes": ", ".join(f"{name} {count}" for name, count in item.mix)}
    return found | {"segment": event.run.stage, "solve": event.run.solve, "iteration": event.run.iteration}


def _name(item: Slice, first: Segment, in_full: bool) -> str:
    if not in_full:
        return f"{first.stage} {100 * item.busy / (item.end - item.begin):.0f} %"
    name = item.mix[0][0]
    return name if item.operations == 1 else f"{name} ×{item.operations}"


def _pl_runs(timeline: Timeline) -> list[tuple[Segment, int]]:
    """Runs of segments on the PL, in order: the first part of each, and its cycles."""
    parts: defaultdict[tuple[int, int], list[Segment]] = defaultdict(list)
    for segment in timeline.segments:
        if segment.side == "pl":
            parts[segment.solve, segment.event].append(segment)
    return [(own[0], sum(part.cycles for part in own)) for own in parts.values()]
