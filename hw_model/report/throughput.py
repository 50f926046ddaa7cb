"""Many problems of one pattern: how many a second, beside how long each takes.

Problems are independent, so that one may be in flight on the PL while a core generates or judges another: each has its own
set of buffers on the PL, two sets make a double buffer. Each problem is the trace's chain of work (timing/queue.py). The cores
of the baseline solve a problem each, side by side.

Problems that are interleaved in one stream are a group (timing/groups.py), and what is in flight is a group.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from hw_model.timing.actions import Work, actions_of
from hw_model.timing.groups import grouped, in_groups, require_groups
from hw_model.timing.queue import Line, Resource, period
from hw_model.vocabulary import PICOSECONDS_PER_MS

from .run import durations_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from hw_model.platform.partition import Partition
    from hw_model.platform.platform import Platform
    from hw_model.timing.durations import Durations
    from hw_model.timing.stage_cycles import StageCycles
    from hw_model.timing.trace import Trace

LINES = tuple(Line(sets=sets) for sets in (1, 2, 4))
"""Sets of buffers that a report looks at: one problem at a time, a double buffer, twice that."""


@dataclass(frozen=True, slots=True)
class Throughput:
    """Of one partition on one platform, with `in_flight` sets of buffers; solves a second are those of the trace's mix."""

    in_flight: int
    engines: int
    """On the PL, each with a set of buffers in its turn."""
    cores: int
    latency_ms: float
    """Of a run of the trace alone; of groups, one after the other."""
    solves_per_s: float
    """As simulated."""
    most_per_s: float
    """Bound by the busiest resource, whatever the number in flight."""
    busiest: Resource
    interleaved: int
    """Problems that a segment works on, and whose words are in each set of buffers."""
    baseline_per_s: float
    """All on the PS, each core with problems of its own."""
    buffer_words: int
    """Of storage for data on the PL, all sets."""

    @property
    def gain(self) -> float:
        """Over the cores of the PS alone."""
        return self.solves_per_s / self.baseline_per_s

    @property
    def words(self) -> str:
        """In a sentence."""
        many = f" of {self.interleaved} interleaved" if self.interleaved > 1 else ""
        of = f" on {self.engines} engines" if self.engines > 1 else ""
        return (
            f"modelled throughput: {self.solves_per_s:.1f} solves/s with {self.in_flight}{many} in flight{of} (at most"
            f" {self.most_per_s:.1f}: {self.busiest.upper()}), {self.gain:.2f} times that of {self.cores} cores alone"
            f" ({self.baseline_per_s:.1f}); latency {self.latency_ms:.3f} ms"
        )


def throughputs(
    trace: Trace,
    platform: Platform,
    partition: Partition,
    baseline: Partition,
    cycles: StageCycles,
    lines: Sequence[Line] = LINES,
) -> list[Throughput]:
    """Solves a second on each of `lines`, where one engine has one set of buffers, two and four unless given.

    The trace is repeated: Σ of its solves is one problem.

    With `pl.interleaved`, its solves are taken as independent problems of groups, and a group is in flight.
    A core works on one problem at a time, whatever `runtime.cores_used` says of a single one. Raises HwModelError for a
    partition that interleaves no problems, and for a problem that starts warm in a group.
    """
    copies = platform.pl.interleaved.value if partition.uses_pl else 1
    require_groups(platform, partition)
    trace = in_groups(trace, copies)
    if platform.runtime.cores_used.value > 1:
        platform = platform.with_values({"runtime.cores_used": 1, "runtime.schedule": "serial"})
    durations = durations_of(trace, platform, partition, cycles)
    chain = _chain(trace, partition, durations, copies)
    alone = durations_of(trace, platform, baseline, cycles)
    base = sum(length for _, length in _chain(trace, baseline, alone, 1))
    cores, solves = platform.ps.cores.value, len(trace.solves)
    latency = sum(length for _, length in chain)
    per_s = solves * 1e3 * PICOSECONDS_PER_MS
    words = max(sum(pattern.buffers.values()) for pattern in trace.patterns)
    found: list[Throughput] = []
    for line in lines if partition.uses_pl else (Line(sets=cores),):
        units: dict[Resource, int] = {"ps": cores, "pl": line.engines, "dma": 1}
        busy = {
            name: sum(length for resource, length in chain if resource == name) / count
            for name, count in units.items()
        }
        busiest = max(busy, key=lambda name: busy[name])
        found.append(
            Throughput(
                in_flight=line.sets,
                engines=line.engines,
                cores=cores,
                latency_ms=latency / PICOSECONDS_PER_MS,
                solves_per_s=per_s / period(chain, line, cores),
                most_per_s=per_s / busy[busiest],
                busiest=busiest,
                interleaved=copies,
                baseline_per_s=per_s * cores / base,
                buffer_words=line.sets * copies * words if partition.uses_pl else 0,
            )
        )
    return found


def _chain(
    trace: Trace, partition: Partition, durations: Durations, copies: int
) -> list[tuple[Resource, int]]:
    """Resource and picoseconds of every piece of work, adjacent ones of a resource taken together."""
    actions = actions_of(trace, partition)
    chain: list[tuple[Resource, int]] = []
    for work in (action.work for action in actions) if copies == 1 else grouped(actions, trace, copies):
        resource, length = _resource(work, durations), durations.picoseconds(work)
        if chain and chain[-1][0] == resource:
            chain[-1] = resource, chain[-1][1] + length
        elif length:
            chain.append((resource, length))
    return chain


def _resource(work: Work, durations: Durations) -> Resource:
    if work.kind in ("compute", "control"):
        return work.side
    if work.kind == "load":
        return "pl"  # which runs nothing before it
    return "dma" if work.kind == "copy" and durations.by_dma(work) else "ps"
