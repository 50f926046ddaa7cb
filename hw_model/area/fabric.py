"""What a family of FPGAs builds an engine of: lookup tables, block RAM, multiplier blocks, as the open tools use them.

Memory is counted in BRAM36, also where a block has another size: an NX_RAM of NG-Ultra holds 48 Kbit in rows of 24, and
counts as two thirds of one in each of its shapes.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

from hw_model.vocabulary import Datapath

Kind = Literal["lut", "ff", "dsp", "bram36", "uram"]
KINDS: tuple[Kind, ...] = ("lut", "ff", "dsp", "bram36", "uram")
WIDE, NARROW = 24, 17
"""Bits of the factors of one multiplier block, unsigned: a DSP48E1, and NG-Ultra's."""
LEAST_FACTOR, LEAST_PRODUCT = 2, 9
"""Bits of a factor, and of a product, from which on a block is taken for it; below, it is logic."""
URAM_ROWS = 4096


@dataclass(frozen=True, slots=True)
class Fabric:
    """A family. `block_rams`: a size in BRAM36, and the (rows, bits) that it can be with one write and one read port.

    `attempt` is what control on the PL takes by itself: the recorded engine with RESIDENT=1 less the same without it. `stream` is what
    the ports of streamed microcode share, and `stream_line` what each bit of a line takes, where a block RAM has no
    register with an enable behind it.
    """

    lut_inputs: int
    full_tree: int
    """Words up to which `or_luts` is the smallest tree."""
    loose_tree: float
    """Tables for each word beyond that, as the mapper finds them."""
    shifted: dict[Datapath, tuple[int, int]] | None
    """Flip-flops for each bit of an address, of a lane and of a divider, where lookup tables are no shift registers."""
    deep_choice: int
    """Tables for each bit of a choice among up to eight words, where one does not do."""
    block_rams: tuple[tuple[float, tuple[tuple[int, int], ...]], ...]
    attempt: dict[Kind, float]
    stream: dict[Kind, int]
    stream_line: dict[Kind, float]

    def or_luts(self, words: int) -> int:
        """Lookup tables of one bit of the OR of that many words, each with its own enable, as yosys maps it."""
        if words <= self.full_tree:
            return math.ceil((2 * words - 1) / (self.lut_inputs - 1))
        return math.ceil(self.loose_tree * words)

    def bram36(self, rows: int, bits: int) -> float:
        """Block RAM of a memory of `rows` × `bits`, all of one size and shape: the least."""
        return self._mapped(rows, bits)[0]

    def chosen_luts(self, rows: int, bits: int) -> int:
        """Lookup tables that choose a word among the blocks of that memory which lie one behind the other, and a block to write."""
        deep = self._mapped(rows, bits)[1]
        return bits * self._luts_of_choice(deep) + (deep if deep > 1 else 0)

    def _mapped(self, rows: int, bits: int) -> tuple[float, int]:
        """Block RAM, and how many blocks lie one behind the other: of equal ones the shape with the fewest."""
        return min(
            (size * (deep := -(-rows // depth)) * -(-bits // width), deep)
            for size, shapes in self.block_rams
            for depth, width in shapes
        )

    def _luts_of_choice(self, words: int) -> int:
        """Of one bit of a word among `words`, as yosys maps it: one table where its inputs do."""
        inputs = words + (words - 1).bit_length()
        return 0 if words == 1 else 1 if inputs <= self.lut_inputs else self.deep_choice * -(-words // 8)


_WHOLE = ((512, 72), (1024, 36), (2048, 18), (4096, 9), (8192, 4), (16384, 2), (32768, 1))
_HALF = ((512, 36), (1024, 18), (2048, 9), (4096, 4), (8192, 2), (16384, 1))
_NX_RAM = ((2048, 24), (4096, 12), (8192, 6), (16384, 3), (32768, 1))

FABRICS: dict[str, Fabric] = {
    # Up to eight words yosys finds the tree over two inputs a word; of 16 and 32 it takes 9 to 11 and 24 a bit.
    "xc7": Fabric(
        lut_inputs=6,
        full_tree=8,
        loose_tree=2 / 3,
        shifted=None,
        deep_choice=4,
        block_rams=((1.0, _WHOLE), (0.5, _HALF)),
        attempt={"lut": 839, "ff": 160, "bram36": 0.5},
        stream={"lut": 83, "ff": 54},
        stream_line={"lut": 0, "ff": 0},
    ),
    "ng_ultra": Fabric(
        lut_inputs=4,
        full_tree=64,
        loose_tree=2 / 3,
        shifted={"f64": (105, 48), "f32": (69, 33)},
        deep_choice=2,
        block_rams=((2 / 3, _NX_RAM),),
        attempt={"lut": 1259, "ff": 171, "bram36": 4 / 3},
        stream={"lut": 40, "ff": 54},
        stream_line={"lut": 0.96, "ff": 2},
    ),
}


def multiplier_dsp(significand_bits: int) -> int:
    """Multiplier blocks of a product of two significands; a tile that is small is logic."""

    def parts(most: int) -> list[int]:
        return [min(most, significand_bits - first) for first in range(0, significand_bits, most)]

    return sum(
        min(a, b) >= LEAST_FACTOR and a + b >= LEAST_PRODUCT for a in parts(WIDE) for b in parts(NARROW)
    )


def uram(rows: int, bits: int) -> int:
    """UltraRAMs of a memory of `rows` × `bits`: each is 4096 × 72."""
    return -(-rows // URAM_ROWS) * -(-bits // 72)
