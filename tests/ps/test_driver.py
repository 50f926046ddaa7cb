"""A whole run on a healthy computer: same stages as the plain loop, and the record that belongs to it."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

import orbsoc.ps
from orbsoc.ps.events import Kind
from orbsoc.ps.pl import ProgrammableLogic
from orbsoc.ps.registers import LaunchTimeout, LostInterrupt, ReadBeforeValid
from orbsoc.ps.segments import Method
from tests.ps.fake_engine import (
    DONE,
    REPEAT,
    STAGES,
    STARTUP,
    WORDS,
    FakeEngine,
    Stage,
    prepare,
)


@pytest.mark.parametrize("iterations", [1, 2, 7])
@pytest.mark.parametrize("refinements", [0, 1, 3])
@pytest.mark.parametrize("busy_ticks", [1, 4])
def test_the_scheduled_run_is_the_plain_loop(iterations: int, refinements: int, busy_ticks: int) -> None:
    plain = FakeEngine(iterations, refinements)
    plain.solve()
    run = prepare(FakeEngine(iterations, refinements), busy_ticks=busy_ticks)
    run.driver.run()
    assert run.engine.ran == plain.ran
    assert run.engine.state == plain.state


def test_done_ends_the_iteration_where_it_is_and_the_closing_stages_still_run() -> None:
    class DoneAfterFactorize(FakeEngine):
        def run(self, stage: str) -> int:
            outcome = super().run(stage)
            return DONE if stage == "factorize" else outcome

    run = prepare(DoneAfterFactorize())
    run.driver.run()
    assert run.engine.ran == ["scale", "load", "start", "update", "factorize", "unscale"]


def test_each_launch_costs_five_writes_and_each_published_stage_four() -> None:
    run = prepare(FakeEngine(iterations=3, refinements=2))
    run.driver.run()
    counts = run.record.counts()
    on_pl = sum(STAGES[stage].module != "ps" for stage in run.engine.ran)
    on_ps = len(run.engine.ran) - on_pl
    assert (counts[Kind.LAUNCH], counts[Kind.RUN], counts[Kind.INTERRUPT]) == (on_pl, on_ps, on_pl)
    assert counts[Kind.WRITE] == 5 * on_pl + 4 * (on_ps + 1)  # + 1: the problem data
    assert counts[Kind.READ] == 2 * (on_pl + on_ps + 1) + 1  # + 1: at rest at the end
    assert sum(counts.values()) == len(run.record) == len(list(run.record))


def test_launches_and_runs_are_recorded_in_the_order_of_the_stages() -> None:
    run = prepare()
    run.driver.run()
    stages = [event for event in run.record if event.kind in (Kind.LAUNCH, Kind.RUN)]
    assert [event.name for event in stages] == run.engine.ran
    assert [event.value for event in stages] == list(range(2, len(stages) + 2))  # 1 is the problem data
    assert {event.kind is Kind.RUN for event in stages if STAGES[event.name].module == "ps"} == {True}


def test_the_acts_of_one_launch_come_in_the_order_of_the_protocol() -> None:
    run = prepare(busy_ticks=3)
    run.driver.run()
    events = list(run.record)
    first = next(k for k, event in enumerate(events) if event.kind is Kind.LAUNCH)
    acts = [(event.kind, event.name) for event in events[first - 5 : first + 5]]
    assert acts == [
        (Kind.TO_PL, "data"),
        (Kind.WRITE, "MODULE"),
        (Kind.WRITE, "SEGMENT"),
        (Kind.WRITE, "SEQUENCE"),
        (Kind.WRITE, "CONTROL"),
        (Kind.LAUNCH, "scale"),
        (Kind.INTERRUPT, "scale"),
        (Kind.READ, "STATUS"),
        (Kind.READ, "DATA_VALID"),
        (Kind.WRITE, "IRQ_ACK"),
    ]
    assert events[first + 1].value == 3


def test_buffers_move_once_to_the_side_that_reads_them() -> None:
    run = prepare(FakeEngine(iterations=2, refinements=0))
    run.driver.run()
    moves = [(e.kind, e.name) for e in run.record if e.kind in (Kind.TO_PL, Kind.TO_PS)]
    assert moves == [
        (Kind.TO_PL, "data"),
        (Kind.TO_PS, "scaled"),
        (Kind.TO_PL, "point"),  # written by `start` on the PS
        (Kind.TO_PS, "kkt"),
        (Kind.TO_PS, "direction"),
        (Kind.TO_PS, "point"),  # written by `advance` on the PL; `settings` never leaves the PS
        (Kind.TO_PS, "kkt"),
        (Kind.TO_PS, "direction"),
        (Kind.TO_PS, "point"),
        (Kind.TO_PS, "answer"),  # what the last stage wrote
    ]
    moved = run.record.words_moved()
    assert moved[Kind.TO_PL] == WORDS["data"] + WORDS["point"]
    each_time = WORDS["kkt"] + WORDS["direction"] + WORDS["point"]
    assert moved[Kind.TO_PS] == WORDS["scaled"] + 2 * each_time + WORDS["answer"]


def test_a_schedule_that_reads_a_stale_buffer_is_refused_on_the_pl() -> None:
    wrong = [("update",), ("solve",), ("check",)]  # `update` makes the factor stale, nothing renews it
    method = Method.from_tables(startup=STARTUP, iteration=wrong, stages=STAGES, repeat=REPEAT, done=DONE)
    run = prepare(method=method)
    with pytest.raises(ReadBeforeValid, match="stage 'solve'"):
        run.driver.run()
    assert run.engine.ran == ["scale", "load", "start", "update"]


def test_a_schedule_that_reads_a_stale_buffer_is_refused_on_the_ps() -> None:
    stages = {**STAGES, "check": Stage("ps", reads=("step",), writes=("statistics",))}
    wrong = [("update",), ("check",)]
    method = Method.from_tables(startup=STARTUP, iteration=wrong, stages=stages, repeat=REPEAT, done=DONE)
    run = prepare(method=method)
    with pytest.raises(ReadBeforeValid, match="stage 'check': data-valid flag is down for step"):
        run.driver.run()
    assert "check" not in run.engine.ran


class NoInterruptLine:
    """The PL behind a broken interrupt line."""

    interrupt = False

    def __init__(self, pl: ProgrammableLogic) -> None:
        self.read, self.write, self.tick = pl.read, pl.write, pl.tick


def test_a_lost_interrupt_is_found_by_polling() -> None:
    run = prepare(between=NoInterruptLine, poll_budget=7)
    with pytest.raises(
        LostInterrupt, match="stage 'scale', launch 2: finished, but no interrupt within 7 polls"
    ):
        run.driver.run()


def test_a_segment_slower_than_the_polling_budget_times_out() -> None:
    run = prepare(busy_ticks=9, poll_budget=7)
    with pytest.raises(LaunchTimeout, match="still busy after 7 polls"):
        run.driver.run()
    assert run.engine.ran == []


def test_an_error_inside_a_stage_reaches_the_caller() -> None:
    class Fails(FakeEngine):
        def run(self, stage: str) -> int:
            raise ArithmeticError(stage)

    with pytest.raises(ArithmeticError, match="scale"):
        prepare(Fails()).driver.run()


def test_no_file_of_the_ps_asks_an_engine_for_a_whole_solve_or_computes() -> None:
    for path in Path(orbsoc.ps.__file__).parent.glob("*.py"):
        tree = ast.parse(path.read_text())
        called = {
            n.func.attr
            for n in ast.walk(tree)
            if isinstance(n, ast.Call) and isinstance(n.func, ast.Attribute)
        }
        assert "solve" not in called, path
        floats = [n for n in ast.walk(tree) if isinstance(n, ast.Constant) and isinstance(n.value, float)]
        divisions = [n for n in ast.walk(tree) if isinstance(n, ast.Div | ast.Pow)]
        assert not [*floats, *divisions], path
        imported = {n.module for n in ast.walk(tree) if isinstance(n, ast.ImportFrom)} | {
            a.name for n in ast.walk(tree) if isinstance(n, ast.Import) for a in n.names
        }
        assert not {name for name in imported if name and name.split(".")[0] in ("numpy", "math", "scipy")}, (
            path
        )
