"""The engine behind AXI: whole solves by the driver in C, bursts at full rate, and what the PL refuses."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial

import pytest

import orbsoc.rtl.solve as rtl_solve
from orbsoc import _core
from orbsoc.hw.schedules import Engine, pl_program
from orbsoc.ps.program import ControlProgram
from orbsoc.ps.registers import (
    ENGINE_FIELDS,
    INSTRUCTION_FIELDS,
    SIZES_FIELDS,
    Control,
    Fault,
    Module,
    Op,
    Region,
    Register,
    Status,
    Wrapper,
)
from orbsoc.ps.segments import Method
from orbsoc.rtl.digest import program_digest
from orbsoc.rtl.solve import described, solve_on_rtl
from orbsoc.rtl.solve_cases import SINGLE, TIGHT, TWO_LANES_F32
from orbsoc.rtl.validation import ADDRESS_BITS, RtlError, problems
from tests.rtl.axi_session import CODE_BITS, AxiSession, CDriver, InterruptedCDriver, built_behind_axi
from tests.rtl.c_driver import LAUNCH_TIMEOUT, OK, WRONG_ENGINE, WRONG_PROGRAM
from tests.rtl.engine_sources import RTL
from tests.rtl.verilator import require_verilator

SMALL = problems()["6 variables, cones 3"]
ONE_LANE = Engine(lanes=1, banks=4, address_bits=ADDRESS_BITS)
CLOCKS_DIFFER = re.compile(r"the model's clocks are off by -?[\d.]+ %")


@pytest.fixture
def session() -> Iterator[AxiSession]:
    require_verilator()
    with AxiSession(built_behind_axi(RTL, ONE_LANE, "flat", lines=1)) as opened:
        yield opened


def test_a_solve_by_the_c_driver_over_axi_is_the_one_of_the_engines_own_harness(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The same words, stages and busy cycles; only the clocks of moves and register accesses are AXI's."""
    require_verilator()
    own = solve_on_rtl(RTL, "small", SMALL, TIGHT, engine=ONE_LANE, resident=True)
    assert own.good
    monkeypatch.setattr(rtl_solve, "built", built_behind_axi)
    monkeypatch.setattr(rtl_solve, "RtlSession", AxiSession)
    monkeypatch.setattr(rtl_solve, "Driver", CDriver)
    outcome = solve_on_rtl(RTL, "small", SMALL, TIGHT, engine=ONE_LANE, resident=True)
    assert all(CLOCKS_DIFFER.match(line) for line in described(outcome)), described(outcome)
    assert outcome.launches == own.launches
    assert (outcome.words, outcome.different_words) == (own.words, 0)
    assert (outcome.same_stages, outcome.same_solution, outcome.assertions) == (True, True, 0)
    assert (outcome.status, outcome.iterations) == (own.status, own.iterations) == ("SOLVED", own.iterations)
    assert outcome.rtl_clocks > own.rtl_clocks


def test_so_is_one_in_binary32_from_compressed_microcode_with_parity_and_interrupts(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    require_verilator()
    seen: list[int] = []

    class Session(AxiSession):
        def load(
            self, image: _core.ProgramImage, method: Method, program: ControlProgram | None = None
        ) -> None:
            super().load(image, method, program)
            seen.append(ENGINE_FIELDS["parity"].of(self.read(Wrapper.ENGINE)))

    monkeypatch.setattr(rtl_solve, "built", partial(built_behind_axi, parity=True))
    monkeypatch.setattr(rtl_solve, "RtlSession", Session)
    monkeypatch.setattr(rtl_solve, "Driver", InterruptedCDriver)
    outcome = solve_on_rtl(
        RTL, "small", SMALL, SINGLE, engine=TWO_LANES_F32, form="compressed", resident=True
    )
    assert seen == [1]
    assert all(CLOCKS_DIFFER.match(line) for line in described(outcome)), described(outcome)
    assert (outcome.status, outcome.different_words, outcome.assertions) == ("SOLVED", 0, 0)
    assert outcome.words > 500


@pytest.mark.parametrize("size", [2, 3])
@pytest.mark.parametrize("seed", [0, 1])
def test_bursts_fill_and_read_the_engines_storage(session: AxiSession, size: int, seed: int) -> None:
    """Each burst is read back right behind its last beat: the wrapper must wait until it has settled."""
    different, _, _ = (int(word, 16) for word in session.ask(f"bursts {seed} {size}").split())
    assert different == 0


LINES = 600
"""Of microcode without an operation: a segment that runs that long."""
SEGMENT = 1


WIDTH = 1 + (4 * ADDRESS_BITS + 4) + (3 * ADDRESS_BITS + 2)
IDLE = program_digest([], [[0] * -(-WIDTH // 32)] * (LINES - 1) + [[1] + [0] * (-(-WIDTH // 32) - 1)])
"""Digest of its microcode."""


def say(session: AxiSession, identity: int, digest: int) -> None:
    session.ask_all([f"image_identity {identity:x}", f"image_digest {digest:x}"])


def load_idle_segment(session: AxiSession, instructions: Sequence[str] = ()) -> None:
    """A program of one segment that does nothing for a while, and a control program."""
    lines = [*["0"] * (LINES - 1), "1"]
    session.ask_all(f"image_line {line}" for line in lines)
    session.ask_all(
        [f"image_segment {Module.PS:x} 0 0 0 0", f"image_segment {Module.MATRIX_UPDATE:x} 0 0 0 0"]
    )
    session.ask_all(f"image_instruction {instruction}" for instruction in instructions)
    say(session, int(session.ask("identity"), 16), IDLE)
    assert session.driver("load") == OK
    assert session.driver("publish 0") == OK


def status(session: AxiSession) -> Status:
    return Status.decode(session.read(Register.STATUS))


def test_the_wrapper_says_which_engine_it_has(session: AxiSession) -> None:
    engine, sizes = session.read(Wrapper.ENGINE), session.read(Wrapper.SIZES)
    assert {name: field.of(engine) for name, field in ENGINE_FIELDS.items()} == {
        "lanes": 1, "binary64": 1, "dividers": 1, "sequencer": 0, "stream": 0, "resident": 1, "parity": 0, "fewer_words": 0,
    }  # fmt: skip
    bits = ONE_LANE.address_bits
    assert {name: field.of(sizes) for name, field in SIZES_FIELDS.items()} == {
        "address_bits": bits, "code_bits": CODE_BITS, "code_width": 1 + (4 * bits + 4) + (3 * bits + 2),
    }  # fmt: skip


def test_a_program_of_another_engine_or_another_than_was_sent_is_refused(session: AxiSession) -> None:
    load_idle_segment(session)
    own = int(session.ask("identity"), 16)
    for identity, digest, error in (
        (own ^ 1, IDLE, WRONG_ENGINE), (own, IDLE ^ 1, WRONG_PROGRAM), (own, IDLE, OK),
    ):  # fmt: skip
        say(session, identity, digest)
        assert session.driver("load") == error
    other = _core.program_image(pl_program(SMALL, TIGHT, replace(ONE_LANE, banks=8)).core, "flat")
    with pytest.raises(RtlError, match="1 lanes, 1 dividers, 8 banks in 1 clusters"):
        session.require_engine_of(other)
    _core.program_image(pl_program(SMALL, TIGHT, ONE_LANE).core, "flat").require_identity(own)


def test_memories_are_refused_while_a_segment_runs_and_its_cycles_are_counted(session: AxiSession) -> None:
    load_idle_segment(session)
    word, beyond = Region.STORAGE + 8 * 5, Region.STORAGE + (8 << ADDRESS_BITS)
    assert session.ask(f"poke {word:x} 1234") == "0"
    assert session.driver(f"launch {SEGMENT}") == OK
    assert status(session).busy
    assert session.ask(f"poke {word:x} 5678") == "2"
    assert session.ask(f"peek {word:x}") == "2 0"
    assert session.ask(f"poke {Region.MICROCODE:x} 1") == "2"
    assert session.ask(f"poke {Region.TEMPLATES:x} 1") == "2"
    assert status(session).busy
    assert session.driver("poll 1000") == OK
    assert session.ask(f"peek {word:x}") == "0 1234"
    for outside in (beyond, 3 << 24, Region.MICROCODE):
        assert session.ask(f"peek {outside:x}") == "2 0"
    [(number, cycles)] = session.segments()
    assert (number, cycles) == (SEGMENT, session.read(Wrapper.CYCLES))
    assert cycles > LINES
    assert session.driver(f"launch {SEGMENT}") == OK  # the microcode is the same as before
    assert session.driver("interrupt 10000") == OK
    assert session.segments() == [(SEGMENT, cycles)]
    assert session.driver("rest") == OK


def test_a_fault_of_the_engine_shows_and_memories_wait_for_its_sequencer(session: AxiSession) -> None:
    """STATUS is no longer busy after the fault, but the segment runs on."""
    load_idle_segment(session)
    assert session.driver(f"launch {SEGMENT}") == OK
    session.write(Register.MODULE, 1)
    assert status(session) == Status(fault=Fault.LAUNCH_WHILE_BUSY, sequence=1)
    assert session.ask("poke 28 1") == "2"
    assert session.wait(0)[0]
    assert session.driver("poll 10") == Fault.LAUNCH_WHILE_BUSY
    while not session.segments():
        session.read(Register.STATUS)
    assert session.ask("poke 28 1") == "0"
    session.reset()
    assert not session.wait(0)[0]
    assert session.driver("rest") == OK
    session.read(0x0500)
    assert status(session).fault is Fault.INVALID_ACCESS


def test_an_attempt_without_end_is_stopped_by_the_stop_bit_or_by_a_reset(session: AxiSession) -> None:
    fields = INSTRUCTION_FIELDS
    run = fields["op"].put(Op.RUN) | fields["segment"].put(SEGMENT) | fields["entry"].put(1)
    again = fields["op"].put(Op.UNLESS) | fields["stop"].put(1)
    load_idle_segment(session, [f"{run:x} 0", f"{again:x} 7", "0 0"])
    session.ask("set 7 0")
    assert session.driver("attempt 0 0 0") == OK
    assert session.driver("poll 400") == LAUNCH_TIMEOUT
    assert session.driver("interrupt 1000") == LAUNCH_TIMEOUT
    assert session.driver("stop") == OK
    assert session.driver("poll 400") == OK
    assert len(session.segments()) > 3
    assert session.driver("rest") == OK
    assert session.driver("attempt 0 0 0") == OK
    session.reset()
    assert session.driver("rest") == OK
    session.ask("set 7 1")
    assert session.ask("get 7") == "1"


def test_an_access_of_the_driver_that_the_pl_refuses_ends_the_session(session: AxiSession) -> None:
    """A control: the driver does not know of this launch, and writes a word."""
    load_idle_segment(session)
    frame = ((Register.MODULE, Module.MATRIX_UPDATE), (Register.SEGMENT, SEGMENT), (Register.SEQUENCE, 2))
    for register, value in (*frame, (Register.CONTROL, Control.START)):
        session.write(register, int(value))
    with pytest.raises(RtlError, match="a write to the memories was refused"):
        session.ask("set 5 1")
