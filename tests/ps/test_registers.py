"""The register map and the PL's side of the protocol, driven by hand."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from orbsoc.ps.pl import ProgrammableLogic
from orbsoc.ps.registers import ERROR_OF_FAULT, Control, Fault, Module, Register, Status
from orbsoc.ps.segments import Method
from tests.ps.fake_engine import DONE, ITERATION, METHOD, NEXT, REPEAT, STAGES, STARTUP, FakeEngine, Stage

NUMBER = {segment.stage: segment.number for segment in METHOD.segments}
MODULE = {segment.stage: segment.module for segment in METHOD.segments}


def fresh(busy_ticks: int = 1) -> tuple[ProgrammableLogic, FakeEngine]:
    engine = FakeEngine()
    return ProgrammableLogic(METHOD, engine.run, busy_ticks=busy_ticks), engine


def frame(pl: ProgrammableLogic, stage: str, sequence: int, command: int) -> None:
    for register, value in zip(Register, (MODULE[stage], NUMBER[stage], sequence, command), strict=False):
        pl.write(register, value)


def load(pl: ProgrammableLogic) -> None:
    frame(pl, "problem data", 1, Control.PUBLISH)


def status(pl: ProgrammableLogic) -> Status:
    return Status.decode(pl.read(Register.STATUS))


def valid(pl: ProgrammableLogic) -> set[str]:
    return set(METHOD.names(pl.read(Register.DATA_VALID)))


@given(
    st.builds(
        Status,
        busy=st.booleans(),
        done=st.booleans(),
        armed=st.booleans(),
        outcome=st.integers(0, 3),
        fault=st.sampled_from(Fault),
        segment=st.integers(0, 255),
        sequence=st.integers(0, 255),
    )
)
def test_status_word_holds_every_field(given_status: Status) -> None:
    word = given_status.encode()
    assert 0 <= word < 2**32
    assert Status.decode(word) == given_status


def test_every_fault_has_its_own_error() -> None:
    assert set(ERROR_OF_FAULT) == set(Fault) - {Fault.NONE}
    assert len(set(ERROR_OF_FAULT.values())) == len(ERROR_OF_FAULT)


def test_loading_the_problem_raises_the_flags_of_what_no_stage_writes() -> None:
    pl, _ = fresh()
    assert valid(pl) == set()
    load(pl)
    assert valid(pl) == {"data", "settings"}
    assert not pl.interrupt


def test_a_segment_is_busy_then_done_and_its_flags_move_only_at_its_end() -> None:
    pl, engine = fresh(busy_ticks=3)
    load(pl)
    frame(pl, "scale", 2, Control.START)
    assert status(pl).busy
    for _ in range(2):
        pl.tick()
        assert (engine.ran, pl.interrupt, valid(pl)) == ([], False, {"data", "settings"})
    pl.tick()
    assert engine.ran == ["scale"]
    assert valid(pl) == {"data", "settings", "scaled"}
    assert (status(pl).done, status(pl).busy, pl.interrupt) == (True, False, True)
    assert (status(pl).segment, status(pl).sequence) == (NUMBER["scale"], 2)
    pl.write(Register.IRQ_ACK, 2)
    assert (status(pl).done, pl.interrupt) == (False, False)


def test_a_relaunched_segment_lowers_the_flags_it_will_write_while_it_runs() -> None:
    pl, _ = fresh()
    load(pl)
    frame(pl, "scale", 2, Control.START)
    pl.tick()
    pl.write(Register.IRQ_ACK, 2)
    frame(pl, "scale", 3, Control.START)
    assert "scaled" not in valid(pl)


def test_stale_buffers_lose_their_flag_when_the_stage_ends() -> None:
    pl, _ = fresh()
    load(pl)
    sequence = 1
    for stage in ("scale", "load", "start", "update", "factorize", "solve", "factorize"):
        sequence += 1
        if MODULE[stage] is Module.PS:
            frame(pl, stage, sequence, Control.PUBLISH)
            continue
        frame(pl, stage, sequence, Control.START)
        pl.tick()
        pl.write(Register.IRQ_ACK, sequence)
        assert ("direction" in valid(pl)) == (stage == "solve")
    assert status(pl).fault is Fault.NONE


def test_a_buffer_left_unfinished_may_be_updated_but_not_read() -> None:
    pl, _ = fresh()
    load(pl)
    for sequence, stage in ((2, "scale"), (3, "load")):
        frame(pl, stage, sequence, Control.START)
        pl.tick()
        pl.write(Register.IRQ_ACK, sequence)
    assert "kkt" not in valid(pl)
    frame(pl, "start", 4, Control.PUBLISH)
    frame(pl, "update", 5, Control.START)
    pl.tick()
    assert "kkt" in valid(pl)
    assert status(pl).fault is Fault.NONE


@pytest.mark.parametrize("stage", ["update", "factorize"])
def test_a_buffer_never_written_may_be_neither_updated_nor_read(stage: str) -> None:
    pl, engine = fresh()
    load(pl)
    frame(pl, "scale", 2, Control.START)
    pl.tick()
    pl.write(Register.IRQ_ACK, 2)
    frame(pl, "start", 3, Control.PUBLISH)
    frame(pl, stage, 4, Control.START)
    pl.tick()
    assert status(pl).fault is Fault.READ_BEFORE_VALID
    assert engine.ran == ["scale"]


@pytest.mark.parametrize("busy", [Register.MODULE, Register.CONTROL, Register.IRQ_ACK])
def test_any_write_while_a_segment_runs_is_launch_while_busy(busy: Register) -> None:
    pl, engine = fresh()
    load(pl)
    frame(pl, "scale", 2, Control.START)
    pl.write(busy, 1)
    assert status(pl).fault is Fault.LAUNCH_WHILE_BUSY
    pl.tick()
    assert engine.ran == []
    assert pl.interrupt


@pytest.mark.parametrize(
    ("writes", "fault"),
    [
        ([(Register.SEGMENT, 1)], Fault.WRITE_OUT_OF_ORDER),
        ([(Register.MODULE, 2), (Register.MODULE, 2)], Fault.WRITE_OUT_OF_ORDER),
        ([(Register.CONTROL, 1)], Fault.WRITE_OUT_OF_ORDER),
        ([(Register.IRQ_ACK, 1)], Fault.SPURIOUS_ACKNOWLEDGE),
        ([(Register.STATUS, 0)], Fault.INVALID_ACCESS),
        ([(Register.DATA_VALID, 0xFF)], Fault.INVALID_ACCESS),
        ([(0x1000, 0)], Fault.INVALID_ACCESS),
    ],
)
def test_a_write_out_of_turn_is_its_own_fault(writes: list[tuple[int, int]], fault: Fault) -> None:
    pl, _ = fresh()
    load(pl)
    for address, value in writes:
        pl.write(address, value)
    assert status(pl).fault is fault


@pytest.mark.parametrize(
    ("module", "segment", "sequence", "command", "fault"),
    [
        (Module.FACTORIZATION, NUMBER["scale"], 2, Control.START, Fault.WRONG_SEGMENT),
        (Module.MATRIX_SCALING, 99, 2, Control.START, Fault.WRONG_SEGMENT),
        (Module.MATRIX_SCALING, NUMBER["scale"], 2, Control.PUBLISH, Fault.WRONG_SEGMENT),
        (Module.PS, NUMBER["check"], 2, Control.START, Fault.WRONG_SEGMENT),
        (Module.MATRIX_SCALING, NUMBER["scale"], 1, Control.START, Fault.WRONG_SEQUENCE),
        (Module.MATRIX_SCALING, NUMBER["scale"], 3, Control.START, Fault.WRONG_SEQUENCE),
        (Module.FACTORIZATION, NUMBER["factorize"], 2, Control.START, Fault.READ_BEFORE_VALID),
        (Module.MATRIX_SCALING, NUMBER["scale"], 2, 3, Fault.INVALID_ACCESS),
        (Module.MATRIX_SCALING, NUMBER["scale"], 2, 0, Fault.INVALID_ACCESS),
    ],
)
def test_a_wrong_frame_is_refused_before_anything_runs(
    module: int, segment: int, sequence: int, command: int, fault: Fault
) -> None:
    pl, engine = fresh()
    load(pl)
    for register, value in zip(Register, (module, segment, sequence, command), strict=False):
        pl.write(register, value)
    pl.tick()
    assert status(pl).fault is fault
    assert engine.ran == []


def test_the_first_fault_stays() -> None:
    pl, _ = fresh()
    pl.write(Register.SEGMENT, 1)
    pl.write(Register.IRQ_ACK, 1)
    frame(pl, "problem data", 1, Control.PUBLISH)
    assert status(pl).fault is Fault.WRITE_OUT_OF_ORDER
    assert valid(pl) == set()


def test_an_interrupt_must_be_acknowledged_with_its_own_launch() -> None:
    pl, _ = fresh()
    load(pl)
    frame(pl, "scale", 2, Control.START)
    pl.tick()
    pl.write(Register.IRQ_ACK, 1)
    assert status(pl).fault is Fault.SPURIOUS_ACKNOWLEDGE


def test_reading_an_address_that_does_not_exist_is_a_fault() -> None:
    pl, _ = fresh()
    beyond = Register.DATA_VALID + 4
    assert pl.read(beyond) == 0
    assert status(pl).fault is Fault.INVALID_ACCESS


def test_flags_of_more_than_32_buffers_go_to_further_words() -> None:
    names = tuple(f"b{k}" for k in range(70))
    stages = {"fill": Stage("cone_ops", reads=("b0",), writes=names[1:])}
    method = Method.from_tables(startup=(), iteration=[("fill",)], stages=stages, repeat=REPEAT, done=DONE)
    pl = ProgrammableLogic(method, lambda stage: NEXT)
    for register, value in zip(Register, (Module.PS, 0, 1, Control.PUBLISH), strict=False):
        pl.write(register, value)
    for register, value in zip(Register, (Module.CONE_OPS, 1, 2, Control.START), strict=False):
        pl.write(register, value)
    pl.tick()
    words = [pl.read(Register.DATA_VALID + 4 * k) for k in range(3)]
    assert words == [2**32 - 1, 2**32 - 1, 2**6 - 1]


def test_a_table_that_contradicts_its_lists_is_refused() -> None:
    with pytest.raises(ValueError, match="'polish' is in a step list"):
        Method.from_tables(
            startup=STARTUP, iteration=[*ITERATION, ("polish",)], stages=STAGES, repeat=1, done=2
        )
    with pytest.raises(ValueError, match="module 'gpu'; known are ps, matrix_update"):
        Method.from_tables(startup=(), iteration=(), stages={"a": Stage("gpu")}, repeat=1, done=2)


def test_a_segment_cannot_take_no_time() -> None:
    with pytest.raises(ValueError, match="busy_ticks = 0"):
        fresh(busy_ticks=0)
