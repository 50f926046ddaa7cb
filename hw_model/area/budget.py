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

from hw_model.errors import HwModelError
from hw_model.timing.control_program import segments_on_pl, streams_of
from hw_model.timing.groups import require_groups
from hw_model.timing.programs import NONE, Programs, changes_of, program_of
from hw_model.timing.stage_cycles import Microcode, Origin, StageCycles, estimated, of_program
from hw_model.timing.stream import is_streamed

from .engine import (
    SIGNIFICAND_BITS,
    Shape,
    decoder_flip_flops,
    decoder_luts,
    fabric_of,
    flip_flops,
    line_bits,
    logic_luts,
    parity_logic,
    require_buildable,
    storage_bram36,
    storage_in_uram,
    storage_luts,
    stream_area,
)
from .fabric import KINDS, Kind, multiplier_dsp, uram

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


class Taken:
    """What is taken of a device, a row of each kind of resource."""

    __slots__ = ()
    uses: tuple[Use, ...]

    @property
    def fits(self) -> bool:
        """Whether every kind stays within its ceiling."""
        return all(use.fits for use in self.uses)

    @property
    def tightest(self) -> Use:
        """The kind that is nearest to its ceiling, or furthest over it."""
        return max(self.uses, key=lambda use: use.share / use.ceiling)


@dataclass(frozen=True, slots=True)
class Budget(Taken):
    """An engine in a device. Storage is that of the largest pattern, of one replica; microcode that of the programs that stay, and of
    the largest of those that share a place.

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
    programs: Programs
    """What is loaded of each pattern, and which stays."""

    @property
    def words(self) -> str:
        """Whether it fits, in a phrase."""
        share = 100 * self.tightest.share / self.tightest.ceiling
        if self.fits:
            return f"the engine fits, {self.tightest.kind} at {share:.0f} % of its ceiling"
        return f"the engine does NOT FIT: {self.tightest.kind} at {share:.0f} % of its ceiling"

    def by_kind(self) -> dict[str, dict[str, float]]:
        """Of each kind what is taken, what there is, and the ceiling: for a report's data."""
        return {
            use.kind: {"used": use.used, "available": use.available, "ceiling": use.ceiling}
            for use in self.uses
        }

    def of(self, kind: Kind) -> Use:
        """The row of one kind."""
        return next(use for use in self.uses if use.kind == kind)


def budget(trace: Trace, platform: Platform, partition: Partition, cycles: StageCycles = estimated) -> Budget:
    """What the engine of `platform` takes with the segments and buffers of `partition`; nothing without a PL.

    Storage is that of the largest pattern, and of all interleaved problems. Of the patterns' programs as many stay in the
    microcode memory as fit, those first that are asked for most often; the others are loaded one at a time.
    Raises HwModelError for an engine or ports of streamed microcode that rtl/ cannot have, and for a partition that interleaves none.
    """
    if partition.uses_pl:
        require_buildable(platform.pl)
    require_groups(platform, partition)
    storage, rows = _storage(trace, platform, partition, cycles)
    if not partition.uses_pl:
        return Budget(_uses(platform, Counter()), storage, 0, 0, 0, "estimate", 0, NONE)
    shape = engine_shape(trace, platform, partition, cycles)
    require_ports(platform, shape)
    compressed = platform.pl.microcode_format.value == "compressed"
    wide = line_bits(shape) if compressed else shape.microcode_bits
    numbers = range(len(trace.patterns))
    codes = [_stored(trace, platform, partition, p, cycles, shape, wide) for p in numbers]
    each = tuple(program_of(trace, partition, code.lines, wide, compressed=compressed) for code in codes)
    changes = changes_of(trace)
    wanted = sorted(numbers, key=lambda p: (-changes[p], -codes[p].lines, p))
    found: Budget | None = None
    for staying in range(len(wanted), -1, -1):
        if staying == len(wanted) - 1:
            continue  # the last one has its place for itself
        stays, others = wanted[:staying], wanted[staying:]
        largest = max(others, key=lambda p: codes[p].lines, default=None)
        code = _together([codes[p] for p in (*stays, *([] if largest is None else [largest]))])
        used, coded = _used(platform, partition, shape, rows, code.lines, wide)
        programs = Programs(each, tuple(sorted(stays)), changes)
        bits = (code.words, code.bits, code.flat_bits, code.origin, math.ceil(coded))
        found = Budget(_uses(platform, used), storage, *bits, programs)
        if found.fits:
            break
    assert found is not None  # a trace has a pattern
    return found


def require_ports(platform: Platform, shape: Shape) -> None:
    """Raises HwModelError for ports of streamed microcode that rtl/ cannot have: a small engine's lines are too short for one."""
    pl, ports = platform.pl, platform.pl.stream_ports.value
    if pl.microcode_format.value != "compressed" or not pl.microcode_memory.value.startswith("streamed"):
        return
    wide = line_bits(shape)
    if ports not in (1, 2, 4) or wide % (64 * ports):
        raise HwModelError(
            f"`pl.stream_ports` = {ports}: allowed is 1, 2 or 4, with 64 bits or more each of a line, which has {wide} here"
        )


def _uses(platform: Platform, used: Counter[Kind]) -> tuple[Use, ...]:
    there, area = platform.resources, platform.area
    return tuple(
        Use(kind, used[kind], getattr(there, kind).value, getattr(area, f"{kind}_ceiling").value)
        for kind in KINDS
    )


def _used(
    platform: Platform, partition: Partition, shape: Shape, rows: int | None, lines: int, wide: int
) -> tuple[Counter[Kind], float]:
    """What an engine takes with `lines` of microcode of `wide` bits, parity left out, on the chip, and the BRAM36 of these alone."""
    area, pl, fabric = platform.area, platform.pl, fabric_of(platform.area)
    packed = pl.microcode_format.value == "compressed"
    used: Counter[Kind] = Counter()
    coded = stored = 0.0
    streamed = pl.microcode_memory.value in ("streamed", "streamed_start")
    if pl.microcode_memory.value == "ultra_ram":
        used["uram"] += uram(lines, wide + shape.parity)
    else:
        coded = fabric.bram36(lines, wide + shape.parity) if lines else 0.0
    if pl.storage_memory.value == "ultra_ram":
        blocks, stored, chosen = storage_in_uram(shape, fabric, rows)
        used["uram"] += blocks
        used["lut"] += chosen
    else:
        stored = storage_bram36(shape, fabric, rows)
        used["lut"] += storage_luts(shape, fabric, rows)
    used["lut"] += logic_luts(shape, area) + (decoder_luts(shape, area) if packed else 0)
    used["ff"] = flip_flops(shape, area, math.ceil(math.log2(max(2, lines))))
    used["ff"] += decoder_flip_flops(shape, area) if packed else 0
    if streamed:
        reading = stream_area(pl.stream_ports.value, wide, area)
        used["lut"] += math.ceil(reading["lut"])
        used["ff"] += math.ceil(reading["ff"])
        coded += reading["bram36"]
    if shape.parity:
        luts, flip_flops_more = parity_logic(shape, fabric, wide)
        used["lut"] += luts
        used["ff"] += flip_flops_more
    used["dsp"] = shape.lanes * multiplier_dsp(SIGNIFICAND_BITS[shape.datapath])
    used["bram36"] = math.ceil(stored + coded)
    if partition.control == "pl":
        used.update({kind: math.ceil(more) for kind, more in fabric.attempt.items()})
    return used, coded


def engine_shape(
    trace: Trace, platform: Platform, partition: Partition, cycles: StageCycles = estimated
) -> Shape:
    """The engine with storage for the largest pattern."""
    pl = platform.pl
    storage, _ = _storage(trace, platform, partition, cycles)
    address_bits = max(8, math.ceil(math.log2(max(2, storage))))
    units = (pl.lanes.value, pl.dividers.value, pl.banks.value)
    return Shape(trace.datapath, *units, address_bits, pl.clusters.value, pl.parity.value == "per_word")


def _storage(
    trace: Trace, platform: Platform, partition: Partition, cycles: StageCycles
) -> tuple[int, int | None]:
    """Words of storage of one replica, and the rows of a bank where these are not a power of two."""
    copies = platform.pl.interleaved.value
    storage = max((_storage_words(pattern, partition, copies) for pattern in trace.patterns), default=0)
    if platform.pl.storage_depth.value != "exact":
        return storage, None
    needed = [_needed_words(trace, platform, partition, p, cycles) for p in range(len(trace.patterns))]
    known = [words for words in needed if words is not None]
    if not known:
        return storage, None
    return max(known), max(1, -(-max(known) // platform.pl.banks.value))


def _storage_words(pattern: Pattern, partition: Partition, copies: int) -> int:
    on_pl = {
        buffer
        for stage in pattern.stages.values()
        if partition.side(stage.module) == "pl"
        for buffer in (*stage.reads, *stage.writes)
    }
    return math.ceil(copies * _words(pattern, on_pl) * (1.0 + TEMPORARIES))


def _needed_words(
    trace: Trace, platform: Platform, partition: Partition, p: int, cycles: StageCycles
) -> int | None:
    """Words of storage that a pattern's schedules need: those of all modules are an upper bound for fewer."""
    pattern = trace.patterns[p]
    names = segments_on_pl(trace, pattern, partition)
    cycles = of_program(cycles, streams_of(trace, partition))
    found = cycles(trace, platform, p, names[0]).storage_words if names else None
    whole = all(side == "pl" for module, side in partition.modules.items() if module != "statistics")
    if whole or found is None:
        return found
    return min(found, _storage_words(pattern, partition, platform.pl.interleaved.value))


def _words(pattern: Pattern, buffers: Iterable[str]) -> int:
    return sum(pattern.buffers[buffer] for buffer in buffers)


class _Code(NamedTuple):
    """The microcode of one pattern's segments, or of several patterns'."""

    words: int
    bits: int
    flat_bits: int
    lines: int
    origin: Origin


def _together(codes: list[_Code]) -> _Code:
    """Several programs side by side."""
    return _Code(
        sum(code.words for code in codes),
        sum(code.bits for code in codes),
        sum(code.flat_bits for code in codes),
        sum(code.lines for code in codes),
        codes[0].origin,
    )


def _stored(
    trace: Trace,
    platform: Platform,
    partition: Partition,
    p: int,
    cycles: StageCycles,
    shape: Shape,
    wide: int,
) -> _Code:
    """Microcode on the chip of each segment of a pattern, kept once however often it is launched, each from a line of its
    own; what is streamed is not there."""
    cycles = of_program(cycles, streams_of(trace, partition))
    words = bits = flat_bits = lines = 0
    origin: Origin = "estimate"
    packed = platform.pl.microcode_format.value == "compressed"
    by = platform.pl.microcode_compression.value if packed else 1.0
    for name in segments_on_pl(trace, trace.patterns[p], partition):
        found = cycles(trace, platform, p, name)
        if is_streamed(trace, platform, p, name):
            continue
        flat = found.cycles * shape.microcode_bits
        code = found.microcode or Microcode(found.cycles, flat, math.ceil(flat / by))
        words, bits, flat_bits = words + code.words, bits + code.bits, flat_bits + code.flat_bits
        lines += math.ceil(code.bits / wide) if packed else code.words
        origin = found.origin
    return _Code(words, bits, flat_bits, lines, origin)
