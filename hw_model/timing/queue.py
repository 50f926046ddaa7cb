"""Problems that follow one another through the cores of the PS, the engines of the PL and the DMA: how long each takes of the rest.

A problem is a chain of work. A piece waits until its resource is free: a core of the PS (any), an engine, or the DMA engine.
What could begin first is served first. A set of buffers on the PL holds one problem, from the first piece that is not the
PS's to the last; a problem that has none waits, and problems with sets go on.
"""

from __future__ import annotations

import heapq
from collections import deque
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from collections.abc import Sequence

Resource = Literal["ps", "pl", "dma"]
ROUNDS = 8
"""Problems that are simulated for each that is under way, the first and the last of which have the computer to themselves in part."""


@dataclass(frozen=True, slots=True)
class Line:
    """What problems of one kind share on the PL. `ahead`: problems that the PS may have in work without a set."""

    sets: int
    engines: int = 1
    ahead: int = 0


def period(chain: Sequence[tuple[Resource, int]], line: Line, cores: int) -> float:
    """Time of a run of problems over their number, of which each is this chain of resources and lengths of time."""
    if not chain:
        return 0.0
    on_pl = [at for at, (resource, _) in enumerate(chain) if resource != "ps"] or [len(chain)]
    first, final = on_pl[0], on_pl[-1]
    under_way = line.sets + line.ahead
    count = ROUNDS * under_way
    free: dict[Resource, list[int]] = {"ps": [0] * cores, "pl": [0] * line.engines, "dma": [0]}
    sets, without = [0] * line.sets, deque[tuple[int, int]]()
    # (when its next piece could begin, problem, piece): what could begin first is served first.
    waiting = [(0, problem, 0) for problem in range(under_way)]
    started, last = under_way, 0
    while waiting:
        ready, problem, piece = heapq.heappop(waiting)
        if piece == first:
            if not sets:
                without.append((ready, problem))
                continue
            ready = max(ready, heapq.heappop(sets))
        resource, length = chain[piece]
        units = free[resource]
        at = min(range(len(units)), key=lambda k: (units[k], k))
        end = units[at] = max(ready, units[at]) + length
        if piece == final:
            heapq.heappush(sets, end)
            if without:
                since, other = without.popleft()
                heapq.heappush(waiting, (max(end, since), other, first))
        if piece + 1 < len(chain):
            heapq.heappush(waiting, (end, problem, piece + 1))
            continue
        last = max(last, end)
        if started < count:
            heapq.heappush(waiting, (end, started, 0))
            started += 1
    return last / count
