"""Every single register write of a run is perturbed in turn, in every way; no perturbed run may end well."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from orbsoc import _core
from orbsoc.conic.problem import Cones, Problem
from orbsoc.conic.settings import Settings
from orbsoc.ps.driver import Driver
from orbsoc.ps.events import Kind, PsRecord
from orbsoc.ps.pl import ProgrammableLogic
from orbsoc.ps.registers import (
    Control,
    LaunchTimeout,
    LaunchWhileBusy,
    LostWrite,
    ProtocolError,
    ReadBeforeValid,
    SpuriousAcknowledge,
    UnacknowledgedInterrupt,
    WriteOutOfOrder,
    WrongSegment,
    WrongSequence,
)
from orbsoc.ps.segments import Method
from tests.ps.fake_engine import METHOD, FakeEngine, prepare

Write = tuple[int, int]
Perturbation = Callable[[int, Write], list[Write]]
"""What reaches the PL in place of a write; the number counts from the write that is hit, which is 0."""


class FaultyRegisters:
    """The register file behind a bus that perturbs the writes from number `hit` on."""

    def __init__(self, pl: ProgrammableLogic, hit: int, perturb: Perturbation) -> None:
        self._pl, self._next, self._perturb = pl, -hit, perturb
        self.read, self.tick = pl.read, pl.tick

    @property
    def interrupt(self) -> bool:
        return self._pl.interrupt

    def write(self, address: int, value: int) -> None:
        for write in self._perturb(self._next, (address, value)):
            self._pl.write(*write)
        self._next += 1


def untouched(number: int, write: Write) -> list[Write]:
    return [write]


def drop(number: int, write: Write) -> list[Write]:
    return [] if number == 0 else [write]


def repeat(number: int, write: Write) -> list[Write]:
    return [write, write] if number == 0 else [write]


def flip(bit: int) -> Perturbation:
    return lambda number, write: [(write[0], write[1] ^ (1 << bit))] if number == 0 else [write]


def overtaken_by(count: int) -> Perturbation:
    """The write arrives only after the next `count` writes, or never if the run ends before."""
    held: list[Write] = []

    def perturb(number: int, write: Write) -> list[Write]:
        if number == 0:
            held.append(write)
            return []
        return [write, *held] if number == count else [write]

    return perturb


def replayed_after(count: int, replay: int) -> Perturbation:
    """The first `replay` writes come a second time after the first `count`."""
    kept: list[Write] = []

    def perturb(number: int, write: Write) -> list[Write]:
        if 0 <= number < replay:
            kept.append(write)
        return [write, *kept] if number == count - 1 else [write]

    return perturb


def writes_of(iterations: int) -> list[tuple[str, int]]:
    """Register and word of every write of a healthy run."""
    run = prepare(FakeEngine(iterations))
    run.driver.run()
    return [(event.name, event.value) for event in run.record.of(Kind.WRITE)]


ONE_ITERATION = writes_of(1)
WRITES = writes_of(2)


def error_of(hit: int, perturb: Perturbation, iterations: int = 2) -> ProtocolError:
    """The error of the run whose write number `hit` is perturbed."""
    run = prepare(FakeEngine(iterations), between=lambda pl: FaultyRegisters(pl, hit, perturb), busy_ticks=2)
    with pytest.raises(ProtocolError) as caught:
        run.driver.run()
    return caught.value


def expected(
    hit: int, *, start: type[ProtocolError], publish: type[ProtocolError], acknowledge: type[ProtocolError]
) -> type[ProtocolError]:
    """The error that belongs to the register of a write; those before CONTROL are told by their order."""
    name, value = WRITES[hit]
    if name == "CONTROL":
        return start if value == Control.START else publish
    return acknowledge if name == "IRQ_ACK" else WriteOutOfOrder


def test_the_run_that_is_perturbed_has_every_kind_of_write() -> None:
    assert {name for name, _ in WRITES} == {"MODULE", "SEGMENT", "SEQUENCE", "CONTROL", "IRQ_ACK"}
    assert {value for name, value in WRITES if name == "CONTROL"} == {Control.START, Control.PUBLISH}
    assert {value for name, value in WRITES if name == "SEGMENT"} == {s.number for s in METHOD.segments}


def test_a_bus_without_faults_changes_nothing() -> None:
    run = prepare(between=lambda pl: FaultyRegisters(pl, 0, untouched), busy_ticks=2)
    run.driver.run()
    assert [(event.name, event.value) for event in run.record.of(Kind.WRITE)] == WRITES


@pytest.mark.parametrize("hit", range(len(WRITES)))
def test_a_dropped_write_raises(hit: int) -> None:
    error = expected(hit, start=LaunchTimeout, publish=LostWrite, acknowledge=UnacknowledgedInterrupt)
    assert type(error_of(hit, drop)) is error


@pytest.mark.parametrize("hit", range(len(WRITES)))
def test_a_repeated_write_raises(hit: int) -> None:
    error = expected(hit, start=LaunchWhileBusy, publish=WriteOutOfOrder, acknowledge=SpuriousAcknowledge)
    assert type(error_of(hit, repeat)) is error


@pytest.mark.parametrize("count", [1, 2, 3, 4, 9])
@pytest.mark.parametrize("hit", range(len(WRITES)))
def test_a_write_overtaken_by_later_ones_raises(hit: int, count: int) -> None:
    error = expected(hit, start=LaunchTimeout, publish=LostWrite, acknowledge=UnacknowledgedInterrupt)
    assert type(error_of(hit, overtaken_by(count))) is error


@pytest.mark.parametrize("bit", range(32))
def test_a_write_with_one_wrong_bit_raises(bit: int) -> None:
    for hit, (name, _) in enumerate(ONE_ITERATION):
        error = type(error_of(hit, flip(bit), iterations=1))
        if name == "SEQUENCE":
            assert error is WrongSequence
        elif name == "IRQ_ACK":
            assert error is SpuriousAcknowledge
        elif name == "MODULE":
            assert error is WrongSegment
        elif (
            name == "SEGMENT"
        ):  # another segment of the module is refused for its reads, or found to have run
            assert error in (WrongSegment, ReadBeforeValid)


@pytest.mark.parametrize("launch", range(4))
def test_a_frame_that_comes_twice_as_a_whole_raises(launch: int) -> None:
    """Every write in its order: only the launch counter tells."""
    acknowledged = [k for k, (name, _) in enumerate(WRITES) if name == "IRQ_ACK"][launch]
    error = error_of(acknowledged - 4, replayed_after(count=5, replay=4))
    assert type(error) is WrongSequence


def test_the_error_names_the_stage_and_the_launch() -> None:
    hit = WRITES.index(("CONTROL", Control.START))
    assert "stage 'scale', launch 2" in str(error_of(hit, drop))


def solve_behind(hit: int, perturb: Perturbation) -> PsRecord:
    """One iteration of the real solver behind a faulty bus."""
    problem = Problem(
        c=[1.0, 2.0], A=[[1.0, 1.0]], b=[1.0], G=[[-1.0, 0.0], [0.0, -1.0]], h=[0, 0], cones=Cones(l=2)
    )
    method, engine = Method.from_core(_core), _core.Engine(problem, Settings(max_iterations=1))
    bus = FaultyRegisters(ProgrammableLogic(method, engine.run), hit, perturb)
    record = PsRecord()
    Driver(method, engine, bus, words=engine.buffer_words(), record=record, poll_budget=3).run()
    return record


@pytest.mark.parametrize(
    "faulty",
    [lambda: drop, lambda: repeat, lambda: overtaken_by(1), lambda: overtaken_by(2)],
    ids=["dropped", "repeated", "overtaken by the next", "overtaken by the next two"],
)
def test_any_write_of_the_real_solver_perturbed_raises(faulty: Callable[[], Perturbation]) -> None:
    writes = len(solve_behind(0, untouched).of(Kind.WRITE))
    assert writes > 100
    for hit in range(writes):
        with pytest.raises(ProtocolError):
            solve_behind(hit, faulty())
