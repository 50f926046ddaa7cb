"""Write rtl/driver/orbsoc_registers.h: the register map of python/orbsoc/ps/registers.py for C.

The Python enumerations are the source, since the emulated PS and PL run on them. A generator such as peakrdl-cheader would want
the map once more, in SystemRDL: a second copy where this needs forty lines.
"""

from __future__ import annotations

import enum
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

from orbsoc.ps import registers as map_

HEADER = Path(__file__).resolve().parents[1] / "rtl" / "driver" / "orbsoc_registers.h"


def values(prefix: str, names: type[enum.IntEnum], form: str = "d") -> Iterator[str]:
    """One constant for each member of an enumeration."""
    for name, member in names.__members__.items():
        number = f"0x{int(member):x}" if form == "x" else str(int(member))
        yield f"#define ORBSOC_{prefix}_{name} {number}u"


def fields(prefix: str, of: Mapping[str, map_.Field]) -> Iterator[str]:
    """Shift and mask, the bits in place, of each field of a word."""
    for name, field in of.items():
        yield f"#define ORBSOC_{prefix}_{name.upper()}_SHIFT {field.shift}u"
        yield f"#define ORBSOC_{prefix}_{name.upper()}_MASK 0x{field.mask:08x}u"


def sizes(*names: str) -> Iterator[str]:
    """Constants of the map under their own names."""
    for name in names:
        yield f"#define ORBSOC_{name} {getattr(map_, name)}u"


def header() -> str:
    """The whole file."""
    parts: list[tuple[str, Iterable[str]]] = [
        ("Registers: byte addresses behind AXI4-Lite.", values("REG", map_.Register, "x")),
        ("Registers of the AXI wrapper.", values("REG", map_.Wrapper, "x")),
        ("Values of MODULE.", values("MODULE", map_.Module)),
        ("Values of CONTROL.", values("CONTROL", map_.Control)),
        ("Fault codes in STATUS.", values("FAULT", map_.Fault)),
        ("Fields of STATUS.", fields("STATUS", map_.STATUS_FIELDS)),
        ("Fields of ENGINE.", fields("ENGINE", map_.ENGINE_FIELDS)),
        ("Fields of SIZES.", fields("SIZES", map_.SIZES_FIELDS)),
        ("Table of segments: address, bytes an entry, entries, flags of a mask; offsets in an entry.",
         [*sizes("TABLE", "TABLE_ENTRY", "SEGMENTS"), f"#define ORBSOC_PL_BUFFERS {map_.BUFFERS}u"]),
        ("", values("ENTRY", map_.Entry)),
        ("Control program: address, bytes an entry, offset of the flag's address, instructions.",
         sizes("PROGRAM", "PROGRAM_ENTRY", "PROGRAM_FLAG", "INSTRUCTIONS")),
        ("", values("OP", map_.Op)),
        ("", fields("INSTRUCTION", map_.INSTRUCTION_FIELDS)),
        ("Memories: byte addresses behind AXI4; templates of compressed microcode.",
         values("REGION", map_.Region, "x")),
        ("", sizes("TEMPLATES", "STREAM_ALIGN")),
    ]  # fmt: skip
    lines = [
        "/* Written by scripts/write_registers.py from python/orbsoc/ps/registers.py; change that. */",
        "#ifndef ORBSOC_REGISTERS_H",
        "#define ORBSOC_REGISTERS_H",
    ]
    for title, constants in parts:
        lines += ["", f"/* {title} */"] if title else []
        lines += constants
    return "\n".join([*lines, "", "#endif", ""])


if __name__ == "__main__":
    HEADER.write_text(header())
