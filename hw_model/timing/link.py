"""What crosses between PS and PL, and how long that takes."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Literal, NamedTuple

from hw_model.vocabulary import Side, picoseconds_of_ns

if TYPE_CHECKING:
    from hw_model.platform.sections import Link, Runtime

Method = Literal["dma", "core"]
_REGISTER_BYTES = 4
BURST_BYTES = 128
"""Of a DMA: 16 beats of 64 bits, the most that AXI3 has and what rtl/soc/soc_dma.sv makes."""

CACHED_BYTES = 8192
"""Of a transfer to the PL, what the core's cache may hold: of 256 to 8192 the power of two that fits the simulated chip's best."""


class Residency:
    """Which side holds the latest version of each buffer.

    A buffer crosses only when it is read on a side that lacks its latest version; a write makes the
    writing side the only holder. At the start the PS holds everything: it built the problem.
    """

    def __init__(self, buffers: Iterable[str]) -> None:
        self._holders: dict[str, set[Side]] = {buffer: {"ps"} for buffer in buffers}

    @property
    def holders(self) -> frozenset[tuple[str, Side]]:
        """Every buffer with each side that holds its latest version."""
        return frozenset((buffer, side) for buffer, sides in self._holders.items() for side in sides)

    def copy(self) -> Residency:
        """The same, to go on from by itself."""
        other = Residency(())
        other._holders = {buffer: set(sides) for buffer, sides in self._holders.items()}
        return other

    def missing(self, buffers: Iterable[str], side: Side) -> list[str]:
        """The buffers that must cross before `side` may read them; from now on both sides hold them.

        Buffers unknown at the start (those without a single word) never cross.
        """
        crossing: list[str] = []
        for buffer in buffers:
            holders = self._holders.get(buffer)
            if holders is not None and side not in holders:
                holders.add(side)
                crossing.append(buffer)
        return crossing

    def written(self, buffers: Iterable[str], side: Side) -> None:
        """Record that `side` has a new version of each buffer."""
        for buffer in buffers:
            if buffer in self._holders:
                self._holders[buffer] = {side}


class Copy(NamedTuple):
    """How one buffer crosses: the fastest way, which the PS knows beforehand."""

    method: Method
    picoseconds: int
    cache_picoseconds: int
    """Cache maintenance beside it; 0 for a copy by a core, to which the PL's memory is not cached."""


def copy(link: Link, pl_clock_mhz: float, size_bytes: int, to: Side, line_bytes: int) -> Copy:
    """One buffer of `size_bytes` > 0 moved to side `to`, by DMA with cache maintenance, or by a core."""
    moved = dma(link, pl_clock_mhz, size_bytes, to)
    kept = cache_maintenance(link, size_bytes, to, line_bytes)
    by_core = core_copy(link, pl_clock_mhz, size_bytes, to)
    return Copy("core", by_core, 0) if by_core <= moved + kept else Copy("dma", moved, kept)


def dma(link: Link, pl_clock_mhz: float, size_bytes: int, to: Side) -> int:
    """One DMA transfer: a fixed part, that of its beginning, then the slower of the PL's side and the port to memory; picoseconds."""
    per_cycle = link.dma_to_pl_bytes_per_pl_cycle if to == "pl" else link.dma_to_ps_bytes_per_pl_cycle
    # 1 MB/s is 1e-3 bytes/ns.
    port = link.port_mb_s.value * link.ddr_efficiency.value
    bytes_per_ns = min(per_cycle.value * pl_clock_mhz, port) * 1e-3
    fixed_ns = link.dma_fixed_us.value * 1000.0 + link.dma_fixed_pl_cycles.value * 1000.0 / pl_clock_mhz
    fixed_ns += min(size_bytes, BURST_BYTES) * link.dma_first_ns_per_byte.value
    if to == "pl":
        fixed_ns += min(size_bytes, CACHED_BYTES) * link.dma_cached_ns_per_byte.value
    return picoseconds_of_ns(fixed_ns + size_bytes / bytes_per_ns)


def core_copy(link: Link, pl_clock_mhz: float, size_bytes: int, to: Side) -> int:
    """A copy by a core, in picoseconds: a first register access, then a loop whose accesses merge into bursts."""
    if to == "pl":
        first = register_write(link, pl_clock_mhz)
        fixed, cycles = link.core_write_ns_per_byte.value, link.core_write_pl_cycles_per_byte.value
    else:
        first = register_read(link, pl_clock_mhz)
        fixed, cycles = link.core_read_ns_per_byte.value, link.core_read_pl_cycles_per_byte.value
    rest = max(0, -(-size_bytes // _REGISTER_BYTES) - 1)
    return first + picoseconds_of_ns(rest * _REGISTER_BYTES * (fixed + cycles * 1000.0 / pl_clock_mhz))


def cache_maintenance(link: Link, size_bytes: int, to: Side, line_bytes: int) -> int:
    """Cleaning (to the PL) or invalidating (to the PS) the lines of a buffer, in picoseconds."""
    each = link.cache_clean_ns_per_line if to == "pl" else link.cache_invalidate_ns_per_line
    return picoseconds_of_ns(-(-size_bytes // line_bytes) * each.value)


def register_write(link: Link, pl_clock_mhz: float) -> int:
    """A posted 4-byte write, in picoseconds: a fixed part and a number of PL cycles."""
    cycles = link.register_write_pl_cycles.value
    return picoseconds_of_ns(link.register_write_ns.value + cycles * 1000.0 / pl_clock_mhz)


def register_read(link: Link, pl_clock_mhz: float) -> int:
    """A 4-byte read, in picoseconds: a fixed part and a number of PL cycles."""
    cycles = link.register_read_pl_cycles.value
    return picoseconds_of_ns(link.register_read_fixed_ns.value + cycles * 1000.0 / pl_clock_mhz)


def first(link: Link) -> int:
    """What an attempt's first PUBLISH and launch each take more, in picoseconds."""
    return picoseconds_of_ns(link.first_ns.value)


def frame(link: Link, pl_clock_mhz: float) -> int:
    """The control registers that announce one stage, to start it or to publish it, in picoseconds."""
    return link.frame_register_writes.value * register_write(link, pl_clock_mhz)


def publication(link: Link, pl_clock_mhz: float) -> int:
    """That of a PUBLISH, and what it takes beside its accesses, in picoseconds."""
    return picoseconds_of_ns(link.publish_ns.value) + frame(link, pl_clock_mhz)


def confirmation(link: Link, pl_clock_mhz: float, buffers: int) -> int:
    """Reading back the status and the data-valid flags of all `buffers`, in picoseconds."""
    flag_words = -(-buffers // link.flags_per_register.value)
    return status(link, pl_clock_mhz) + flag_words * register_read(link, pl_clock_mhz)


def status(link: Link, pl_clock_mhz: float) -> int:
    """Reading the status, in picoseconds."""
    return link.status_register_reads.value * register_read(link, pl_clock_mhz)


def acknowledgement(link: Link, pl_clock_mhz: float) -> int:
    """Clearing the interrupt, in picoseconds."""
    return link.acknowledge_register_writes.value * register_write(link, pl_clock_mhz)


def completion(runtime: Runtime, link: Link, pl_clock_mhz: float) -> int:
    """From the end of a segment until the PS knows of it, in picoseconds, at least.

    By interrupt: until the first instruction of the handler. By polling the status: one whole read that starts
    after the end; the read under way when the segment ends makes it up to twice as long, which is its jitter.
    """
    if runtime.completion.value == "polling":
        return register_read(link, pl_clock_mhz)
    return picoseconds_of_ns(runtime.interrupt_entry_us.value * 1000.0)


def completion_jitter(runtime: Runtime, link: Link, pl_clock_mhz: float) -> int:
    """How much longer than `completion` that takes at most, in picoseconds."""
    if runtime.completion.value == "polling":
        return register_read(link, pl_clock_mhz)
    return picoseconds_of_ns(runtime.interrupt_jitter_us.value * 1000.0)
