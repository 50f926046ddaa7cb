"""A program as C source: compiled beside the driver and loaded by it, it is the one that the Python session loads."""

from __future__ import annotations

import ctypes
from pathlib import Path

import pytest

from orbsoc import _core
from orbsoc.hw.emulation import resident_program
from orbsoc.hw.schedules import Engine, pl_program
from orbsoc.ps.pl import ProgrammableLogic
from orbsoc.ps.registers import STREAM_ALIGN, TABLE, TABLE_ENTRY, WORD_MASK, Entry, Region, Wrapper
from orbsoc.ps.segments import Method
from orbsoc.rtl.c_image import c_source
from orbsoc.rtl.session import RtlSession
from orbsoc.rtl.solve_cases import SINGLE, TIGHT
from orbsoc.rtl.validation import ADDRESS_BITS, Format, problems
from tests.rtl.c_driver import OK, Board, CAttempt, library

SMALL = problems()["6 variables, cones 3"]
CASES: list[tuple[Engine, Format]] = [
    (Engine(lanes=1, banks=4, address_bits=ADDRESS_BITS), "flat"),
    (Engine(fp=32, lanes=2, banks=8, address_bits=ADDRESS_BITS), "compressed"),
]


class Recorder(RtlSession):
    """What a session of Python would write into registers and memories, in order."""

    def __init__(self) -> None:
        self.tables: list[tuple[int, int]] = []
        self.memories: dict[str, dict[int, int]] = {"template": {}, "code": {}, "set": {}}

    def require_engine_of(self, image: _core.ProgramImage) -> None:
        """There is no engine."""

    def write(self, address: int, value: int) -> None:
        self.tables.append((address, int(value)))

    def ask_all(self, commands: object) -> list[str]:
        assert hasattr(commands, "__iter__")
        for command in commands:
            what, address, word = command.split()
            self.memories[what][int(address, 16)] = int(word, 16)
        return []


class CBuffer(ctypes.Structure):
    """orbsoc_pl_buffer."""

    _fields_ = [
        ("count", ctypes.c_size_t), ("indices", ctypes.POINTER(ctypes.c_uint32)), ("addresses", ctypes.POINTER(ctypes.c_uint32)),
    ]  # fmt: skip


@pytest.mark.parametrize(("engine", "form"), CASES, ids=["flat", "compressed"])
def test_a_program_as_c_is_the_one_of_the_python_session(
    engine: Engine, form: Format, tmp_path: Path
) -> None:
    settings = TIGHT if engine.fp == 64 else SINGLE
    source = c_source(SMALL, settings, engine=engine, form=form, name="small")
    method, control = Method.from_core(_core, resident=True), resident_program()
    image = _core.program_image(pl_program(SMALL, settings, engine, None, control.streams).core, form)
    recorder = Recorder()
    recorder.load(image, method, control)
    width = 1 + (4 * ADDRESS_BITS + 4) + (3 * ADDRESS_BITS + 2) if form == "flat" else 64
    board = Board(
        library(tmp_path, beside=source.replace('#include "orbsoc.h"', "")), ProgrammableLogic(method, lambda _: 0),
        binary64=engine.fp == 64, code_width=width, address_bits=ADDRESS_BITS, code_bits=14, identity=image.identity,
    )  # fmt: skip
    assert board.open() == OK
    assert board.call("load", ctypes.c_void_p(ctypes.addressof(ctypes.c_char.in_dll(board.library, "small")))) == OK  # fmt: skip
    assert board.words(Region.MICROCODE) == recorder.memories["code"]
    assert board.words(Region.TEMPLATES) == recorder.memories["template"]
    assert board.words(Region.STORAGE) == recorder.memories["set"]
    assert board.tables == recorder.tables
    for kind, entry in (("cold", control.cold), ("warm", control.warm)):
        attempt = CAttempt.in_dll(board.library, f"small_{kind}")
        assert (attempt.entry, attempt.written) == (entry, method.attempt(warm=kind == "warm")[1])
        assert attempt.closing & method.mask(["answer"])
    buffers = (CBuffer * len(method.buffers)).in_dll(board.library, "small_buffers")
    for name, buffer in zip(method.buffers, buffers, strict=True):
        indices, addresses = image.homes.get(name, ((), ()))
        assert buffer.indices[: buffer.count] == list(indices)
        assert buffer.addresses[: buffer.count] == list(addresses)


class CImage(ctypes.Structure):
    """The beginning of orbsoc_pl_image."""

    _fields_ = [
        ("sizes", ctypes.c_uint32 * 3), ("microcode", ctypes.POINTER(ctypes.c_uint32)), ("lines", ctypes.c_uint32),
    ]  # fmt: skip


def test_a_streamed_program_stays_where_it_is_and_the_ports_are_told_where(tmp_path: Path) -> None:
    """Two ports of 64 bits; the tables have the lines of each segment besides."""
    engine = Engine(fp=32, lanes=4, banks=16, address_bits=ADDRESS_BITS)
    source = c_source(SMALL, SINGLE, engine=engine, form="compressed", name="small", stream=2)
    control = resident_program()
    core = pl_program(SMALL, SINGLE, engine, None, control.streams).core
    image = _core.program_image(core, "compressed", stream=2)
    lines = [int(line, 16) for line in image.microcode]
    method = Method.from_core(_core, resident=True)
    board = Board(
        library(tmp_path, beside=source.replace('#include "orbsoc.h"', "")), ProgrammableLogic(method, lambda _: 0), binary64=False, code_width=128, address_bits=ADDRESS_BITS, code_bits=14,
        identity=image.identity, stream=2,
    )  # fmt: skip
    assert board.open() == OK
    small = CImage.in_dll(board.library, "small")
    assert board.call("load", ctypes.c_void_p(ctypes.addressof(small))) == OK
    assert board.words(Region.MICROCODE) == {}
    base = ctypes.cast(small.microcode, ctypes.c_void_p).value
    assert base is not None
    assert base % STREAM_ALIGN == 0
    apart = -(-8 * len(lines) // STREAM_ALIGN) * STREAM_ALIGN
    assert board.bases == {
        Wrapper.STREAM_BASE: base & WORD_MASK,
        Wrapper.STREAM_BASE + 4: base + apart & WORD_MASK,
    }
    for port in (0, 1):
        words = small.microcode[port * apart // 4 : port * apart // 4 + 2 * len(lines)]
        assert words == [line >> 64 * port + low & WORD_MASK for line in lines for low in (0, 32)]
    tables = dict(board.tables)
    counts = {}
    for segment in method.numbered(control).values():
        row = TABLE + TABLE_ENTRY * segment.number
        if segment.stage in image.entries:
            counts[tables[row + Entry.START]] = tables[row + Entry.LINES]
    assert sum(counts.values()) == len(lines)
    assert set(counts) == {0} | {start + count for start, count in counts.items()} - {len(lines)}


def test_without_resident_control_there_is_no_control_program() -> None:
    source = c_source(SMALL, TIGHT, engine=CASES[0][0], resident=False)
    assert "image_instructions, 0u" in source
    assert "image_cold" not in source
