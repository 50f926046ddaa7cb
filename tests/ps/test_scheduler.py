"""`PsScheduler` as a solver: settings, record, trace, errors and Ctrl-C. Its bits: tests/integration."""

from __future__ import annotations

import os
import signal
import threading
from typing import Any

import pytest

import hw_model
from orbsoc import PsScheduler, _core
from orbsoc.conic.problem import Cones, Problem
from orbsoc.conic.settings import Settings
from orbsoc.conic.solution import Status
from orbsoc.ps import scheduler
from orbsoc.ps.events import Kind
from orbsoc.ps.registers import Module
from orbsoc.ps.segments import Method

PROBLEM = Problem(
    c=[1.0, 2.0], A=[[1.0, 1.0]], b=[1.0], G=[[-1.0, 0.0], [0.0, -1.0]], h=[0, 0], cones=Cones(l=2)
)


def test_a_call_has_the_defaults_of_the_scheduler_unless_it_says_otherwise() -> None:
    ps = PsScheduler(Settings(max_iterations=50), max_iterations=2)
    assert (ps(PROBLEM).status, ps(PROBLEM).iterations) == (Status.MAX_ITERATIONS, 2)
    assert ps(PROBLEM, max_iterations=1).iterations == 1
    assert ps(PROBLEM, Settings()).status is Status.SOLVED
    assert ps(PROBLEM, Settings(), max_iterations=3).iterations == 3


def test_an_unknown_setting_is_refused_where_it_is_given() -> None:
    with pytest.raises(TypeError, match="tolerance"):
        PsScheduler(tolerance=1e-9)
    with pytest.raises(TypeError, match="tolerance"):
        PsScheduler()(PROBLEM, tolerance=1e-9)


def test_every_call_adds_to_the_trace_and_renews_the_record() -> None:
    ps = PsScheduler()
    first = ps(PROBLEM)
    record = ps.record
    second = ps(PROBLEM, tol=1e-4)
    trace = hw_model.parse_trace(ps.trace)
    assert [(s.status, s.iterations) for s in trace.solves] == [
        ("SOLVED", first.iterations),
        ("SOLVED", second.iterations),
    ]
    assert second.iterations < first.iterations
    assert len(trace.patterns) == 1
    assert (trace.patterns[0].nnz_kkt, trace.patterns[0].nnz_l) == (first.nnz_kkt, first.nnz_l)
    assert record is not ps.record
    assert len(ps.record) < len(record)


def test_the_record_and_the_trace_tell_of_the_same_stages() -> None:
    ps = PsScheduler()
    ps(PROBLEM)
    (solve,) = ps.trace["solves"]
    acts = [event.name for event in ps.record if event.kind in (Kind.LAUNCH, Kind.RUN)]
    assert acts == [stage for stage, _ in solve["events"]]


def test_moves_have_the_sizes_of_the_buffers() -> None:
    ps = PsScheduler()
    ps(PROBLEM)
    words = ps.trace["patterns"][0]["buffers"]
    moves = [*ps.record.of(Kind.TO_PL), *ps.record.of(Kind.TO_PS)]
    assert moves
    assert all(event.value == words[event.name] for event in moves)


def test_own_latencies_replace_the_presets() -> None:
    codes = (
        "move", "neg", "abs", "mul", "add", "sub", "mul_add", "mul_sub",
        "div", "sqrt", "min", "max", "compare", "and", "select",
    )  # fmt: skip
    one, seven = (PsScheduler(latencies={"mine": dict.fromkeys(codes, cycles)}) for cycles in (1, 7))
    chains = []
    for ps in (one, seven):
        ps(PROBLEM)
        chains.append(
            [stage["critical_path"]["mine"] for stage in ps.trace["patterns"][0]["stages"].values()]
        )
    assert chains[1] == [7 * chain for chain in chains[0]]
    assert any(chains[0])


def test_a_setting_out_of_range_is_refused() -> None:
    with pytest.raises(ValueError, match="tol"):
        PsScheduler()(Problem(c=[1.0], G=[[-1.0]], h=[-2.0], cones=Cones(l=1)), tol=-1.0)


class Watched:
    """A native engine that keeps count of what is asked of it, and has no `solve`."""

    def __init__(self, problem: Problem, settings: Settings) -> None:
        self.native = _core.Engine(problem, settings)
        self.asked: list[str] = []

    def __getattr__(self, name: str) -> Any:
        if name == "solve":
            raise AssertionError("the PS asked the engine for a whole solve")
        self.asked.append(name)
        return getattr(self.native, name)


def test_the_scheduler_never_asks_the_engine_for_a_whole_solve(monkeypatch: pytest.MonkeyPatch) -> None:
    engines: list[Watched] = []

    def watched(problem: Problem, settings: Settings) -> Watched:
        engines.append(Watched(problem, settings))
        return engines[-1]

    monkeypatch.setattr(scheduler, "engine", watched)
    assert PsScheduler()(PROBLEM).status is Status.SOLVED
    assert set(engines[0].asked) == {"run", "buffer_words", "begin_again", "finish", "events"}
    with pytest.raises(AssertionError, match="whole solve"):
        engines[0].solve()


class CtrlC(Watched):
    """Sends this process the signal of Ctrl-C when the second iteration starts."""

    def __getattr__(self, name: str) -> Any:
        if name != "run":
            return getattr(self.native, name)
        return self._run

    def is_time(self, stage: str) -> bool:
        return stage == "factorize" and bool(self.native.iteration == 1)

    def _run(self, stage: str) -> int:
        if self.is_time(stage):
            os.kill(os.getpid(), signal.SIGINT)
        return self.native.run(stage)


def test_ctrl_c_ends_the_solve_within_one_iteration_and_is_a_status(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(scheduler, "engine", CtrlC)
    before = signal.getsignal(signal.SIGINT)
    solution = PsScheduler()(PROBLEM)
    assert solution.status is Status.INTERRUPTED
    assert solution.iterations <= 2
    assert signal.getsignal(signal.SIGINT) is before


class LateCtrlC(CtrlC):
    """Sends it when the solve has converged."""

    def is_time(self, stage: str) -> bool:
        return stage == "unscale"


def test_ctrl_c_of_which_no_status_tells_goes_up(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(scheduler, "engine", LateCtrlC)
    before = signal.getsignal(signal.SIGINT)
    ps = PsScheduler()
    with pytest.raises(KeyboardInterrupt):
        ps(PROBLEM)
    assert [solve["status"] for solve in ps.trace["solves"]] == ["SOLVED"]
    assert signal.getsignal(signal.SIGINT) is before


def test_a_handler_of_the_users_own_is_asked_and_may_let_the_solve_go_on(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(scheduler, "engine", CtrlC)
    heard: list[int] = []
    before = signal.signal(signal.SIGINT, lambda signum, frame: heard.append(signum))
    try:
        assert PsScheduler()(PROBLEM).status is Status.SOLVED
    finally:
        signal.signal(signal.SIGINT, before)
    assert heard == [signal.SIGINT]


def test_a_scheduler_works_in_another_thread() -> None:
    found: list[Status] = []
    ps = PsScheduler()
    thread = threading.Thread(target=lambda: found.append(ps(PROBLEM).status))
    thread.start()
    thread.join()
    assert found == [Status.SOLVED]


def test_the_core_has_stages_on_the_ps_and_on_all_modules_of_the_control() -> None:
    paper, resident = (Method.from_core(_core, resident=way) for way in (False, True))
    assert {segment.module for segment in paper.segments} == set(Module) - {Module.STATISTICS}
    assert {segment.module for segment in resident.segments[1:]} == set(Module) - {Module.PS}
    assert set(paper.flags) == {"statistics", "center_start", "newton_start", "check_pair", "check_solve"}


def test_what_is_loaded_before_the_first_stage_is_the_problem_and_the_parameters() -> None:
    method = Method.from_core(_core)
    loaded = set(method.names(method.segments[0].writes))
    written = {name for info in _core.stages().values() for name in info.writes}
    assert {"raw_p", "raw_a", "raw_g", "raw_q", "norms", "parameters"} <= loaded - written
    made = {
        "p",
        "a",
        "g",
        "q",
        "scale",
        "kkt_values",
        "factor_l",
        "kkt_rhs",
        "kkt_solution",
        "point",
        "slack",
        "w",
    }
    assert made <= written - loaded
