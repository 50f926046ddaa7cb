"""Many problems of one pattern: how many a second, beside how long each takes.

Problems are independent, so that one may be in flight on the PL while a core generates or judges another: each has its own
set of buffers on the PL, two sets make a double buffer. Each problem is the trace's chain of work; a piece waits until its
resource is free: a core of the PS (any), the PL, or the DMA engine. What could begin first is served first. The cores of the
baseline solve a problem each, side by side.

Problems that are interleaved in one stream are a group (timing/groups.py), and what is in flight is a group.
"""

from __future__ import annotations

import heapq
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from hw_model.timing.actions import Work, actions_of
from hw_model.timing.groups import grouped, in_groups, require_groups
from hw_model.vocabulary import PICOSECONDS_PER_MS

from .run import durations_of

if TYPE_CHECKING:
    from collections.abc import Iterable

    from hw_model.platform.partition import Partition
    from hw_model.platform.platform import Platform
    from hw_model.timing.durations import Durations
    from hw_model.timing.stage_cycles import StageCycles
    from hw_model.timing.trace import Trace

Resource = Literal["ps", "pl", "dma"]
IN_FLIGHT = (1, 2, 4)
"""Sets of buffers that a report looks at: one problem at a time, a double buffer, twice that."""
ROUNDS = 8
"""Problems that are simulated for each set of buffers, the first and the last of which have the computer to themselves in part."""


@dataclass(frozen=True, slots=True)
class Throughput:
    """Of one partition on one platform, with `in_flight` sets of buffers; solves a second are those of the trace's mix."""

    in_flight: int
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
        return (
            f"modelled throughput: {self.solves_per_s:.1f} solves/s with {self.in_flight}{many} in flight (at most"
            f" {self.most_per_s:.1f}: {self.busiest.upper()}), {self.gain:.2f} times that of {self.cores} cores alone"
            f" ({self.baseline_per_s:.1f}); latency {self.latency_ms:.3f} ms"
        )


def throughputs(
    trace: Trace,
    platform: Platform,
    partition: Partition,
    baseline: Partition,
    cycles: StageCycles,
) -> list[Throughput]:
    """Solves a second with one problem in flight, two and four. The trace is repeated: Σ of its solves is one problem.

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
    busy: dict[Resource, float] = {
        name: sum(length for resource, length in chain if resource == name) / (cores if name == "ps" else 1)
        for name in ("ps", "pl", "dma")
    }
    busiest = max(busy, key=lambda name: busy[name])
    per_s = solves * 1e3 * PICOSECONDS_PER_MS
    words = max(sum(pattern.buffers.values()) for pattern in trace.patterns)
    found: list[Throughput] = []
    for in_flight in IN_FLIGHT if partition.uses_pl else (cores,):
        period = _period(chain, in_flight, cores)
        found.append(
            Throughput(
                in_flight=in_flight,
                cores=cores,
                latency_ms=latency / PICOSECONDS_PER_MS,
                solves_per_s=per_s / period,
                most_per_s=per_s / busy[busiest],
                busiest=busiest,
                interleaved=copies,
                baseline_per_s=per_s * cores / base,
                buffer_words=in_flight * copies * words if partition.uses_pl else 0,
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


def _period(chain: Iterable[tuple[Resource, int]], in_flight: int, cores: int) -> float:
    """Time of a run of problems, each time `in_flight` of them, over their number."""
    chain = list(chain)
    if not chain:
        return 0.0
    count = ROUNDS * in_flight
    free: dict[Resource, list[int]] = {"ps": [0] * cores, "pl": [0], "dma": [0]}
    # (when its next piece could begin, problem, piece): what could begin first is served first.
    waiting = [(0, problem, 0) for problem in range(in_flight)]
    started, last = in_flight, 0
    while waiting:
        ready, problem, piece = heapq.heappop(waiting)
        resource, length = chain[piece]
        units = free[resource]
        at = min(range(len(units)), key=lambda k: (units[k], k))
        end = max(ready, units[at]) + length
        units[at] = end
        if piece + 1 < len(chain):
            heapq.heappush(waiting, (end, problem, piece + 1))
            continue
        last = max(last, end)
        if started < count:
            heapq.heappush(waiting, (end, started, 0))
            started += 1
    return last / count
