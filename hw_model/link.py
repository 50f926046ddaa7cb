"""What crosses between PS and PL, and how long that takes."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Literal, NamedTuple

from .vocabulary import Side, picos_of_ns

if TYPE_CHECKING:
    from .platform import Link

Method = Literal["dma", "registers"]
_REGISTER_BYTES = 4


class Residency:
    """Which side holds the latest version of each buffer.

    A buffer crosses only when it is read on a side that lacks its latest version; a write makes the
    writing side the only holder. At the start the PS holds everything: it built the problem.
    """

    def __init__(self, buffers: Iterable[str]) -> None:
        self._holders: dict[str, set[Side]] = {buffer: {"ps"} for buffer in buffers}

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
    """How one buffer crosses: the faster of the two ways, which the PS knows beforehand."""

    method: Method
    picos: int


def copy(link: Link, pl_clock_mhz: float, size_bytes: int, to: Side) -> Copy:
    """One buffer of `size_bytes` > 0 moved to side `to`, by DMA or 4 bytes at a time by the core."""
    per_cycle = link.dma_to_pl_bytes_per_pl_cycle if to == "pl" else link.dma_to_ps_bytes_per_pl_cycle
    # 1 MB/s is 1e-3 bytes/ns.
    port = link.port_mb_s.value * link.ddr_efficiency.value
    bytes_per_ns = min(per_cycle.value * pl_clock_mhz, port) * 1e-3
    dma = picos_of_ns(link.dma_fixed_us.value * 1000.0 + size_bytes / bytes_per_ns)
    words = -(-size_bytes // _REGISTER_BYTES)
    by_core = words * (register_write(link) if to == "pl" else register_read(link, pl_clock_mhz))
    return Copy("registers", by_core) if by_core <= dma else Copy("dma", dma)


def register_write(link: Link) -> int:
    """A posted 4-byte write, in picoseconds."""
    return picos_of_ns(link.register_write_ns.value)


def register_read(link: Link, pl_clock_mhz: float) -> int:
    """A 4-byte read, in picoseconds: a fixed part and a number of PL cycles."""
    cycles = link.register_read_pl_cycles.value
    return picos_of_ns(link.register_read_fixed_ns.value + cycles * 1000.0 / pl_clock_mhz)


def frame(link: Link) -> int:
    """The control registers that announce one stage, to start it or to publish it, in picoseconds."""
    return link.frame_register_writes.value * register_write(link)


def confirmation(link: Link, pl_clock_mhz: float, buffers: int) -> int:
    """Reading back the status and the data-valid flags of all `buffers`, in picoseconds."""
    flag_words = -(-buffers // link.flags_per_register.value)
    return status(link, pl_clock_mhz) + flag_words * register_read(link, pl_clock_mhz)


def status(link: Link, pl_clock_mhz: float) -> int:
    """Reading the status, in picoseconds."""
    return link.status_register_reads.value * register_read(link, pl_clock_mhz)


def acknowledgement(link: Link) -> int:
    """Clearing the interrupt, in picoseconds."""
    return link.acknowledge_register_writes.value * register_write(link)


def interrupt_entry(link: Link) -> int:
    """From the PL's interrupt line to the first instruction of the handler, in picoseconds."""
    return picos_of_ns(link.interrupt_entry_us.value * 1000.0)
