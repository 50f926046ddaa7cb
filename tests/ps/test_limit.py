"""The limit on a launch's clocks in the emulated PL, and the most that a launch can take."""

from __future__ import annotations

from collections import Counter

import pytest

from orbsoc import _core
from orbsoc.conic.settings import Settings
from orbsoc.hw.busy_clocks import busy_clocks, clocks_of, most_clocks
from orbsoc.hw.emulation import PsScheduler, resident_program
from orbsoc.hw.schedules import Engine
from orbsoc.ps.pl import ProgrammableLogic
from orbsoc.ps.program import BusyClocks, ControlProgram
from orbsoc.ps.registers import (
    Control,
    CycleLimit,
    Fault,
    InvalidAccess,
    Module,
    Register,
    Status,
    Wrapper,
)
from orbsoc.ps.segments import Method
from orbsoc.rtl.validation import problems
from tests.ps.fake_engine import METHOD, FakeEngine, prepare

SMALL = problems()["6 variables, cones 3"]
ENGINE = Engine(lanes=1, banks=4)
SCALE = next(segment for segment in METHOD.segments if segment.stage == "scale")
CLOCKS = BusyClocks({("scale",): 100}, launch=1, run=3, branch=7, end=2)


def frame(pl: ProgrammableLogic, *values: int) -> None:
    registers = (Register.MODULE, Register.SEGMENT, Register.SEQUENCE, Register.CONTROL)
    for register, value in zip(registers, values, strict=True):
        pl.write(register, int(value))


@pytest.mark.parametrize(("limit", "stopped"), [(0, False), (101, False), (100, True), (1, True)])
def test_a_segment_that_takes_more_is_stopped_before_it_has_run(limit: int, stopped: bool) -> None:
    engine = FakeEngine()
    pl = ProgrammableLogic(METHOD, engine.run, clocks=CLOCKS)
    pl.write(Wrapper.LIMIT, limit)
    frame(pl, Module.PS, 0, 1, Control.PUBLISH)
    frame(pl, SCALE.module, SCALE.number, 2, Control.START)
    pl.tick()
    assert pl.interrupt
    assert pl.read(Wrapper.LIMIT) == limit
    assert pl.read(Wrapper.SPENT) == (limit + 1 if stopped else 101)
    status = Status.decode(pl.read(Register.STATUS))
    if stopped:
        assert status == Status(fault=Fault.CYCLE_LIMIT)
        assert (pl.read(Register.DATA_VALID), engine.ran) == (0, [])
    else:
        assert status == Status(done=True, segment=SCALE.number, sequence=2)


def test_without_clocks_there_is_no_limit() -> None:
    pl = ProgrammableLogic(METHOD, FakeEngine().run)
    pl.write(Wrapper.LIMIT, 5)
    assert Status.decode(pl.read(Register.STATUS)).fault is Fault.INVALID_ACCESS
    run = prepare()
    run.driver._limit_clocks = 5
    with pytest.raises(InvalidAccess):
        run.driver.run()


class Worst:
    """Answers of stages that use every iteration and refinement step, by counters of its own."""

    def __init__(self, settings: Settings, method: Method) -> None:
        self.kinds = {stage: kind for stage, (kind, _) in method.flags.items()}
        self.settings, self.ran = settings, Counter[str]()
        self.in_turn = 0

    def __call__(self, stage: str) -> int:
        self.ran[stage] += 1
        if stage == "statistics":
            return int(self.ran[stage] > self.settings.max_iterations)
        if self.kinds.get(stage) == "repeat":
            self.in_turn = (self.in_turn + 1) % (self.settings.refinement_max + 1)
            return int(self.in_turn != 0)
        return 0


@pytest.mark.parametrize("joined", [False, True])
@pytest.mark.parametrize(("iterations", "refinements"), [(1, 0), (3, 2), (5, 10)])
def test_the_most_clocks_are_those_of_the_worst_attempt(
    iterations: int, refinements: int, joined: bool
) -> None:
    settings = Settings(max_iterations=iterations, refinement_max=refinements)
    method, program = Method.from_core(_core, resident=True), resident_program(joined=joined)
    clocks = clocks_of({stream: 10 + 7 * k for k, stream in enumerate(program.streams)})
    most = most_clocks(clocks, settings, program)
    spent = [_attempt(method, program, clocks, settings, entry) for entry in (program.cold, program.warm)]
    assert most == max(spent)


def _attempt(
    method: Method, program: ControlProgram, clocks: BusyClocks, settings: Settings, entry: int
) -> int:
    worst = Worst(settings, method)
    pl = ProgrammableLogic(method, worst, program=program, clocks=clocks)
    pl._valid = (1 << len(method.buffers)) - 1  # what it reads is another test's
    frame(pl, Module.PS, entry, 1, Control.ATTEMPT)
    while not pl.interrupt:
        pl.tick()
    assert Status.decode(pl.read(Register.STATUS)).done
    assert worst.ran["statistics"] == settings.max_iterations + 1
    return pl.read(Wrapper.SPENT)


def test_of_segments_the_longest_counts_and_a_register_holds_it() -> None:
    assert most_clocks(CLOCKS, Settings()) == 101
    program = resident_program()
    huge = clocks_of(dict.fromkeys(program.streams, 1 << 30))
    assert most_clocks(huge, Settings(), program) == (1 << 32) - 1


@pytest.mark.parametrize("resident", [False, True])
def test_a_solve_within_its_limit_ends_and_one_beyond_it_is_stopped(resident: bool) -> None:
    streams = resident_program().streams if resident else ()
    clocks = busy_clocks(SMALL, Settings(), ENGINE, streams=streams)
    most = most_clocks(clocks, Settings(), resident_program() if resident else None)
    enough = PsScheduler(resident=resident, engine=ENGINE, limit_clocks=most)
    assert enough(SMALL).status.name == "SOLVED"
    few = PsScheduler(resident=resident, engine=ENGINE, limit_clocks=min(clocks.segments.values()))
    with pytest.raises(
        CycleLimit, match=r"stage '(attempt|equilibrate)', launch 2: the PL reports CYCLE_LIMIT"
    ):
        few(SMALL)


@pytest.mark.parametrize("limit", [0, -1, 1 << 32, 2.5])
def test_a_limit_that_no_register_holds_names_what_is_allowed(limit: int) -> None:
    with pytest.raises(
        ValueError, match=f"limit_clocks = {limit}: allowed is a whole number from 1 to 4294967295"
    ):
        PsScheduler(engine=ENGINE, limit_clocks=limit)


def test_a_limit_needs_the_engine_whose_clocks_it_counts() -> None:
    with pytest.raises(ValueError, match="limit_clocks = 5 with engine = None: give both, or neither"):
        PsScheduler(limit_clocks=5)
