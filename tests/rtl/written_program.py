"""The digest of a PL that Python plays, piece by piece as the memories get them."""

from __future__ import annotations

import struct
import zlib

from orbsoc.ps.registers import Region
from orbsoc.rtl.digest import TEMPLATE


class WrittenProgram:
    """Pieces of microcode and templates, and the numbers of what they made."""

    def __init__(self) -> None:
        self.clear()

    def clear(self) -> None:
        """A program begins."""
        self._pieces: list[int] = []
        self._numbers: list[int] = []

    def piece(self, region: Region, number: int, value: int, *, last: bool) -> None:
        """A piece of a line or template; the last one makes it. Words of storage are none."""
        if region is Region.STORAGE:
            return
        self._pieces.append(value)
        if last:
            self._numbers.append(number | (TEMPLATE if region is Region.TEMPLATES else 0))

    @property
    def digest(self) -> int:
        """What the register says."""
        pieces, numbers = (
            zlib.crc32(struct.pack(f"<{len(words)}I", *words)) for words in (self._pieces, self._numbers)
        )
        return pieces ^ numbers
