"""Whole attempts under the control of the emulated PL: the bits and events of `orbsoc.solve`, one interrupt an attempt."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest

from hw_model.platform.partition import load_partition
from hw_model.timing.actions import actions_of
from hw_model.timing.trace import parse_trace
from orbsoc import Cones, Problem, PsScheduler, Settings, Solution, _core, solve
from orbsoc.hw.emulation import resident_program
from orbsoc.ps.driver import Driver
from orbsoc.ps.events import Kind, PsRecord
from orbsoc.ps.pl import ProgrammableLogic
from orbsoc.ps.registers import Control, Fault, Module, Register, Status
from orbsoc.ps.segments import Method
from orbsoc.solving.solver import engine
from tests.solving.restart_problems import RECOVERED, STALLING, WEAK, badly_scaled, recovered_at_third_attempt

SMALL = Problem(
    c=[1.0, 0.0], A=[[1.0, 1.0]], b=[2.0], G=[[-1.0, 0.0], [0.0, -1.0]], h=[0.0, 0.0], cones=Cones(q=[2])
)
INFEASIBLE = Problem(c=[1.0], G=[[-1.0], [1.0]], h=[-2.0, 1.0], cones=Cones(l=2))
UNBOUNDED = Problem(c=[-1.0], G=[[-1.0]], h=[0.0], cones=Cones(l=1))
CASES = [
    (SMALL, Settings(), 1),
    (SMALL, Settings(refinement_share=1e-9, refinement_tol=1e-16), 1),
    (INFEASIBLE, Settings(), 1),
    (UNBOUNDED, Settings(), 1),
    (SMALL, Settings(max_iterations=2, max_restarts=0), 1),
    (badly_scaled(RECOVERED[0]), STALLING, 2),
    (recovered_at_third_attempt(), WEAK, 3),
]


def _same(found: Solution, wanted: Solution) -> None:
    assert (found.status, found.iterations, found.refinements) == (
        wanted.status, wanted.iterations, wanted.refinements,
    )  # fmt: skip
    for name in ("x", "y", "z", "s"):
        np.testing.assert_array_equal(getattr(found, name), getattr(wanted, name))


@pytest.mark.parametrize(("problem", "settings", "attempts"), CASES)
def test_bits_events_and_interrupts(problem: Problem, settings: Settings, attempts: int) -> None:
    resident, paper = PsScheduler(settings, resident=True), PsScheduler(settings)
    found = resident(problem)
    _same(found, paper(problem))
    _same(found, solve(problem, settings))
    [ours], [theirs] = resident.trace["solves"], paper.trace["solves"]
    assert ours["events"] == theirs["events"]
    ran = [stage for stream in ours["resident"] for stage in stream.split("+")]
    assert ran == [stage for stage, _ in ours["events"]]
    assert "resident" not in theirs
    counts = resident.record.counts()
    assert (counts[Kind.INTERRUPT], counts[Kind.LAUNCH], counts[Kind.RUN]) == (attempts, attempts, 0)


@pytest.mark.parametrize(("problem", "settings", "attempts"), CASES)
def test_the_model_charges_for_what_the_ps_did(problem: Problem, settings: Settings, attempts: int) -> None:
    ps = PsScheduler(settings, resident=True)
    ps(problem)
    trace = parse_trace(ps.trace)
    actions = actions_of(trace, load_partition("resident"))
    charged = Counter((a.work.what, a.work.side) for a in actions if a.work.kind == "copy")
    moved = Counter(
        (event.name, "pl" if event.kind is Kind.TO_PL else "ps")
        for event in ps.record
        if event.kind in (Kind.TO_PL, Kind.TO_PS) and event.value
    )
    assert moved == charged
    kinds, counts = Counter(action.work.kind for action in actions), ps.record.counts()
    flag_words = -(-len(trace.patterns[0].buffers) // 32)
    assert kinds["interrupt"] == kinds["launch"] == counts[Kind.INTERRUPT] == attempts
    assert counts[Kind.WRITE] == 4 * (kinds["launch"] + kinds["publish"]) + kinds["flags"]
    assert counts[Kind.READ] == (1 + flag_words) * (kinds["flags"] + kinds["publish"]) + kinds["rest"]
    segments = [a.work.what for a in actions if a.work.kind == "compute"]
    assert segments == list(trace.solves[0].resident or ())


def test_a_warm_start_and_one_that_is_rejected() -> None:
    near = solve(SMALL)
    moved = Problem(
        c=[1.0, 0.001],
        A=[[1.0, 1.0]],
        b=[2.0],
        G=[[-1.0, 0.0], [0.0, -1.0]],
        h=[0.0, 0.0],
        cones=Cones(q=[2]),
    )
    far = Problem(
        c=[1.0, 0.0], A=[[1.0, 1.0]], b=[2e4], G=[[-1.0, 0.0], [0.0, -1.0]], h=[0.0, 0.0], cones=Cones(q=[2])
    )
    fell_back = 0
    for problem in (moved, far):
        ps = PsScheduler(resident=True)
        found, wanted = ps(problem, warm_start=near), solve(problem, warm_start=near)
        _same(found, wanted)
        assert found.warm_start == wanted.warm_start
        fell_back += ps.record.counts()[Kind.LAUNCH] - 1
        segments = [
            a.work.what
            for a in actions_of(parse_trace(ps.trace), load_partition("resident"))
            if a.work.kind == "compute"
        ]
        assert segments == ps.trace["solves"][0]["resident"]
    assert fell_back == 1


def test_the_stop_bit_ends_an_attempt_at_its_next_decision() -> None:
    """Asked for from the first poll on: the PL ends at the first decision of kind stop, and closes."""
    method, native, record = Method.from_core(_core, resident=True), engine(SMALL, Settings()), PsRecord()
    pl = ProgrammableLogic(method, native.run, program=resident_program())
    Driver(
        method,
        native,
        pl,
        words=native.buffer_words(),
        record=record,
        program=resident_program(),
        stopped=lambda: True,
    ).run()
    ran = [stage for stream in pl.ran for stage in stream]
    assert ran.count("statistics") == 1
    assert (ran[-2], ran[-1]) == ("statistics", "unscale")
    assert record.counts()[Kind.INTERRUPT] == 1


@pytest.mark.parametrize(
    ("module", "segment", "fault"),
    [
        (Module.PS, 1, Fault.WRONG_SEGMENT),
        (Module.PS, 10_000, Fault.WRONG_SEGMENT),
        (Module.STATISTICS, 0, Fault.WRONG_SEGMENT),
        (Module.PS, 0, Fault.READ_BEFORE_VALID),
    ],
)
def test_an_attempt_without_an_entry_or_without_data_faults(
    module: Module, segment: int, fault: Fault
) -> None:
    pl = ProgrammableLogic(Method.from_core(_core, resident=True), lambda _: 0, program=resident_program())
    for register, value in (
        (Register.MODULE, module), (Register.SEGMENT, segment), (Register.SEQUENCE, 1), (Register.CONTROL, Control.ATTEMPT),
    ):  # fmt: skip
        pl.write(register, int(value))
    pl.tick()
    assert Status.decode(pl.read(Register.STATUS)).fault is fault
    assert pl.interrupt


def test_without_a_control_program_there_is_no_attempt() -> None:
    pl = ProgrammableLogic(Method.from_core(_core), lambda _: 0)
    for register, value in (
        (Register.MODULE, 0), (Register.SEGMENT, 0), (Register.SEQUENCE, 1), (Register.CONTROL, Control.ATTEMPT),
    ):  # fmt: skip
        pl.write(register, int(value))
    assert Status.decode(pl.read(Register.STATUS)).fault is Fault.INVALID_ACCESS
