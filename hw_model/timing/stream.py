"""Microcode from DDR memory: a double buffer on the chip, filled over a port of its own while the segment runs.

A segment of S bytes in halves of B bytes at r bytes a cycle waits for the first half, s + min(B, S)/r with the port's
latency s. From then on loading and running overlap: it ends when the last half, loaded by (S − B)/r later, has run.
The density of microcode, bytes a cycle of running, is taken as even over the segment.
"""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import replace
from typing import TYPE_CHECKING

from hw_model.errors import HwModelError

from .control_program import members

if TYPE_CHECKING:
    from hw_model.platform.platform import Platform

    from .stage_cycles import PlCycles
    from .trace import Trace


def is_streamed(trace: Trace, platform: Platform, pattern: int, stage: str) -> bool:
    """Whether a segment's microcode comes from DDR memory each time it is launched."""
    match platform.pl.microcode_memory.value:
        case "streamed":
            return True
        case "streamed_start":
            return members(stage)[0] not in _repeats(trace, pattern)
        case _:
            return False


_START_UP = "equilibrate"
"""It begins every attempt of a solve."""


def _repeats(trace: Trace, pattern: int) -> frozenset[str]:
    """Stages that run more often than attempts begin."""
    key = (id(trace), pattern)
    if key not in _known or _known[key][0] is not trace:
        runs = Counter(
            stage for solve in trace.solves if solve.pattern == pattern for stage, _ in solve.events
        )
        often = frozenset(name for name, count in runs.items() if count > runs[_START_UP])
        _known.clear()
        _known[key] = trace, often
    return _known[key][1]


_known: dict[tuple[int, int], tuple[Trace, frozenset[str]]] = {}
"""Of the last trace and pattern that was asked for: a run asks for each of its segments."""


def with_fetch(found: PlCycles, trace: Trace, platform: Platform, pattern: int, stage: str) -> PlCycles:
    """A segment's cycles with those in which it waits for microcode, where the platform streams it.

    Raises HwModelError for an estimate, which knows no microcode.
    """
    if not is_streamed(trace, platform, pattern, stage):
        return found
    if found.microcode is None:
        raise HwModelError(
            f"`pl.microcode_memory` = {platform.pl.microcode_memory.value!r}: what it costs follows from the microcode's bits, and estimates have none;"
            " ask for schedules (--exact)"
        )
    wait = fetch_cycles(found.cycles, found.microcode.bits / 8.0, platform)
    return replace(found, causes=found.causes | {"fetch": found.causes["fetch"] + wait})


def fetch_cycles(cycles: int, size_bytes: float, platform: Platform) -> int:
    """Cycles that a segment of `cycles` and `size_bytes` of microcode waits for them."""
    pl, clock_mhz = platform.pl, platform.pl.clock_mhz.value
    port = platform.link.port_mb_s.value * platform.link.ddr_efficiency.value / clock_mhz
    rate = pl.stream_ports.value * min(pl.stream_bytes_per_cycle.value, port)
    first = min(float(pl.stream_buffer_bytes.value), size_bytes)
    start = math.ceil(pl.stream_start_us.value * clock_mhz + first / rate)
    if not size_bytes:
        return start
    loaded = (size_bytes - first) / rate
    last = cycles * first / size_bytes
    return start + max(0, math.ceil(loaded + last - cycles))
