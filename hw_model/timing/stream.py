"""Microcode from DDR memory, read by ports of its own while the segment runs (rtl/axi/axi_stream_port.sv).

Each port reads a part of every line ahead of the decoder, as far as its rows of block RAM go; the decoder waits for a line that
is not there. Where the items of a segment's microcode are known, its cycles are the RTL's for a memory of that latency and rate
(docs/pl-machine.md, Streamed microcode). Where only its bits are, as of flat microcode, which rtl/ does not stream, it takes the longer of
running and loading, and the first line's way.
"""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import replace
from typing import TYPE_CHECKING

from hw_model.errors import HwModelError

from .control_program import members
from .stage_cycles import Memory

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

    Raises HwModelError for an estimate, which knows no microcode, and for ports that lines cannot be divided among.
    """
    if not is_streamed(trace, platform, pattern, stage):
        return found
    code = found.microcode
    if code is None:
        raise HwModelError(
            f"`pl.microcode_memory` = {platform.pl.microcode_memory.value!r}: what it costs follows from the microcode's bits, and estimates have none;"
            " ask for schedules (--exact)"
        )
    if code.streamed is None:
        wait = fetch_cycles(found.cycles, code.bits / 8.0, platform)
    else:
        wait = code.streamed(memory_of(platform)) - found.cycles
    return replace(found, causes=found.causes | {"fetch": found.causes["fetch"] + wait})


RATE_STEPS = 1024
"""Cycles in which a memory's whole number of beats is counted."""
FIRST_LINE_CYCLES = 2
"""From a segment's start to its first line, besides the latency of memory, beyond those of a line in block RAM."""


def memory_of(platform: Platform) -> Memory:
    """What a platform's ports read from, in cycles of its PL. Ports have beats of 64 bits, or of 128 where they take more bytes a cycle."""
    pl, clock_mhz = platform.pl, platform.pl.clock_mhz.value
    beat_bits = 64 if pl.stream_bytes_per_cycle.value <= 8.0 else 128
    port = platform.link.port_mb_s.value * platform.link.ddr_efficiency.value / clock_mhz
    share = min(1.0, min(pl.stream_bytes_per_cycle.value, port) / (beat_bits / 8))
    beats = max(1, math.floor(share * RATE_STEPS))
    latency = max(1, math.ceil(pl.stream_start_us.value * clock_mhz))
    return Memory(pl.stream_ports.value, beat_bits, latency, beats, RATE_STEPS)


def fetch_cycles(cycles: int, size_bytes: float, platform: Platform) -> int:
    """Cycles that a segment of `cycles` and `size_bytes` of microcode, spread evenly over them, waits for it."""
    memory = memory_of(platform)
    rate = memory.ports * memory.beat_bits / 8 * memory.beats / memory.per
    return memory.latency + FIRST_LINE_CYCLES + max(0, math.ceil(size_bytes / rate) - cycles)
