"""Whole attempts under the RTL's own control: Rust's words and stages, the schedules' cycles, the model's clocks."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from orbsoc import _core, solve
from orbsoc.hw.emulation import resident_program
from orbsoc.hw.schedules import pl_program
from orbsoc.ps.driver import Driver
from orbsoc.ps.events import Kind, PsRecord
from orbsoc.ps.registers import Control, Fault, Register, Status
from orbsoc.ps.segments import Method
from orbsoc.rtl.mutations import Mutation
from orbsoc.rtl.session import RtlPort, RtlSession
from orbsoc.rtl.solve import described, solve_on_rtl
from orbsoc.rtl.solve_cases import FOUR_LANES, TIGHT, SolvePoint, resident_solves, run_solves, shifted
from orbsoc.rtl.validation import built, problems
from tests.rtl.verilator import require_verilator
from tests.solving.restart_problems import WEAK, recovered_at_third_attempt

RTL = Path(__file__).parents[2] / "rtl"
SMALL = problems()["6 variables, cones 3"]
MIDDLE = problems()["24 variables, cones 3 3 9"]


STALLS_TWICE = SolvePoint("stalls twice", recovered_at_third_attempt(), WEAK, resident=True)
PIVOT = ("embedding", 3)
POINTS = [*resident_solves(), STALLS_TWICE, replace(STALLS_TWICE, format="compressed")]


@pytest.mark.parametrize("at", POINTS, ids=lambda at: f"{at.name}, {at.format}")
def test_solves_are_rusts_and_cycles_are_the_models(at: SolvePoint) -> None:
    require_verilator()
    (outcome,) = run_solves(RTL, [at])
    assert described(outcome) == []
    ends = {"infeasible": "PRIMAL_INFEASIBLE", "unbounded": "DUAL_INFEASIBLE"}
    assert outcome.status == ends.get(at.name, "SOLVED")
    assert abs(outcome.clock_error) <= 0.001
    stages = [launch.stage for launch in outcome.launches]
    assert any(stage.startswith("refine") for stage in stages) or not at.name.endswith("refined")
    if at.start is not None:
        assert solve(at.problem, at.settings, warm_start=at.start).warm_start == "used"
        assert "load_start" in stages
        assert not any("identity_blocks" in stage for stage in stages)  # no cold attempt


def test_a_rejected_warm_start_falls_back_on_the_rtl_as_in_rust() -> None:
    """On the PL the verdict alone says why the attempt ended; Rust's loop has it in its word for that, too. The pivot is an
    iteration's: where the first words are compared none has run, and the PL has there what its memory began with."""
    require_verilator()
    start, moved = solve(MIDDLE), shifted(MIDDLE, -1000.0)
    outcome = solve_on_rtl(RTL, "warm", moved, engine=FOUR_LANES, resident=True, start=start)
    assert outcome.same_stages
    assert outcome.same_solution
    assert (outcome.busy_error_cycles, outcome.assertions) == (0, 0)
    assert abs(outcome.clock_error) <= 0.001
    assert {(each.buffer, each.index) for each in outcome.differences} - {PIVOT} == {("control", 0)}
    assert solve(moved, warm_start=start).warm_start == "fell_back"
    stages = [launch.stage for launch in outcome.launches]
    assert stages.index("load_start") < stages.index("identity_blocks")


def ran_until_stopped(rtl: Path) -> list[str]:
    """Stages of an attempt whose stop bit the PS sets at once."""
    method, control = Method.from_core(_core, resident=True), resident_program()
    program = pl_program(SMALL, TIGHT, FOUR_LANES, None, control.streams)
    image, ps = _core.program_image(program.core, "flat"), _core.ExactEngine(SMALL, TIGHT, 64)
    with RtlSession(built(rtl, program.engine, "flat", lines=len(image.microcode), resident=True)) as session:
        session.reset()
        session.load(image, method, control)

        def carry(kind: Kind, buffer: str) -> None:
            if buffer in image.homes and kind is Kind.TO_PL:
                indices, addresses = image.homes[buffer]
                session.set_words(addresses, ps.words(buffer, indices))

        record = PsRecord()
        Driver(
            method, ps, RtlPort(session),
            words=ps.buffer_words(), record=record, carry=carry, program=control, stopped=lambda: True,
        ).run()  # fmt: skip
        numbers = {segment.number: stages for stages, segment in method.numbered(control).items()}
        return [stage for number, _ in session.segments() for stage in numbers[number]]


def test_the_stop_bit_ends_the_rtls_attempt_at_its_next_decision() -> None:
    require_verilator()
    ran = ran_until_stopped(RTL)
    assert ran.count("statistics") == 1
    assert (ran[-2], ran[-1]) == ("statistics", "unscale")


def test_a_stop_bit_that_is_not_read_is_noticed(tmp_path: Path) -> None:
    require_verilator()
    deaf = Mutation("engine/attempt.sv", "(instruction[2] && stop)", "1'b0").apply(RTL, tmp_path)
    assert ran_until_stopped(deaf).count("statistics") > 1


def test_an_attempt_from_no_entry_faults() -> None:
    require_verilator()
    method, control = Method.from_core(_core, resident=True), resident_program()
    program = pl_program(SMALL, TIGHT, FOUR_LANES, None, control.streams)
    image = _core.program_image(program.core, "flat")
    for entry, fault in ((1, Fault.WRONG_SEGMENT), (control.cold, Fault.READ_BEFORE_VALID)):
        with RtlSession(
            built(RTL, program.engine, "flat", lines=len(image.microcode), resident=True)
        ) as session:
            session.reset()
            session.load(image, method, control)
            for register, value in (
                (Register.MODULE, 0), (Register.SEGMENT, entry), (Register.SEQUENCE, 1), (Register.CONTROL, Control.ATTEMPT),
            ):  # fmt: skip
                session.write(register, int(value))
            session.wait(100)
            assert Status.decode(session.read(Register.STATUS)).fault is fault
