"""The driver in C (rtl/driver) as a shared library, on registers and memories that Python plays."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import pytest

from orbsoc.ps.registers import (
    BUFFERS,
    ENGINE_FIELDS,
    ERROR_OF_FAULT,
    SIZES_FIELDS,
    TABLE,
    LaunchTimeout,
    LostInterrupt,
    LostWrite,
    ProtocolError,
    Region,
    RegisterFile,
    Wrapper,
)
from orbsoc.ps.segments import Segment
from tests.rtl.engine_sources import RTL
from tests.rtl.written_program import WrittenProgram

DRIVER = RTL / "driver"
STRICT = (
    "-std=c11",
    "-Wall",
    "-Wextra",
    "-Wpedantic",
    "-Wconversion",
    "-Wshadow",
    "-Werror",
    "-ffreestanding",
)
REGISTERS, MEMORIES = 0x4000_0000, 0x8000_0000
IDENTITY = 0x1234_5678
"""Of the board's engine, unless a test says otherwise."""
OK = 0
LOST_INTERRUPT, LAUNCH_TIMEOUT, LOST_WRITE, WRONG_ENGINE, OUT_OF_RANGE, NOT_AT_REST = range(16, 22)
BUS_ERROR, WRONG_PROGRAM = 22, 23
ERRORS: dict[int, type[ProtocolError]] = {int(fault): error for fault, error in ERROR_OF_FAULT.items()} | {
    LOST_INTERRUPT: LostInterrupt,
    LAUNCH_TIMEOUT: LaunchTimeout,
    LOST_WRITE: LostWrite,
}
HOOKS = """
#include "orbsoc.h"
uint32_t (*read_hook)(uintptr_t);
void (*write_hook)(uintptr_t, uint32_t);
uint32_t orbsoc_pl_read(uintptr_t address) { return read_hook(address); }
void orbsoc_pl_write(uintptr_t address, uint32_t value) { write_hook(address, value); }
size_t pl_size(void) { return sizeof(orbsoc_pl); }
"""
_READ = ctypes.CFUNCTYPE(ctypes.c_uint32, ctypes.c_size_t)
_WRITE = ctypes.CFUNCTYPE(None, ctypes.c_size_t, ctypes.c_uint32)


class CSegment(ctypes.Structure):
    """orbsoc_pl_segment."""

    _fields_ = [
        ("module", ctypes.c_uint32), ("start", ctypes.c_uint32),
        ("reads", ctypes.c_uint64), ("writes", ctypes.c_uint64), ("stales", ctypes.c_uint64),
    ]  # fmt: skip


class CAttempt(ctypes.Structure):
    """orbsoc_pl_attempt."""

    _fields_ = [("entry", ctypes.c_uint32), ("closing", ctypes.c_uint64), ("written", ctypes.c_uint64)]


class CInstruction(ctypes.Structure):
    """orbsoc_pl_instruction."""

    _fields_ = [("word", ctypes.c_uint32), ("flag", ctypes.c_uint32)]


def c_segment(segment: Segment, start: int = 0) -> CSegment:
    return CSegment(int(segment.module), start, segment.reads, segment.writes, segment.stales)


def compiler() -> str:
    """Of this machine; a harness needs one as well."""
    found = shutil.which("gcc") or shutil.which("cc")
    if found is None:
        pytest.fail("no C compiler")
    return found


def library(folder: Path, source: str | None = None, *, beside: str = "") -> Path:
    """The driver, or another text of it, with accesses that can be set, and other C `beside` it."""
    driver, hooks, made = folder / "orbsoc.c", folder / "hooks.c", folder / "liborbsoc.so"
    driver.write_text((DRIVER / "orbsoc.c").read_text() if source is None else source)
    hooks.write_text(HOOKS + beside)
    command = [compiler(), *STRICT, "-O1", "-DORBSOC_EXTERNAL_ACCESS", f"-I{DRIVER}", "-shared", "-fPIC"]
    done = subprocess.run([*command, driver, hooks, "-o", made], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return made


class Board:
    """What a driver sees: registers of a PL, and the wrapper's, tables and memories. It notes each access of registers.

    Storage and microcode take their words in pieces, in order, as rtl/axi/axi_word_pieces.sv does.
    """

    def __init__(
        self, made: Path, port: RegisterFile, *, binary64: bool = True, code_width: int = 100, resident: bool = True,
        address_bits: int = 6, code_bits: int = 3, identity: int = IDENTITY, parity: bool = False, stream: int = 0, words: int = 0,
    ) -> None:  # fmt: skip
        self.library = ctypes.CDLL(str(made))
        self.pl = ctypes.create_string_buffer(self.library.pl_size())
        self.port, self.pieces = port, {Region.STORAGE: 1 + binary64, Region.MICROCODE: -(-code_width // 32)}
        self.accesses: list[tuple[str, int, int]] = []
        self.tables: list[tuple[int, int]] = []
        self.memories: dict[Region, dict[int, list[int]]] = {region: {} for region in Region}
        self.memory_reads = 0
        self.refused: list[int] = []
        self.resets = 0
        self._begun: list[int] = []
        engine = ENGINE_FIELDS["binary64"].put(binary64) | ENGINE_FIELDS["resident"].put(resident)
        engine |= ENGINE_FIELDS["parity"].put(parity) | ENGINE_FIELDS["stream"].put(stream)
        engine |= ENGINE_FIELDS["fewer_words"].put(words > 0)
        self.bases: dict[int, int] = {}
        """Of streamed microcode where the ports' lines lie."""
        sizes = {"address_bits": address_bits, "code_bits": code_bits, "code_width": code_width}
        self._constants = {
            int(Wrapper.ENGINE): engine,
            int(Wrapper.SIZES): sum(SIZES_FIELDS[name].put(value) for name, value in sizes.items()),
            int(Wrapper.CYCLES): 77,
            int(Wrapper.IDENTITY): identity,
        } | ({int(Wrapper.WORDS): words} if words else {})
        self.spoil: Callable[[int, int], tuple[int, int]] = lambda offset, value: (offset, value)
        """What a write to the memories becomes on its way."""
        self._program = WrittenProgram()
        self._hooks = _READ(self._read), _WRITE(self._write)
        for name, hook in zip(("read_hook", "write_hook"), self._hooks, strict=True):
            ctypes.c_void_p.in_dll(self.library, name).value = ctypes.cast(hook, ctypes.c_void_p).value

    def call(self, name: str, *arguments: Any) -> int:
        """A function of the driver on this PL; its error."""
        return int(getattr(self.library, f"orbsoc_pl_{name}")(self.pl, *arguments))

    def open(self, buffers: int = BUFFERS) -> int:
        return self.call("open", ctypes.c_size_t(REGISTERS), ctypes.c_size_t(MEMORIES), buffers)

    def _read(self, address: int) -> int:
        if address >= MEMORIES:
            self.memory_reads += 1
            return self._read_memory(address - MEMORIES)
        address -= REGISTERS
        if address in self._constants:
            return self._constants[address]
        if address == Wrapper.DIGEST:
            return self._program.digest
        value = self.port.read(address)
        self.accesses.append(("read", address, value))
        return value

    def _write(self, address: int, value: int) -> None:
        if address >= MEMORIES:
            self._write_memory(*self.spoil(address - MEMORIES, value))
        elif address - REGISTERS == Wrapper.DIGEST:
            self._program.clear()
        elif address - REGISTERS in range(Wrapper.STREAM_BASE, Wrapper.STREAM_BASE + 16, 4):
            self.bases[address - REGISTERS] = value
        elif address - REGISTERS == Wrapper.RESET:
            self.resets += value
        elif TABLE <= address - REGISTERS < Wrapper.RESET:
            self.tables.append((address - REGISTERS, value))
        else:
            self.accesses.append(("write", address - REGISTERS, value))
            self.port.write(address - REGISTERS, value)

    def _place(self, offset: int) -> tuple[Region, int, int, int]:
        """Memory, word, piece, and pieces of a word."""
        region = Region(offset & ~0xFF_FFFF)
        pieces = self.pieces.get(region, 1)
        stride = 1 << (pieces - 1).bit_length()
        word, piece = divmod((offset & 0xFF_FFFF) // 4, stride)
        return region, word, piece, pieces

    def _read_memory(self, offset: int) -> int:
        region, word, piece, pieces = self._place(offset)
        if region is not Region.STORAGE:
            self.refused.append(offset)
        return self.memories[region].get(word, [0] * pieces)[piece]

    def _write_memory(self, offset: int, value: int) -> None:
        region, word, piece, pieces = self._place(offset)
        if piece == 0:
            self._begun = []
        if piece != len(self._begun):  # the bus would answer SLVERR
            self.refused.append(offset)
            return
        self._begun.append(value)
        self._program.piece(region, word, value, last=piece == pieces - 1)
        if piece == pieces - 1:
            self.memories[region][word] = self._begun
            self._begun = []

    def words(self, region: Region) -> dict[int, int]:
        """Words of a memory that were written."""
        return {
            word: sum(piece << 32 * place for place, piece in enumerate(pieces))
            for word, pieces in self.memories[region].items()
        }

    def set_words(self, words: dict[int, int]) -> int:
        addresses = (ctypes.c_uint32 * len(words))(*words)
        return self.call("set_words", addresses, (ctypes.c_uint64 * len(words))(*words.values()), ctypes.c_size_t(len(words)))  # fmt: skip

    def get_words(self, addresses: Iterable[int]) -> list[int]:
        places = list(addresses)
        found = (ctypes.c_uint64 * len(places))()
        assert self.call("get_words", (ctypes.c_uint32 * len(places))(*places), found, ctypes.c_size_t(len(places))) == OK  # fmt: skip
        return list(found)
