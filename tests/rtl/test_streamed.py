"""Streamed microcode: whole solves whose lines come from memory, cycle for cycle as the model has them, and what goes wrong there."""

from __future__ import annotations

import random
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import NamedTuple

import pytest

import orbsoc.rtl.solve as rtl_solve
from orbsoc import _core
from orbsoc.conic.settings import Settings
from orbsoc.hw.emulation import resident_program
from orbsoc.hw.schedules import Engine, pl_program
from orbsoc.ps.program import ControlProgram
from orbsoc.ps.registers import ENGINE_FIELDS, Fault, Module, Region, Register, Status, Wrapper
from orbsoc.ps.segments import Method
from orbsoc.rtl.digest import program_digest
from orbsoc.rtl.solve import SolveOutcome, solve_on_rtl
from orbsoc.rtl.solve_cases import SINGLE
from orbsoc.rtl.validation import ADDRESS_BITS, problems
from tests.rtl.axi_session import AxiSession, CDriver, InterruptedCDriver, built_behind_axi
from tests.rtl.c_driver import OK, WRONG_ENGINE
from tests.rtl.compressed import Compressor
from tests.rtl.engine_sources import RTL
from tests.rtl.machine import Machine, busy_cycles, random_program, schedule
from tests.rtl.verilator import require_verilator

PROBLEM = problems()["12 variables, cones 4 6"]
"""Some of its segments have more lines than a port holds."""
STREAMS = resident_program().streams


class Shape(NamedTuple):
    """An engine, its ports, and the settings of its solves."""

    engine: Engine
    ports: int
    beat: int
    settings: Settings


class Memory(NamedTuple):
    """Cycles from an address to the first beat; `beats` beats in `per` cycles."""

    latency: int
    beats: int
    per: int


SHAPES = {
    "2 lanes f32, 1 port": Shape(Engine(fp=32, lanes=2, banks=8, address_bits=ADDRESS_BITS), 1, 64, SINGLE),
    "4 lanes f32, 2 ports": Shape(Engine(fp=32, lanes=4, banks=16, address_bits=ADDRESS_BITS), 2, 64, SINGLE),
    "4 lanes f64, 1 port": Shape(Engine(lanes=4, banks=16, address_bits=ADDRESS_BITS), 1, 64, Settings()),
    "16 lanes f64 in 8 clusters, 4 ports of 128 bits": Shape(
        Engine(lanes=16, dividers=4, banks=32, clusters=8, address_bits=ADDRESS_BITS), 4, 128, Settings()
    ),
}
MEMORIES = {
    "at once": Memory(1, 1, 1),
    "after 60 cycles, three beats of four": Memory(60, 3, 4),
    "after 25 cycles, a beat of five": Memory(25, 1, 5),
}


class StreamedSession(AxiSession):
    """A session whose program lies in memory."""

    shape: Shape
    waits = "stream 1 1 1 0"

    def load(self, image: _core.ProgramImage, method: Method, program: ControlProgram | None = None) -> None:
        """The image of the engine that streams it has the same lines."""
        self.ask(self.waits)
        core = pl_program(PROBLEM, self.shape.settings, self.shape.engine, None, STREAMS).core
        super().load(_core.program_image(core, "compressed", stream=self.shape.ports), method, program)

    @staticmethod
    def _digest(image: _core.ProgramImage) -> int:
        return program_digest([int(word, 16) for word in image.templates], [])


def harness(shape: Shape) -> Path:
    require_verilator()
    return built_behind_axi(RTL, shape.engine, "compressed", lines=1, stream=shape.ports, beat=shape.beat)


def solved(
    monkeypatch: pytest.MonkeyPatch,
    shape: Shape,
    waits: str,
    driver: type[CDriver] = CDriver,
    session: type[StreamedSession] = StreamedSession,
) -> SolveOutcome:
    """A whole solve under resident control, with lines as the memory gives them."""
    require_verilator()
    session = type("Session", (session,), {"shape": shape, "waits": waits})
    monkeypatch.setattr(rtl_solve, "built", partial(built_behind_axi, stream=shape.ports, beat=shape.beat))
    monkeypatch.setattr(rtl_solve, "RtlSession", session)
    monkeypatch.setattr(rtl_solve, "Driver", driver)
    found = solve_on_rtl(
        RTL, "small", PROBLEM, shape.settings, engine=shape.engine, form="compressed", resident=True
    )
    assert (found.status, found.different_words, found.assertions) == ("SOLVED", 0, 0)
    assert found.same_stages
    assert found.same_solution
    assert found.words > 500
    return found


@pytest.mark.parametrize("memory", MEMORIES.values(), ids=MEMORIES)
@pytest.mark.parametrize("shape", SHAPES.values(), ids=SHAPES)
def test_a_solve_takes_the_modelled_cycles_and_has_the_hosts_bits(
    shape: Shape, memory: Memory, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = solved(monkeypatch, shape, f"stream {memory.latency} {memory.beats} {memory.per} 0")
    core = pl_program(PROBLEM, shape.settings, shape.engine, None, STREAMS).core
    stages = {each.stage for each in found.launches}
    modelled = {
        stage: core.demand(stage).cycles(ports=shape.ports, beat_bits=shape.beat, **memory._asdict())
        for stage in stages
    }
    assert len(stages) > 5
    assert {(each.stage, each.rtl_cycles) for each in found.launches} == set(modelled.items())
    on_chip = {each.stage: each.model_cycles for each in found.launches}
    assert all(cycles > on_chip[stage] for stage, cycles in modelled.items())


def test_it_has_them_with_any_waits(monkeypatch: pytest.MonkeyPatch) -> None:
    """Addresses and beats that wait by chance; the end of the attempt comes by interrupt."""
    shape = SHAPES["4 lanes f32, 2 ports"]
    found = solved(monkeypatch, shape, "stream 7 1 1 12345", InterruptedCDriver)
    assert all(each.rtl_cycles > each.model_cycles for each in found.launches)


def test_beats_that_come_after_a_reset_and_a_launch_are_dropped(monkeypatch: pytest.MonkeyPatch) -> None:
    """An attempt is reset before the memory answers, and a solve begun: its first segment asks for its lines when the old ones have
    come."""
    shape, late = SHAPES["4 lanes f32, 2 ports"], 200_000

    class Session(StreamedSession):
        def load(
            self, image: _core.ProgramImage, method: Method, program: ControlProgram | None = None
        ) -> None:
            super().load(image, method, program)
            launch(self)
            self.wait(100)
            self.reset()
            self.segments()
            self.waits = "stream 7 1 1 0"
            self.ask("image_next")
            super().load(image, method, program)

    found = solved(monkeypatch, shape, f"stream {late} 1 1 0", session=Session)
    first, *others = found.launches
    assert first.rtl_cycles > first.model_cycles + late // 2
    assert all(each.rtl_cycles < each.model_cycles + late // 2 for each in others)


class Measured(Compressor):
    """It also says how long the stream was."""

    bits = 0

    def _frozen(self, lengths: list[int], runs: list[int]) -> int:
        self.bits = sum(lengths)
        return super()._frozen(lengths, runs)


def test_a_stream_that_ends_with_its_last_line_needs_no_other() -> None:
    """The decoder looks for the kind and mask of a header that is shorter: behind the last line it gets anything."""
    shape = SHAPES["4 lanes f32, 2 ports"]
    machine = Machine(fp=32, lanes=4, banks=16, address_bits=ADDRESS_BITS)
    for seed in range(1000):
        ops, _ = random_program(machine, 6, seed)
        slots = schedule(machine, ops)
        words = max(slot.time for slot in slots) + 3  # without payload at its end
        compressor = Measured(machine, random.Random(1))
        lines, frozen = compressor.segment(slots, words)
        if -compressor.bits % compressor.line_bits < 2 + machine.lanes - 2:
            break
    opened = type("Session", (StreamedSession,), {"shape": shape})
    with opened(harness(shape)) as session:
        session.reset()
        session.ask("stream 9 1 1 0")
        session.ask_all(f"image_template {template:x}" for template in compressor.templates)
        session.ask_all(f"image_line {line:x}" for line in lines)
        for module in (Module.PS, Module.MATRIX_UPDATE):
            session.ask(f"image_segment {module:x} 0 0 0 0")
        digest = program_digest(compressor.templates, [])
        session.ask_all([f"image_identity {session.ask('identity')}", f"image_digest {digest:x}"])
        assert session.driver("load") == OK
        assert session.driver("publish 0") == OK
        assert session.driver("launch 1") == OK
        assert session.driver("interrupt 10000") == OK
        cycles = busy_cycles(machine, slots, words) + machine.numbers["DECODE_CYCLES"] + frozen
        assert session.segments() == [(1, cycles + 9 + 2)]


@pytest.fixture
def session() -> Iterator[StreamedSession]:
    shape = SHAPES["4 lanes f32, 2 ports"]
    opened = type("Session", (StreamedSession,), {"shape": shape})
    with opened(harness(shape)) as session:
        method, control = Method.from_core(_core, resident=True), resident_program()
        core = pl_program(PROBLEM, shape.settings, shape.engine, None, STREAMS).core
        session.reset()
        session.load(_core.program_image(core, "compressed"), method, control)
        yield session


def status(session: StreamedSession) -> Status:
    return Status.decode(session.read(Register.STATUS))


def launch(session: StreamedSession) -> None:
    """An attempt on whatever the storage holds: its first segment runs to its end."""
    assert session.driver("publish 0") == OK
    assert session.driver(f"attempt {resident_program().cold:x} 0 0") == OK


def test_the_wrapper_says_how_many_ports_it_has_and_takes_no_microcode(session: StreamedSession) -> None:
    engine = session.read(Wrapper.ENGINE)
    assert (ENGINE_FIELDS["stream"].of(engine), ENGINE_FIELDS["sequencer"].of(engine)) == (2, 3)
    assert session.ask(f"poke {Region.MICROCODE:x} 1") == "2"
    own = int(session.ask("identity"), 16)
    core = pl_program(PROBLEM, SINGLE, session.shape.engine, None, STREAMS).core
    for ports in (0, 1, 4):
        other = _core.program_image(core, "compressed", stream=ports)
        assert other.identity != own
        session.ask(f"image_identity {other.identity:x}")
        assert session.driver("load") == WRONG_ENGINE


def test_an_error_of_memory_is_a_fault_and_the_next_attempt_runs(session: StreamedSession) -> None:
    session.ask("stream 5 1 1 0")
    launch(session)
    session.driver("interrupt 100000")
    [first, *_] = session.segments()
    for beat in (0, 1, 40):
        session.reset()
        assert session.driver("load") == OK
        session.ask(f"stream_error {beat}")  # those before the reset have come
        launch(session)
        assert session.driver("interrupt 100000") == Fault.STREAM_ERROR
        assert status(session).fault is Fault.STREAM_ERROR
        session.segments()
    session.ask("stream_error -1")
    session.reset()
    assert session.driver("load") == OK
    launch(session)
    session.driver("interrupt 100000")
    assert session.segments()[0] == first


@pytest.mark.parametrize("clocks", [3, 8, 30, 61, 70])
def test_beats_under_way_at_a_reset_are_dropped(session: StreamedSession, clocks: int) -> None:
    """Also addresses that were not taken yet: the next attempt's first segment takes its own lines, in its own time."""
    session.ask("stream 60 1 2 0")
    launch(session)
    session.driver("interrupt 100000")
    [first, *_] = session.segments()
    session.reset()
    assert session.driver("load") == OK
    launch(session)
    session.wait(clocks)
    session.reset()
    session.segments()
    assert session.driver("load") == OK
    launch(session)
    session.driver("interrupt 100000")
    assert session.segments()[0] == first
