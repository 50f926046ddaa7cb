"""Whole attempts under the RTL's own control: Rust's words and stages, the schedules' cycles, the model's clocks."""

from __future__ import annotations

from pathlib import Path

import pytest

from orbsoc import Cones, Problem, Settings, _core, solve
from orbsoc.hw.emulation import resident_program
from orbsoc.hw.schedules import pl_program
from orbsoc.ps.driver import Driver
from orbsoc.ps.events import Kind, PsRecord
from orbsoc.ps.registers import Control, Fault, Register, Status
from orbsoc.ps.segments import Method
from orbsoc.rtl.session import RtlPort, RtlSession
from orbsoc.rtl.solve import described, solve_on_rtl
from orbsoc.rtl.solve_cases import FOUR_LANES, SINGLE, TIGHT, TWO_LANES_F32
from orbsoc.rtl.validation import Format, built, problems
from tests.rtl.verilator import require_verilator
from tests.solving.restart_problems import WEAK, recovered_at_third_attempt

RTL = Path(__file__).parents[2] / "rtl"
SMALL = problems()["6 variables, cones 3"]
INFEASIBLE = Problem(c=[1.0], G=[[-1.0], [1.0]], h=[-2.0, 1.0], cones=Cones(l=2))
REFINED = Settings(tol=1e-10, static_regularization=1e-5, refinement_share=1e-6)


MIDDLE = problems()["24 variables, cones 3 3 9"]
UNBOUNDED = Problem(c=[-1.0], G=[[-1.0]], h=[0.0], cones=Cones(l=1))


@pytest.mark.parametrize(
    ("name", "problem", "settings", "status"),
    [
        ("small", SMALL, TIGHT, "SOLVED"),
        ("middle", MIDDLE, TIGHT, "SOLVED"),
        ("single", SMALL, SINGLE, "SOLVED"),
        ("refined", SMALL, REFINED, "SOLVED"),
        ("infeasible", INFEASIBLE, Settings(), "PRIMAL_INFEASIBLE"),
        ("unbounded", UNBOUNDED, Settings(), "DUAL_INFEASIBLE"),
        ("stalls twice", recovered_at_third_attempt(), WEAK, "SOLVED"),
    ],
)
@pytest.mark.parametrize("form", ["flat", "compressed"])
def test_solves_are_rusts_and_cycles_are_the_models(
    form: Format, name: str, problem: Problem, settings: Settings, status: str
) -> None:
    require_verilator()
    engine = TWO_LANES_F32 if name == "single" else FOUR_LANES
    outcome = solve_on_rtl(RTL, name, problem, settings, engine=engine, form=form, resident=True)
    assert described(outcome) == []
    assert outcome.status == status
    assert abs(outcome.clock_error) <= 0.001
    if name == "refined":
        assert any(launch.stage.startswith("refine") for launch in outcome.launches)


def moved(shift: float) -> Problem:
    """MIDDLE with another cost."""
    P, A, b, G, h, cones = MIDDLE.P, MIDDLE.A, MIDDLE.b, MIDDLE.G, MIDDLE.h, MIDDLE.cones
    return Problem(P=P, c=MIDDLE.c + shift, A=A, b=b, G=G, h=h, cones=cones)


@pytest.mark.parametrize("form", ["flat", "compressed"])
def test_warm_starts_are_rusts_and_cycles_are_the_models(form: Format) -> None:
    require_verilator()
    start = solve(MIDDLE)
    outcome = solve_on_rtl(RTL, "warm", moved(10.0), engine=FOUR_LANES, form=form, resident=True, start=start)
    assert described(outcome) == []
    assert abs(outcome.clock_error) <= 0.001
    assert (outcome.status, solve(moved(10.0), warm_start=start).warm_start) == ("SOLVED", "used")
    stages = [launch.stage for launch in outcome.launches]
    assert "load_start" in stages
    assert not any("identity_blocks" in stage for stage in stages)  # no cold attempt


def test_a_rejected_warm_start_falls_back_on_the_rtl_as_in_rust() -> None:
    """On the PL the verdict alone says why the attempt ended; Rust's loop has it in its word for that, too."""
    require_verilator()
    start = solve(MIDDLE)
    outcome = solve_on_rtl(RTL, "warm", moved(-1000.0), engine=FOUR_LANES, resident=True, start=start)
    assert outcome.same_stages
    assert outcome.same_solution
    assert (outcome.busy_error_cycles, outcome.assertions) == (0, 0)
    assert abs(outcome.clock_error) <= 0.001
    assert {(each.buffer, each.index) for each in outcome.differences} == {("control", 0)}
    assert solve(moved(-1000.0), warm_start=start).warm_start == "fell_back"
    stages = [launch.stage for launch in outcome.launches]
    assert stages.index("load_start") < stages.index("identity_blocks")


def test_the_stop_bit_ends_the_rtls_attempt_at_its_next_decision() -> None:
    require_verilator()
    method, control = Method.from_core(_core, resident=True), resident_program()
    program = pl_program(SMALL, TIGHT, FOUR_LANES, None, control.streams)
    image, ps = _core.program_image(program.core, "flat"), _core.ExactEngine(SMALL, TIGHT, 64)
    with RtlSession(built(RTL, program.engine, "flat", lines=len(image.microcode), resident=True)) as session:
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
        ran = [stage for number, _ in session.segments() for stage in numbers[number]]
    assert ran.count("statistics") == 1
    assert (ran[-2], ran[-1]) == ("statistics", "unscale")


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
