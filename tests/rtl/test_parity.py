"""Parity: nothing changes without an upset; a bit that turned over is a fault when it is read, before any end is told."""

from __future__ import annotations

import random
from collections.abc import Iterator
from pathlib import Path

import pytest

from orbsoc.ps.registers import Control, Fault, Status
from orbsoc.ps.registers import Register as Address
from orbsoc.rtl.flip_flops import Register, registers_of
from orbsoc.rtl.session import RtlSession
from tests.rtl.case_writer import Case, run_case
from tests.rtl.compressed import Compressor
from tests.rtl.engine_sources import build
from tests.rtl.machine import (
    Machine,
    Op,
    Slot,
    busy_cycles,
    encode,
    evaluate,
    in_order,
    random_program,
    schedule,
)
from tests.rtl.verilator import require_verilator

MACHINE = Machine(lanes=2, banks=8, address_bits=10, parity=True)
TWO_CLUSTERS = Machine(fp=32, lanes=4, banks=8, clusters=2, address_bits=10, parity=True)
SINGLE = Machine(fp=32, lanes=1, banks=4, address_bits=10, parity=True)
TABLE, WORDS = 0x1000, 24
SLOTS = [Slot(Op("mul", 10, 0, 1), 0, 0), Slot(Op("add", 11, 9, 0, 2), 0, 1), Slot(Op("move", 12, 3), 2, 0)]
"""Read by replica A: 0, 9 and 3; by B: 1; by C: 2. 17 is in the bank of 1 and 9, and is not read."""
READ = {"replica_a": (0, 9, 3), "replica_b": (1,), "replica_c": (2,)}
LINES = 3
FOUND = Status(fault=Fault.PARITY)


class Engine:
    """A session with an engine whose bits can be turned over, its storage set, one segment in its table."""

    def __init__(self, session: RtlSession, registers: list[Register]) -> None:
        self.session, self._registers = session, registers
        self.load()

    def load(self) -> None:
        """Reset; words, microcode and table."""
        self.session.reset()
        self.session.segments()
        for address in range(WORDS):
            self.session.ask(f"set {address:x} {0x3FF0 << 48 | address:x}")
        for line, word in enumerate(encode(MACHINE, SLOTS, LINES)):
            self.session.ask(f"code {line:x} {word:x}")
        for offset, value in ((4, 0), (8, 0), (12, 0), (16, 1), (20, 0), (24, 0), (28, 0), (0, 1)):
            self.session.write(TABLE + offset, value)

    def flip(self, at: str, name: str, element: int, bit: int) -> None:
        """A bit of an element of the register of that name, in the only scope that ends so."""
        (found,) = (each for each in self._registers if each.scope.endswith(at) and each.name == name)
        command = f"flip {found.scope} {name} {found.in_memory(element * found.width + bit)}"
        assert self.session.ask(command) == "ok"

    def flip_word(self, replica: str, address: int, bit: int) -> None:
        bank, row = address % MACHINE.banks, address // MACHINE.banks
        self.flip(f"{replica}.g_one.whole.g_bank[{bank}].memory", "words", row, bit)

    def launch(self) -> None:
        for address, value in (
            (Address.MODULE, 1),
            (Address.SEGMENT, 0),
            (Address.SEQUENCE, 1),
            (Address.CONTROL, Control.START),
        ):
            self.session.write(address, value)

    def run(self) -> tuple[bool, Status]:
        """Launch, and what interrupt and STATUS say."""
        self.launch()
        return self.session.wait(1000)[0], self.status()

    def status(self) -> Status:
        return Status.decode(self.session.read(Address.STATUS))


@pytest.fixture(scope="module")
def opened() -> Iterator[tuple[RtlSession, list[Register]]]:
    require_verilator()
    harness = build("engine_upsets", **MACHINE.build_options("flat"))
    with RtlSession(harness) as session:
        yield session, registers_of(session, harness)


@pytest.fixture
def engine(opened: tuple[RtlSession, list[Register]]) -> Engine:
    return Engine(*opened)


DONE = Status(done=True, segment=0, sequence=1)


@pytest.mark.parametrize(
    ("machine", "form"),
    [(TWO_CLUSTERS, "compressed"), (SINGLE, "in_order"), (TWO_CLUSTERS, "flat")],
    ids=["compressed", "in_order", "flat"],
)
def test_programs_run_as_without_parity(machine: Machine, form: str, tmp_path: Path) -> None:
    """Cycles, words, STATUS and interrupt; words and lines that were never written are read among others."""
    require_verilator()
    case, compressor = Case(machine, form), Compressor(machine, random.Random(1))
    for seed in range(4):
        ops, memory = random_program(machine, 300, seed)
        slots = schedule(machine, ops)
        cycles = busy_cycles(machine, slots, max(slot.time for slot in slots) + 1)
        gaps = None
        if form == "in_order":
            slots, cycles = in_order(machine, slots, seed=seed + 1, level=64)
            gaps = (seed + 1, 64)
        code = encode(machine, slots, max(slot.time for slot in slots) + 1)
        if form == "compressed":
            code, frozen = compressor.segment(slots, max(slot.time for slot in slots) + 1)
            cycles += machine.numbers["DECODE_CYCLES"] + frozen
        case.add(f"random{seed}", code, cycles, memory, evaluate(machine, ops, memory), gaps)
    case.templates = compressor.templates
    answers = run_case(case, tmp_path)
    assert {name: answer for name, answer in answers.items() if not answer.good} == {}


def test_without_an_upset_a_segment_ends_as_ever(engine: Engine) -> None:
    assert engine.run() == (True, DONE)


@pytest.mark.parametrize("bit", [0, 31, 32, 63, 64])
def test_a_word_that_is_read_is_found_in_the_replica_that_reads_it(engine: Engine, bit: int) -> None:
    for replica in READ:
        for address in range(4):
            engine.load()
            engine.flip_word(replica, address, bit)
            assert engine.run() == (True, FOUND if address in READ[replica] else DONE)
            assert engine.session.ask("violations") == " ".join("0" * 8)


def test_a_line_of_microcode_is_found_by_any_bit_of_it(engine: Engine) -> None:
    width = (
        1 + MACHINE.lanes * (4 * MACHINE.address_bits + 4) + MACHINE.dividers * (3 * MACHINE.address_bits + 2)
    )
    for bit in (*range(0, width, 7), width):  # the last is the parity's own
        engine.load()
        engine.flip("g_flat.sequencer", "code", bit % LINES, bit)
        assert engine.run() == (True, FOUND), bit


def test_what_is_not_read_does_no_harm(engine: Engine) -> None:
    engine.flip_word("replica_b", 17, 5)  # in the bank of a word that is read
    engine.flip("g_flat.sequencer", "code", LINES, 5)  # fetched after the last line
    assert engine.run() == (True, DONE)


def test_the_fault_stays_until_a_reset_and_the_word_until_it_is_written(engine: Engine) -> None:
    engine.flip_word("replica_a", 9, 40)
    assert engine.run() == (True, FOUND)
    engine.session.write(Address.MODULE, 1)
    engine.session.write(Address.IRQ_ACK, 1)
    assert (engine.session.wait(50)[0], engine.status()) == (True, FOUND)
    engine.load()  # all words and lines anew
    assert engine.run() == (True, DONE)


def test_a_word_that_the_ps_reads_is_a_fault_too(engine: Engine) -> None:
    engine.flip_word("replica_a", 9, 0)
    assert engine.session.ask("get 9") == f"{(0x3FF0 << 48 | 9) ^ 1:x}"
    assert (engine.session.wait(5)[0], engine.status()) == (True, FOUND)
    engine.launch()
    assert (engine.session.wait(50)[0], engine.status()) == (True, FOUND)
    assert engine.session.segments() == []


def test_words_never_written_are_no_fault(engine: Engine) -> None:
    """A block RAM of an FPGA holds zeros at power-up, and the simulation does, too."""
    assert engine.session.ask(f"get {WORDS + 100:x}") == "0"
    assert engine.session.wait(10)[0] is False


def test_a_reset_forgets_what_was_read_before_it(engine: Engine) -> None:
    """At every clock of a run; a read of the PS in the first clock after it counts again."""
    last = busy_cycles(MACHINE, SLOTS, LINES)
    for clocks in range(last + 8):
        engine.load()
        engine.flip_word("replica_a", 9, 40)
        engine.launch()
        for _ in range(clocks):
            engine.session.read(Address.STATUS)  # a clock
        engine.session.reset()
        assert engine.session.wait(20)[0] is False, clocks
        assert engine.status() == Status()
        assert engine.session.ask("get 9")
        assert (engine.session.wait(5)[0], engine.status()) == (True, FOUND)


def test_two_bits_of_a_word_are_not_found(engine: Engine) -> None:
    """What a bit a word cannot do."""
    engine.flip_word("replica_a", 9, 40)
    engine.flip_word("replica_a", 9, 41)
    assert engine.run() == (True, DONE)
