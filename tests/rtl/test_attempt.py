"""The operation control and the register file by hand-made programs, and that wrong ones are noticed (V5): STOP, faults within an
attempt, flags, and rows of the table that are not whole."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest

from orbsoc.ps.registers import (
    INSTRUCTION_FIELDS,
    PROGRAM,
    PROGRAM_ENTRY,
    PROGRAM_FLAG,
    TABLE,
    TABLE_ENTRY,
    Control,
    Fault,
    Module,
    Register,
    Status,
)
from orbsoc.ps.registers import Op as Step
from orbsoc.rtl.session import RtlSession
from tests.rtl.engine_sources import RTL, build
from tests.rtl.machine import Machine, Op, Slot, encode
from tests.rtl.verilator import require_verilator

MACHINE = Machine(lanes=1, banks=8, address_bits=10)
ONE, MINUS_ZERO = 0x3FF0 << 48, 1 << 63
FLAG = 5
SEGMENTS = (1, 2)
"""Each moves a word to its number's place."""


@dataclass(frozen=True)
class Wrong:
    """A place of a file, and what is there instead."""

    file: str
    right: str
    instead: str


MUTATIONS = {
    "a fault does not halt the control program": Wrong("attempt", "if (reset || halt) begin", "if (reset || (halt && !MUTANT)) begin"),
    "the stop bit outlives an attempt": Wrong("registers", "if (reset || launch) stop", "if (reset || (launch && !MUTANT)) stop"),
    "a segment exists after any word of its row": Wrong("registers", "if (table_write && column == 4'd0) exists", "if (table_write && (column == 4'd0 || MUTANT)) exists"),
    "a flag's sign counts": Wrong("attempt", "flag_word[W-2:0] != '0 ||", "(MUTANT ? flag_word != '0 : flag_word[W-2:0] != '0) ||"),
    "the stop bit is read at every branch": Wrong("attempt", "(instruction[2] && stop)", "((instruction[2] || MUTANT) && stop)"),
    "a flag read a cycle early": Wrong("attempt", "waited == LAST_WAIT", "waited == LAST_WAIT - 3'(MUTANT)"),
}  # fmt: skip


@pytest.fixture(scope="module")
def harness(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An engine with every mutation in it, of which the argument `+mutant_N` turns one on."""
    require_verilator()
    copy = tmp_path_factory.mktemp("attempts") / "rtl"
    shutil.copytree(RTL, copy)
    for number, wrong in enumerate(MUTATIONS.values()):
        path = copy / "engine" / f"{wrong.file}.sv"
        text = path.read_text()
        on = f'($test$plusargs("mutant_{number:02}") != 0)'
        path.write_text(text.replace(wrong.right, wrong.instead.replace("MUTANT", on)))
    return build("engine", rtl=copy, **MACHINE.build_options("flat"), RESIDENT=1)


class Attempts:
    """One engine with a control program: run 1; if the flag, or the stop bit, end; run 2; end. Behind it an endless one."""

    def __init__(self, session: RtlSession) -> None:
        self.session, self.sequence = session, 0
        session.reset()
        for segment in SEGMENTS:
            (word,) = encode(MACHINE, [Slot(Op("move", 8 + segment, segment), 0, 0)], 1)
            assert session.ask(f"code {segment:x} {word:x}") == "ok"
            self.row(segment, {4: segment, 8: 0, 12: 0, 16: 1, 20: 0, 24: 0, 28: 0, 0: 1})
        run, stop, never, end = (INSTRUCTION_FIELDS[name] for name in ("segment", "stop", "target", "op"))
        program = [
            end.put(Step.RUN) | run.put(1) | INSTRUCTION_FIELDS["entry"].put(1),
            end.put(Step.IF) | stop.put(1) | never.put(3),
            end.put(Step.RUN) | run.put(2),
            end.put(Step.END),
            end.put(Step.RUN) | run.put(1) | INSTRUCTION_FIELDS["entry"].put(1),
            end.put(Step.UNLESS) | never.put(4),  # no stop bit: it ends when the flag is raised
            end.put(Step.END),
        ]
        for place, word in enumerate(program):
            session.write(PROGRAM + PROGRAM_ENTRY * place + PROGRAM_FLAG, FLAG)
            session.write(PROGRAM + PROGRAM_ENTRY * place, word)
        for address in (1, 2, FLAG):
            self.store(address, 0)

    def row(self, segment: int, words: dict[int, int]) -> None:
        for offset, value in words.items():
            self.session.write(TABLE + TABLE_ENTRY * segment + offset, value)

    def store(self, address: int, word: int) -> None:
        assert self.session.ask(f"set {address:x} {word:x}") == "ok"
        self.session.wait(4)

    def frame(self, module: int, segment: int, command: Control) -> None:
        self.sequence += 1
        for register, value in (
            (Register.MODULE, module), (Register.SEGMENT, segment), (Register.SEQUENCE, self.sequence), (Register.CONTROL, command),
        ):  # fmt: skip
            self.session.write(register, value)

    def launch(self, entry: int = 0) -> None:
        self.frame(Module.PS, entry, Control.ATTEMPT)

    def ended(self) -> list[int]:
        """Wait for the end, acknowledge it; the segments that ran."""
        assert self.session.wait(500)[0], "no end"
        self.session.write(Register.IRQ_ACK, self.sequence)
        return [number for number, _ in self.session.segments()]

    def status(self) -> Status:
        return Status.decode(self.session.read(Register.STATUS))


def flags_decide(attempts: Attempts) -> None:
    for word, ran in ((0, [1, 2]), (ONE, [1]), (MINUS_ZERO, [1, 2])):
        attempts.store(FLAG, word)
        attempts.launch()
        assert attempts.ended() == ran, hex(word)


def stop_ends_this_attempt_alone(attempts: Attempts) -> None:
    attempts.launch()
    attempts.session.write(Register.STOP, 1)
    assert attempts.ended() == [1]
    attempts.launch()
    assert attempts.ended() == [1, 2]


def stop_is_read_where_it_may_be(attempts: Attempts) -> None:
    attempts.launch(4)
    attempts.session.write(Register.STOP, 1)
    assert not attempts.session.wait(300)[0]  # it goes on until its flag says otherwise
    assert len(attempts.session.segments()) > 3


def a_fault_halts_the_program(attempts: Attempts) -> None:
    attempts.launch(4)
    attempts.session.wait(3)
    attempts.session.write(Register.MODULE, 1)
    assert attempts.status().fault is Fault.LAUNCH_WHILE_BUSY
    attempts.session.clocks()
    for _ in range(30):
        attempts.session.read(Register.STATUS)
    attempts.session.segments()  # the one that ran
    for _ in range(300):
        attempts.session.read(Register.STATUS)
    assert attempts.session.segments() == []


def a_row_without_its_module_is_no_segment(attempts: Attempts) -> None:
    for number, words in enumerate(({4: 1}, {8: 0}, {16: 0}, {28: 0}), start=10):
        attempts.session.reset()
        attempts.row(number, {0: Module.PS})  # the memory keeps it, the reset forgets that it is there
        attempts.session.reset()
        attempts.sequence = 0
        attempts.row(number, words)
        attempts.frame(0, number, Control.PUBLISH)
        assert attempts.status().fault is Fault.WRONG_SEGMENT, words


def an_attempt_that_ended_names_no_segment(attempts: Attempts) -> None:
    attempts.launch()
    assert attempts.ended() == [1, 2]
    assert attempts.status().segment == 0


def a_segment_that_is_not_there_faults(attempts: Attempts) -> None:
    op, segment, entry = (INSTRUCTION_FIELDS[name] for name in ("op", "segment", "entry"))
    attempts.session.write(PROGRAM + PROGRAM_ENTRY * 4, op.put(Step.RUN) | segment.put(9) | entry.put(1))
    attempts.launch(4)
    attempts.session.wait(50)
    assert attempts.status().fault is Fault.WRONG_SEGMENT


CHECKS = (
    an_attempt_that_ended_names_no_segment, a_segment_that_is_not_there_faults, flags_decide, stop_ends_this_attempt_alone, stop_is_read_where_it_may_be, a_fault_halts_the_program,
    a_row_without_its_module_is_no_segment,
)  # fmt: skip


def wrong(harness: Path, option: str) -> Iterator[str]:
    """The checks that an engine does not pass."""
    for check in CHECKS:
        with RtlSession(harness, options=(option,)) as session:
            try:
                check(Attempts(session))
            except AssertionError as error:
                yield f"{check.__name__}: {error}"


def test_attempts_stop_faults_and_rows_are_as_documented(harness: Path) -> None:
    assert list(wrong(harness, "+none")) == []


@pytest.mark.parametrize("name", MUTATIONS)
def test_a_mutation_of_the_control_is_caught(name: str, harness: Path) -> None:
    mutation = MUTATIONS[name]
    assert (RTL / "engine" / f"{mutation.file}.sv").read_text().count(mutation.right) == 1
    assert any(wrong(harness, f"+mutant_{list(MUTATIONS).index(name):02}"))
