"""What an engine of rtl/ takes of an FPGA, as a formula of its shape; synthesis.py has what it is held against.

Structure gives the crossbars, memories and multipliers, in the cells of a family (fabric.py); of a lane, a divider and the
control there are figures, each measured once by synthesis (`[area.orbsoc_rtl]`).
With U = lanes + dividers units, B banks of 2^ROW words, W bits a word, F bits a microcode word:

DSP: a multiplier of p-bit significands takes ⌈p/17⌉·⌈p/24⌉ blocks less one that is logic (11 at binary64, 2 at binary32), one a lane.
BRAM: three replicas of each bank, and the microcode; each memory in the shape that takes the least.
FF: of 2U + L read ports two picks a bank and an operand, of 3B read banks a row, of B write banks a row, word and enable;
the issue register and program counter; the PS's port; lanes, dividers, control.
LUT: rows, words and write-back are ORs of gated words (`or_luts`), and each port picks its bank; lanes, dividers, control.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

from hw_model.errors import NoSuchEngineError
from hw_model.vocabulary import Datapath

from .fabric import FABRICS, URAM_ROWS, Fabric, Kind, multiplier_dsp, uram

if TYPE_CHECKING:
    from hw_model.platform.sections import Area, Pl

WIDTH_BITS: dict[Datapath, int] = {"f64": 64, "f32": 32}
SIGNIFICAND_BITS: dict[Datapath, int] = {"f64": 53, "f32": 24}
REPLICAS = 3
STREAM_ROWS = 512
"""Parts of lines that a port of streamed microcode holds, as rtl/engine.svh says."""
"""Copies of each bank, one a read port: operands a, b and c."""
PARITY_CONTROL = 9
"""Flip-flops of parity beside banks and ports: a bit of a line and what is wrong with it, a wrong operand, cycles since the reset."""
READ_STAGES = 3
"""Cycles that a port's choice of a bank waits for the bank's word: what engines of 1, 2 and 4 lanes have on NG-Ultra."""


@dataclass(frozen=True, slots=True)
class Shape:
    """An engine as the RTL's parameters say it, but for its microcode. `banks` is a power of two; `parity`: a bit a word and a line."""

    datapath: Datapath
    lanes: int
    dividers: int
    banks: int
    address_bits: int
    clusters: int = 1
    parity: bool = False

    @property
    def stored_bits(self) -> int:
        """Bits of a word in its bank."""
        return self.word_bits + self.parity

    @property
    def word_bits(self) -> int:
        """Bits of a word of storage."""
        return WIDTH_BITS[self.datapath]

    @property
    def row_bits(self) -> int:
        """Bits of a row's number in its bank."""
        return max(0, self.address_bits - math.ceil(math.log2(self.banks)))

    @property
    def microcode_bits(self) -> int:
        """Bits of a flat microcode word (docs/pl-machine.md, Flat microcode)."""
        return 1 + self.lanes * (4 * self.address_bits + 4) + self.dividers * (3 * self.address_bits + 2)


MOST = {"lanes": 16, "dividers": 4, "banks": 64}
"""Largest engine that the scheduler takes; a test holds it against the scheduler's own limits."""


MOST_CLUSTERS = 8


def require_buildable(pl: Pl) -> None:
    """Raise NoSuchEngineError for an engine that rtl/ cannot be: a schedule would refuse it, and so must an estimate."""
    for name, most in MOST.items():
        value = getattr(pl, name).value
        if value > most:
            raise NoSuchEngineError(f"`pl.{name}` = {value}: no engine of rtl/ has more than {most}")
    clusters, lanes, banks = pl.clusters.value, pl.lanes.value, pl.banks.value
    if clusters > 1 and (clusters > MOST_CLUSTERS or lanes % clusters or banks < 2 * clusters):
        raise NoSuchEngineError(
            f"`pl.clusters` = {clusters}: allowed is a power of two up to {MOST_CLUSTERS} that divides the {lanes} lanes"
            f" and leaves each two of the {banks} banks"
        )


def fabric_of(area: Area) -> Fabric:
    """The family that the figures of `area` are of."""
    return FABRICS[area.fabric]


def logic_luts(shape: Shape, area: Area) -> int:
    """Lookup tables: logic, shift registers and the table of segments."""
    fabric = fabric_of(area)
    clusters = [_cluster(shape, number) for number in range(shape.clusters)]
    between = _network_luts(shape, fabric, clusters) if shape.clusters > 1 else 0
    return (
        sum(_cluster_luts(shape, fabric, each) for each in clusters)
        + between
        + _units_and_control(shape, area, "lut")
    )


@dataclass(frozen=True, slots=True)
class _Cluster:
    """Lanes and dividers of a cluster, and whether the PS writes through it."""

    lanes: int
    dividers: int
    host: int

    @property
    def units(self) -> int:
        return self.lanes + self.dividers

    @property
    def readers(self) -> tuple[int, ...]:
        """Of each replica."""
        return self.units, self.units, self.lanes


def _cluster(shape: Shape, number: int) -> _Cluster:
    dividers = len(range(number, shape.dividers, shape.clusters))
    return _Cluster(shape.lanes // shape.clusters, dividers, int(number == 0))


def _cluster_luts(shape: Shape, fabric: Fabric, own: _Cluster) -> int:
    """The crossbars of a cluster: from its units, and what other clusters read and write, to its banks and back."""
    banks, others = shape.banks // shape.clusters, shape.clusters - 1
    exports = int(others > 0)
    rows = banks * shape.row_bits * sum(fabric.or_luts(readers + exports) for readers in own.readers)
    gathered = sum(own.readers) * fabric.or_luts(banks + others) + exports * REPLICAS * fabric.or_luts(banks)
    writers = own.units + own.host + others
    written = banks * (shape.row_bits + shape.word_bits) * fabric.or_luts(writers)
    ports = sum(own.readers) + exports * REPLICAS
    # Each port's choice once more, as a shift register, while the banks are read.
    picked = banks * (ports * (1 if fabric.shifted else 2) + writers)
    return rows + gathered * shape.word_bits + written + picked


def _network_luts(shape: Shape, fabric: Fabric, clusters: list[_Cluster]) -> int:
    """Between clusters: the addresses that leave each port, the results that leave each cluster, who reads where."""
    local = shape.address_bits - math.ceil(math.log2(shape.clusters))
    readers = [sum(own.readers[replica] for own in clusters) for replica in range(REPLICAS)]
    asked = sum(fabric.or_luts(readers[k] - own.readers[k]) for own in clusters for k in range(REPLICAS))
    leaving = sum(fabric.or_luts(own.units + own.host) for own in clusters)
    picked = 2 * sum(readers) * (shape.clusters - 1)
    return asked * local + leaving * (shape.address_bits + shape.word_bits) + picked


def flip_flops(shape: Shape, area: Area, code_bits: int) -> int:
    """Flip-flops, with a program counter of `code_bits`."""
    units, lanes, banks, word = shape.lanes + shape.dividers, shape.lanes, shape.banks, shape.word_bits
    ports = 2 * units + lanes
    read = ports * word + REPLICAS * banks * (shape.row_bits + word)
    written = banks * (1 + shape.row_bits + word)
    issue = 2 * shape.microcode_bits + code_bits  # what the memory puts out, and what is issued
    host = 2 + shape.address_bits + word
    shifted = _shifted(shape, fabric_of(area))
    return read + written + issue + host + shifted + _units_and_control(shape, area, "ff")


def _shifted(shape: Shape, fabric: Fabric) -> int:
    """Flip-flops of what waits for a result, or for a bank's word, where it is not in lookup tables."""
    if fabric.shifted is None:
        return 0
    lane, divider = fabric.shifted[shape.datapath]
    choices = READ_STAGES * shape.banks * (2 * (shape.lanes + shape.dividers) + shape.lanes)
    return choices + shape.address_bits * (shape.lanes * lane + shape.dividers * divider)


def _units_and_control(shape: Shape, area: Area, kind: Literal["lut", "ff"]) -> int:
    """What lanes, dividers and control take by themselves."""
    lane, divider, control = (
        int(getattr(area, f"{kind}_{part}").value)
        for part in (f"lane_{shape.datapath}", f"divider_{shape.datapath}", "control")
    )
    return shape.lanes * lane + shape.dividers * divider + control


def decoder_luts(shape: Shape, area: Area) -> int:
    """Lookup tables of the decoder of compressed microcode: its buffer's shifter, and each lane's fields."""
    buffer = line_bits(shape) * area.lut_decoder_per_line_bit.value
    return buffer + shape.lanes * area.lut_decoder_per_lane.value


def decoder_flip_flops(shape: Shape, area: Area) -> int:
    """Flip-flops of the decoder: four lines and what fills them, and each lane's template, addresses and steps."""
    own = 4 * line_bits(shape) + area.ff_decoder.value + shape.lanes * area.ff_decoder_per_lane.value
    return own - shape.microcode_bits  # the register of a memory of flat words, which it has not


def line_bits(shape: Shape) -> int:
    """Bits of a line of compressed microcode: 32 a lane, and room for the longest item in three lines."""
    item = 2 + shape.lanes * (4 * shape.address_bits + 8) + shape.dividers * (3 * shape.address_bits + 2)
    return 32 << (max(shape.lanes, -(-item // 96)) - 1).bit_length()


def storage_bram36(shape: Shape, fabric: Fabric, rows: int | None = None) -> float:
    """Block RAM of the storage, all replicas, with a power of two of rows in each bank or with `rows`."""
    return REPLICAS * shape.banks * fabric.bram36(rows or 1 << shape.row_bits, shape.stored_bits)


def storage_luts(shape: Shape, fabric: Fabric, rows: int | None) -> int:
    """Lookup tables that choose between the block RAMs of a bank of `rows`, all replicas; a power of two of rows takes none."""
    return 0 if rows is None else REPLICAS * shape.banks * fabric.chosen_luts(rows, shape.stored_bits)


def storage_in_uram(shape: Shape, fabric: Fabric, rows: int | None = None) -> tuple[int, float, int]:
    """UltraRAMs, block RAM and lookup tables of the storage, all replicas: rows that fill no further UltraRAM lie in block RAM,
    and a lookup table a bit chooses between the two."""
    rows = rows or 1 << shape.row_bits
    whole = max(1, rows // URAM_ROWS) * URAM_ROWS
    memories, rest = REPLICAS * shape.banks, max(0, rows - whole)
    blocks = fabric.bram36(rest, shape.stored_bits) if rest else 0
    luts = shape.stored_bits if rest else 0
    return memories * uram(whole, shape.stored_bits), memories * blocks, memories * luts


def parity_logic(shape: Shape, fabric: Fabric, line: int) -> tuple[int, int]:
    """Lookup tables and flip-flops that a bit a word of storage and a line of `line` bits takes beside its memory.

    A bank makes it once for its replicas, each port of a unit has it gathered and checks it in its operand register.
    """
    ports, banks = 2 * (shape.lanes + shape.dividers) + shape.lanes, shape.banks

    def odd(bits: int) -> int:
        return math.ceil((bits - 1) / (fabric.lut_inputs - 1))

    checked = ports * (odd(shape.word_bits + 1) + fabric.or_luts(banks)) + odd(ports)
    luts = banks * odd(shape.word_bits) + checked + odd(line) + odd(line + 1)
    return luts, REPLICAS * banks + ports + PARITY_CONTROL


def parity_area(shape: Shape, fabric: Fabric, code_bits: int) -> dict[Kind, float]:
    """What parity takes beside an engine of flat microcode: logic, and block RAM where a row has no bit to spare."""
    line = shape.microcode_bits
    lut, ff = parity_logic(shape, fabric, line)
    stored = storage_bram36(replace(shape, parity=True), fabric) - storage_bram36(shape, fabric)
    lines = fabric.bram36(1 << code_bits, line + 1) - fabric.bram36(1 << code_bits, line)
    return {"lut": lut, "ff": ff, "bram36": stored + lines}


def stream_area(ports: int, line: int, area: Area) -> dict[Kind, float]:
    """What reads streamed microcode with lines of `line` bits by some ports, a part of each line by each."""
    fabric = fabric_of(area)
    return {
        "lut": ports * area.lut_stream.value + fabric.stream["lut"] + fabric.stream_line["lut"] * line,
        "ff": ports * area.ff_stream.value + fabric.stream["ff"] + fabric.stream_line["ff"] * line,
        "bram36": ports * fabric.bram36(STREAM_ROWS, -(-line // ports)),
    }


def engine_area(
    shape: Shape, area: Area, code_bits: int, *, resident: bool = False, parity: bool = False
) -> dict[Kind, float]:
    """What the whole engine takes, with flat microcode of 2^`code_bits` words; `resident` with control on the PL."""
    fabric = fabric_of(area)
    own: dict[Kind, float] = {
        "lut": logic_luts(shape, area),
        "ff": flip_flops(shape, area, code_bits),
        "dsp": shape.lanes * multiplier_dsp(SIGNIFICAND_BITS[shape.datapath]),
        "bram36": storage_bram36(shape, fabric) + fabric.bram36(1 << code_bits, shape.microcode_bits),
    }
    more = parity_area(shape, fabric, code_bits) if parity else {}
    return {
        kind: used + fabric.attempt.get(kind, 0) * resident + more.get(kind, 0) for kind, used in own.items()
    }
