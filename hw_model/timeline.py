"""The run laid out in time: segments end to end from 0 to the makespan, each with one cause.

One thing happens at a time, as in the paper's protocol: the PS waits while the PL computes. So the segments
tile the run, and their causes add up to the makespan at every level: run, solve, iteration, module, stage.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

from .partition import Partition, load_partition
from .platform import Platform, load_platform
from .prices import Prices
from .trace import parse_trace
from .vocabulary import Cause, Module, Side
from .walk import Action, Kind, walk

if TYPE_CHECKING:
    from pathlib import Path

    from .trace import Trace

Level = Literal["cause", "side", "module", "stage", "kind", "solve", "iteration"]


class Segment(NamedTuple):
    """A stretch of time on one side with one cause; times in picoseconds, `cycles` in that side's clock."""

    start_picos: int
    duration_picos: int
    side: Side
    """Whose time it is: "pl" while the PL computes, else "ps" (link and interrupts occupy the core)."""
    module: Module
    stage: str
    solve: int
    iteration: int
    event: int
    kind: Kind
    cause: Cause
    cycles: int
    detail: str


@dataclass(frozen=True, slots=True)
class Timeline:
    """A modelled run: its segments in order, without gap or overlap."""

    platform: str
    partition: str
    segments: tuple[Segment, ...]
    makespan_picos: int

    def totals(self, *levels: Level) -> dict[tuple[Any, ...], int]:
        """Picoseconds per combination of `levels`, e.g. totals("module", "cause"). They sum to the makespan."""
        found: defaultdict[tuple[Any, ...], int] = defaultdict(int)
        for segment in self.segments:
            found[tuple(getattr(segment, level) for level in levels)] += segment.duration_picos
        return dict(found)


def simulate(
    trace: Mapping[str, Any] | Trace, platform: Platform | str | Path, partition: Partition | str | Path
) -> Timeline:
    """The timeline of `trace` on `platform` under `partition` (objects, names or paths).

    Raises TraceError, PlatformError or PartitionError.
    """
    checked = parse_trace(trace)
    machine = as_platform(platform)
    split = as_partition(partition)
    return lay_out(walk(checked, split), Prices(checked, machine), split.name)


def lay_out(actions: list[Action], prices: Prices, partition: str) -> Timeline:
    """The timeline of `actions` at `prices`."""
    segments: list[Segment] = []
    now = 0
    for work, module, stage, solve, iteration, event in actions:
        side: Side = work.side if work.kind == "compute" else "ps"
        for cause, picos, cycles, detail in prices.parts(work):
            segments.append(
                Segment(
                    now, picos, side, module, stage, solve, iteration, event, work.kind, cause, cycles, detail
                )
            )
            now += picos
    return Timeline(prices.platform.name, partition, tuple(segments), now)


def as_platform(platform: Platform | str | Path) -> Platform:
    """A platform as it is, or loaded by name or path."""
    return platform if isinstance(platform, Platform) else load_platform(platform)


def as_partition(partition: Partition | str | Path) -> Partition:
    """A partition as it is, or loaded by name or path."""
    return partition if isinstance(partition, Partition) else load_partition(partition)
