"""The run laid out in time, each segment with one cause.

Serial, as in the paper's protocol, one thing happens at a time and the segments tile the run. Overlapped, those on
the critical path do: each begins when the one before it ends. So their causes add up to the makespan at every level:
run, solve, iteration, module, stage.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

from hw_model.platform.partition import Partition, load_partition
from hw_model.platform.platform import Platform, load_platform
from hw_model.vocabulary import Cause, Module, Side

from .actions import START_UP, Action, Kind, Work
from .durations import Durations
from .groups import require_one_problem
from .precedence import Precedence, Resource, overlapped, serial

if TYPE_CHECKING:
    from pathlib import Path

Level = Literal["cause", "side", "resource", "module", "stage", "kind", "solve", "iteration"]


class Segment(NamedTuple):
    """An interval of time on one side with one cause; times in picoseconds, `cycles` in that side's clock."""

    start_picoseconds: int
    duration_picoseconds: int
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
    resource: Resource
    critical: bool
    """Whether the makespan counts it: always when serial."""
    shared_cycles: int
    """Of the PS's cycles, those at the end in which all computing cores work, not one alone."""

    @property
    def end_picoseconds(self) -> int:
        """When it ends."""
        return self.start_picoseconds + self.duration_picoseconds


@dataclass(frozen=True, slots=True)
class Timeline:
    """A modelled run: its segments in program order; the critical ones are without gap or overlap."""

    platform: str
    partition: str
    segments: tuple[Segment, ...]
    makespan_picoseconds: int
    cores: int
    """Cores that may share a stage of the PS."""

    def totals(self, *levels: Level) -> dict[tuple[Any, ...], int]:
        """Picoseconds per combination of `levels`, e.g. totals("module", "cause"). They sum to the makespan."""
        found: defaultdict[tuple[Any, ...], int] = defaultdict(int)
        for segment in self.segments:
            if segment.critical:
                found[tuple(getattr(segment, level) for level in levels)] += segment.duration_picoseconds
        return dict(found)

    def longest_iteration(self) -> tuple[int, int]:
        """Solve and number of the iteration that takes longest, start-ups apart; (0, 0) when there is none."""
        times: Counter[tuple[int, int]] = Counter()
        started = {
            (segment.solve, segment.iteration) for segment in self.segments if segment.stage == START_UP
        }
        for segment in self.segments:
            if segment.critical and segment.iteration and (segment.solve, segment.iteration) not in started:
                times[segment.solve, segment.iteration] += segment.duration_picoseconds
        return max(times, key=lambda key: times[key], default=(0, 0))

    def busy(self) -> dict[Resource, int]:
        """Picoseconds that each resource works, critical or not."""
        found: defaultdict[Resource, int] = defaultdict(int)
        for segment in self.segments:
            found[segment.resource] += segment.duration_picoseconds
        return dict(found)


def precedence_of(actions: list[Action], durations: Durations) -> Precedence:
    """The precedence that the platform's `runtime.schedule` asks for."""
    if durations.platform.runtime.schedule.value == "overlapped":
        return overlapped(actions, durations.trace, durations.by_dma)
    return serial(actions)


def lay_out(actions: list[Action], durations: Durations, partition: str) -> Timeline:
    """The timeline of `actions`, each as long as `durations` says. Raises HwModelError where problems are interleaved."""
    require_one_problem(durations.platform)
    precedence = precedence_of(actions, durations)
    times = [durations.picoseconds(action.work) for action in actions]
    ends = precedence.ends(times, max)
    critical = set(precedence.critical(ends))
    segments: list[Segment] = []
    for k, (work, module, stage, solve, iteration, event) in enumerate(actions):
        side: Side = work.side if work.kind in ("compute", "control") else "ps"
        now, resource = ends[k] - times[k], precedence.resources[k]
        for cause, picoseconds, cycles, _, detail, shared in durations.parts(work):
            segments.append(
                Segment(
                    now, picoseconds, side, module, stage, solve, iteration, event, work.kind, cause, cycles, detail,
                    resource, k in critical, shared,
                )
            )  # fmt: skip
            now += picoseconds
    return Timeline(
        durations.platform.name, partition, tuple(segments), max(ends, default=0), durations.cores
    )


def tally_of(actions: list[Action]) -> Counter[Work]:
    """How often each work occurs."""
    return Counter(action.work for action in actions)


def makespan_picoseconds(
    actions: list[Action], durations: Durations, *, worst: bool = False, tally: Counter[Work] | None = None
) -> int:
    """The makespan alone; with `worst`, that of the longest run there can be: every jitter at its bound.

    `tally`: how often each work occurs in `actions`, where the caller knows it. Raises HwModelError as `lay_out` does.
    """
    require_one_problem(durations.platform)
    if durations.platform.runtime.schedule.value == "serial":
        return durations.total_picoseconds(tally or tally_of(actions), worst=worst)
    times = [
        durations.picoseconds(action.work) + worst * durations.jitter_picoseconds(action.work)
        for action in actions
    ]
    return max(precedence_of(actions, durations).ends(times, max), default=0)


def as_platform(platform: Platform | str | Path) -> Platform:
    """A platform as it is, or loaded by name or path."""
    return platform if isinstance(platform, Platform) else load_platform(platform)


def as_partition(partition: Partition | str | Path) -> Partition:
    """A partition as it is, or loaded by name or path."""
    return partition if isinstance(partition, Partition) else load_partition(partition)
