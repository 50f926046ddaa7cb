"""What an engine and a partition take of a device, against what the device holds.

DSP: a multiplier of p-bit significands takes ⌈p/17⌉·⌈p/24⌉ DSP48E1 (12 at binary64, 2 at binary32), one a lane.
LUT and FF: fixed, per lane, per divider and per bank, at binary64; all but the fixed part scale with the word's width.
BRAM: storage, three replicas of each bank; and microcode, one flat word a cycle of every segment, compressed.
Storage holds every buffer that a stage on the PL reads or writes, and temporaries as an allowance.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from .stage_cycles import StageCycles, estimated
from .vocabulary import Datapath

if TYPE_CHECKING:
    from .partition import Partition
    from .platform import Platform
    from .trace import Pattern, Trace

Kind = Literal["lut", "ff", "dsp", "bram36"]
KINDS: tuple[Kind, ...] = ("lut", "ff", "dsp", "bram36")
WIDTH_BITS: dict[Datapath, int] = {"f64": 64, "f32": 32}
SIGNIFICAND_BITS: dict[Datapath, int] = {"f64": 53, "f32": 24}
REPLICAS = 3
"""Copies of each bank, one a read port: operands a, b and c."""
TEMPORARIES = 0.25
"""Storage for intermediate values, as a share of the buffers: an allowance until schedules say the number."""

_BRAM18_SHAPES = ((512, 36), (1024, 18), (2048, 9), (4096, 4), (8192, 2), (16384, 1))
"""(rows, bits) that half a block RAM can be, one write and one read port."""


@dataclass(frozen=True, slots=True)
class Use:
    """One kind of resource: what is taken, what there is, and the share that may be taken."""

    kind: Kind
    used: int
    available: int
    ceiling: float

    @property
    def share(self) -> float:
        """Taken over available; infinite where there is none."""
        return self.used / self.available if self.available else math.inf if self.used else 0.0

    @property
    def fits(self) -> bool:
        """Whether the share stays within the ceiling."""
        return self.share <= self.ceiling


@dataclass(frozen=True, slots=True)
class Budget:
    """An engine in a device. `storage_words`, `microcode_words`: of the largest pattern, one replica, uncompressed."""

    uses: tuple[Use, ...]
    storage_words: int
    microcode_words: int
    microcode_bram36: int

    @property
    def fits(self) -> bool:
        """Whether every kind stays within its ceiling."""
        return all(use.fits for use in self.uses)

    @property
    def tightest(self) -> Use:
        """The kind that is nearest to its ceiling, or furthest over it."""
        return max(self.uses, key=lambda use: use.share / use.ceiling)

    def of(self, kind: Kind) -> Use:
        """The row of one kind."""
        return next(use for use in self.uses if use.kind == kind)


def budget(trace: Trace, platform: Platform, partition: Partition, cycles: StageCycles = estimated) -> Budget:
    """What the engine of `platform` takes with the segments and buffers of `partition`; nothing without a PL.

    Patterns are loaded one at a time: storage and microcode are those of the largest.
    """
    area, pl, there = platform.area, platform.pl, platform.resources
    storage = max((_storage_words(pattern, partition) for pattern in trace.patterns), default=0)
    code = max(
        (_microcode_words(trace, platform, partition, p, cycles) for p in range(len(trace.patterns))),
        default=0,
    )
    used: Counter[Kind] = Counter()
    microcode = 0
    if partition.uses_pl:
        lanes, dividers, banks = pl.lanes.value, pl.dividers.value, pl.banks.value
        width = WIDTH_BITS[trace.datapath] / 64
        lut = (
            lanes * area.lut_per_lane.value
            + dividers * area.lut_per_divider.value
            + lanes * banks * area.lut_per_lane_and_bank.value
        )
        ff = (
            lanes * area.ff_per_lane.value
            + dividers * area.ff_per_divider.value
            + banks * area.ff_per_bank.value
        )
        address_bits = max(8, math.ceil(math.log2(max(2, storage))))
        flat = 1 + lanes * (4 * address_bits + 4) + dividers * (3 * address_bits + 2)
        rows = math.ceil(storage / banks)
        microcode = math.ceil(code * flat / pl.microcode_compression.value / 36_864)
        used["lut"] = area.lut_fixed.value + round(lut * width)
        used["ff"] = area.ff_fixed.value + round(ff * width)
        used["dsp"] = lanes * multiplier_dsp(SIGNIFICAND_BITS[trace.datapath])
        used["bram36"] = REPLICAS * banks * bram18(rows, WIDTH_BITS[trace.datapath]) // 2 + microcode
    uses = tuple(
        Use(kind, used[kind], getattr(there, kind).value, getattr(area, f"{kind}_ceiling").value)
        for kind in KINDS
    )
    return Budget(uses, storage, code, microcode)


def multiplier_dsp(significand_bits: int) -> int:
    """DSP48E1 of a multiplier of two significands: 24 × 17 bits, unsigned, each."""
    return -(-significand_bits // 17) * -(-significand_bits // 24)


def bram18(rows: int, bits: int) -> int:
    """Half block RAMs of a memory of `rows` × `bits`, in the shape that takes the fewest."""
    return min(-(-rows // depth) * -(-bits // width) for depth, width in _BRAM18_SHAPES)


def _storage_words(pattern: Pattern, partition: Partition) -> int:
    on_pl = {
        buffer
        for stage in pattern.stages.values()
        if partition.side(stage.module) == "pl"
        for buffer in (*stage.reads, *stage.writes)
    }
    return math.ceil(_words(pattern, on_pl) * (1.0 + TEMPORARIES))


def _words(pattern: Pattern, buffers: Iterable[str]) -> int:
    return sum(pattern.buffers[buffer] for buffer in buffers)


def _microcode_words(
    trace: Trace, platform: Platform, partition: Partition, p: int, cycles: StageCycles
) -> int:
    """One word a cycle of each segment, kept once however often it is launched."""
    return sum(
        cycles(trace, platform, p, name).cycles
        for name, stage in trace.patterns[p].stages.items()
        if partition.side(stage.module) == "pl"
    )
