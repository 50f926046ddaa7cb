"""What the PL says of the program in its memories (rtl/axi/axi_digest.sv), from the program itself."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterable, Sequence

TEMPLATE = 1 << 31
"""Set in the number of a template, where a line's is its own."""


def program_digest(templates: Sequence[int], lines: Iterable[Sequence[int]]) -> int:
    """Of templates, and then of lines in pieces of 32 bits, each written in its order from number 0 on.

    CRC-32 of the pieces XOR CRC-32 of the numbers of what they made; both of bytes, the low one first.
    """
    pieces, numbers = list(templates), [TEMPLATE | number for number in range(len(templates))]
    for number, line in enumerate(lines):
        pieces += line
        numbers.append(number)
    return _crc(pieces) ^ _crc(numbers)


def _crc(words: Sequence[int]) -> int:
    return zlib.crc32(struct.pack(f"<{len(words)}I", *words))
