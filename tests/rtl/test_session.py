"""The engine driven live, as the PS drives it: frames, interrupts, flags and storage over `engine -`."""

from __future__ import annotations

import subprocess
from collections.abc import Iterator

import pytest

from orbsoc.ps.registers import Control, Fault, Register, Status
from tests.rtl.engine_sources import build
from tests.rtl.machine import Machine, Op, Slot, busy_cycles, encode
from tests.rtl.verilator import require_verilator

MACHINE = Machine(lanes=2, banks=8, address_bits=10)
TABLE = 0x1000
TWO, THREE, SIX, NINE = (
    0x4000_0000_0000_0000,
    0x4008_0000_0000_0000,
    0x4018_0000_0000_0000,
    0x4022_0000_0000_0000,
)


class Rtl:
    """One session."""

    def __init__(self) -> None:
        self._process = subprocess.Popen(
            [build("engine", **MACHINE.build_options("flat")), "-"],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
        )  # fmt: skip

    def ask(self, *words: object) -> str:
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        print(*words, file=self._process.stdin, flush=True)
        return self._process.stdout.readline().strip()

    def register(self, address: int, value: int) -> None:
        assert self.ask("write", f"{address:x}", f"{value:x}") == "ok"

    def status(self) -> Status:
        return Status.decode(int(self.ask("read", f"{Register.STATUS:x}"), 16))

    def flags(self) -> int:
        return int(self.ask("read", f"{Register.DATA_VALID:x}"), 16)

    def launch(self, segment: int, sequence: int) -> None:
        frame = (Register.MODULE, 1), (Register.SEGMENT, segment), (Register.SEQUENCE, sequence)
        for address, value in (*frame, (Register.CONTROL, Control.START)):
            self.register(address, value)

    def close(self) -> int:
        self._process.communicate()
        return self._process.returncode


SEGMENTS = {
    1: [Slot(Op("mul", 2, 0, 1), 0, 0)],  # x2 := x0 x1, flags: reads 1, writes 2
    2: [Slot(Op("add", 3, 1, 0, 2), 0, 1)],  # x3 := x2 + x1, flags: reads 2, writes 4
}
MASKS = {1: (1, 2), 2: (2, 4)}


@pytest.fixture
def rtl() -> Iterator[Rtl]:
    """Storage with two and three, two segments, their table; buffer 0 is published."""
    require_verilator()
    session = Rtl()
    assert session.ask("reset") == "ok"
    for segment, slots in SEGMENTS.items():
        assert session.ask("code", segment, f"{encode(MACHINE, slots, 1)[0]:x}") == "ok"
        reads, writes = MASKS[segment]
        for offset, value in (
            (4, segment),
            (8, reads),
            (12, 0),
            (16, writes),
            (20, 0),
            (24, 0),
            (28, 0),
            (0, 1),
        ):
            session.register(TABLE + 64 * segment + offset, value)
    for offset, value in ((4, 0), (8, 0), (12, 0), (16, 1), (20, 0), (24, 0), (28, 0), (0, 0)):
        session.register(TABLE + offset, value)
    for address, word in enumerate((TWO, THREE)):
        assert session.ask("set", f"{address:x}", f"{word:x}") == "ok"
    frame = (Register.MODULE, 0), (Register.SEGMENT, 0), (Register.SEQUENCE, 1)
    for address, value in (*frame, (Register.CONTROL, Control.PUBLISH)):
        session.register(address, value)
    yield session
    assert session.close() == 0


def test_two_segments_run_one_after_the_other_and_move_the_flags(rtl: Rtl) -> None:
    for sequence, segment, flags in ((2, 1, 0b011), (3, 2, 0b111)):
        rtl.launch(segment, sequence)
        assert rtl.status().busy
        assert rtl.flags() == flags >> 1  # down while the segment writes
        assert rtl.ask("wait", 1000) == f"1 {busy_cycles(MACHINE, SEGMENTS[segment], 1)}"
        assert rtl.status() == Status(done=True, segment=segment, sequence=sequence)
        assert rtl.flags() == flags
        rtl.register(Register.IRQ_ACK, sequence)
        assert rtl.status().done is False
    assert [int(rtl.ask("get", a), 16) for a in (2, 3)] == [SIX, NINE]
    assert rtl.ask("violations") == " ".join("0" * 8)


def test_a_segment_whose_input_is_not_there_is_refused(rtl: Rtl) -> None:
    rtl.launch(segment=2, sequence=2)
    assert rtl.ask("wait", 10) == "1 0"
    assert rtl.status().fault is Fault.READ_BEFORE_VALID


def test_a_write_while_a_segment_runs_stops_the_pl(rtl: Rtl) -> None:
    rtl.launch(segment=1, sequence=2)
    rtl.register(Register.MODULE, 1)
    assert rtl.status().fault is Fault.LAUNCH_WHILE_BUSY


def test_a_line_beyond_the_microcode_memory_ends_the_session() -> None:
    """It would wrap to the first line otherwise."""
    require_verilator()
    rtl = Rtl()
    last = (1 << MACHINE.build_options("flat")["CODE_BITS"]) - 1
    assert rtl.ask("code", f"{last:x}", 0) == "ok"
    assert rtl.ask("code", f"{last + 1:x}", 0) == ""
    assert rtl.close() == 2
