"""What an engine and a partition take of a device, against what the device holds.

The engine is one that rtl/ can be (engine.py). Its storage is a power of two of words: every buffer that a stage on the
PL reads or writes, and an allowance for temporaries. Microcode is one flat word a cycle of every segment; compressed, it
lies in lines and needs the decoder. Schedules count its bits, as `orbsoc hw run` lists them; an estimate takes
`pl.microcode_compression`.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

from hw_model.timing.control_program import streams_of
from hw_model.timing.stage_cycles import Microcode, Origin, StageCycles, estimated, of_program

from .engine import (
    KINDS,
    SIGNIFICAND_BITS,
    Kind,
    Shape,
    bram18,
    decoder_flip_flops,
    decoder_luts,
    flip_flops,
    line_bits,
    logic_luts,
    multiplier_dsp,
    storage_bram18,
)

if TYPE_CHECKING:
    from hw_model.platform.partition import Partition
    from hw_model.platform.platform import Platform
    from hw_model.timing.trace import Pattern, Trace

TEMPORARIES = 0.25
"""Storage for intermediate values, as a share of the buffers: an allowance."""


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
    """An engine in a device. Storage and microcode are those of the largest pattern, storage of one replica.

    `microcode_bits` are stored, `microcode_flat_bits` what they stand for; `microcode_origin` says whether they were
    counted ("schedule") or assumed ("estimate").
    """

    uses: tuple[Use, ...]
    storage_words: int
    microcode_words: int
    microcode_bits: int
    microcode_flat_bits: int
    microcode_origin: Origin
    microcode_bram36: int

    @property
    def fits(self) -> bool:
        """Whether every kind stays within its ceiling."""
        return all(use.fits for use in self.uses)

    @property
    def tightest(self) -> Use:
        """The kind that is nearest to its ceiling, or furthest over it."""
        return max(self.uses, key=lambda use: use.share / use.ceiling)

    @property
    def words(self) -> str:
        """Whether it fits, in a phrase."""
        share = 100 * self.tightest.share / self.tightest.ceiling
        if self.fits:
            return f"the engine fits, {self.tightest.kind} at {share:.0f} % of its ceiling"
        return f"the engine does NOT FIT: {self.tightest.kind} at {share:.0f} % of its ceiling"

    def of(self, kind: Kind) -> Use:
        """The row of one kind."""
        return next(use for use in self.uses if use.kind == kind)


def budget(trace: Trace, platform: Platform, partition: Partition, cycles: StageCycles = estimated) -> Budget:
    """What the engine of `platform` takes with the segments and buffers of `partition`; nothing without a PL.

    Patterns are loaded one at a time: storage and microcode are those of the largest.
    """
    area, pl, there = platform.area, platform.pl, platform.resources
    storage = max((_storage_words(pattern, partition) for pattern in trace.patterns), default=0)
    address_bits = max(8, math.ceil(math.log2(max(2, storage))))
    shape = Shape(trace.datapath, pl.lanes.value, pl.dividers.value, pl.banks.value, address_bits)
    packed = pl.microcode_format.value == "compressed"
    wide = line_bits(shape) if packed else shape.microcode_bits
    code = max(
        (_stored(trace, platform, partition, p, cycles, shape, wide) for p in range(len(trace.patterns))),
        key=lambda found: found.lines,
        default=_NOTHING,
    )
    used: Counter[Kind] = Counter()
    halves = 0
    if partition.uses_pl:
        halves = bram18(code.lines, wide)
        used["lut"] = logic_luts(shape, area) + (decoder_luts(shape, area) if packed else 0)
        used["ff"] = flip_flops(shape, area, math.ceil(math.log2(max(2, code.lines))))
        used["ff"] += decoder_flip_flops(shape, area) if packed else 0
        used["dsp"] = shape.lanes * multiplier_dsp(SIGNIFICAND_BITS[shape.datapath])
        used["bram36"] = math.ceil((storage_bram18(shape) + halves) / 2)
    uses = tuple(
        Use(kind, used[kind], getattr(there, kind).value, getattr(area, f"{kind}_ceiling").value)
        for kind in KINDS
    )
    return Budget(uses, storage, code.words, code.bits, code.flat_bits, code.origin, math.ceil(halves / 2))


def _storage_words(pattern: Pattern, partition: Partition) -> int:
    on_pl = {
        buffer
        for stage in pattern.stages.values()
        if partition.side(stage.module) == "pl"
        for buffer in (*stage.reads, *stage.writes)
    }
    return math.ceil(_words(pattern, on_pl) * (1.0 + TEMPORARIES))


def _alone(pattern: Pattern, partition: Partition) -> list[str]:
    """The stages on the PL."""
    return [name for name, stage in pattern.stages.items() if partition.side(stage.module) == "pl"]


def _words(pattern: Pattern, buffers: Iterable[str]) -> int:
    return sum(pattern.buffers[buffer] for buffer in buffers)


class _Code(NamedTuple):
    """The microcode of one pattern's segments."""

    words: int
    bits: int
    flat_bits: int
    lines: int
    origin: Origin


_NOTHING = _Code(0, 0, 0, 0, "estimate")


def _stored(
    trace: Trace,
    platform: Platform,
    partition: Partition,
    p: int,
    cycles: StageCycles,
    shape: Shape,
    wide: int,
) -> _Code:
    """Microcode of each segment of a pattern, kept once however often it is launched, each from a line of its own."""
    cycles = of_program(cycles, streams_of(trace, partition))
    words = bits = flat_bits = lines = 0
    origin: Origin = "estimate"
    packed = platform.pl.microcode_format.value == "compressed"
    by = platform.pl.microcode_compression.value if packed else 1.0
    for name in streams_of(trace, partition) or _alone(trace.patterns[p], partition):
        found = cycles(trace, platform, p, name)
        flat = found.cycles * shape.microcode_bits
        code = found.microcode or Microcode(found.cycles, flat, math.ceil(flat / by))
        words, bits, flat_bits = words + code.words, bits + code.bits, flat_bits + code.flat_bits
        lines += math.ceil(code.bits / wide) if packed else code.words
        origin = found.origin
    return _Code(words, bits, flat_bits, lines, origin)
