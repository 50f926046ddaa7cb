"""The trace of scheduled solves: its schema, and how solves of one pattern share it."""

from __future__ import annotations

import json
from dataclasses import dataclass, field

import numpy as np
import pytest

import hw_model
from orbsoc.conic.problem import Cones, Problem
from orbsoc.conic.settings import Settings
from orbsoc.conic.solution import Certificate, Solution, Status
from orbsoc.hw.emulation import LATENCY_PRESETS, operation_latencies
from orbsoc.ps.trace import TraceRecorder
from tests.ps.fake_engine import CLOSING, ITERATION, STAGES, STARTUP, WORDS, Stage

OPERATIONS = (
    "move", "neg", "abs", "mul", "add", "sub", "mul_add", "mul_sub",
    "div", "sqrt", "min", "max", "compare", "and", "select",
)  # fmt: skip


@dataclass
class FakeCore:
    """Counts one operation of each kind per stage, and how often it is asked to count."""

    asked: list[dict[str, dict[str, int]]] = field(default_factory=list)

    def stages(self) -> dict[str, Stage]:
        return STAGES

    def startup(self) -> list[tuple[str, ...]]:
        return list(STARTUP)

    def warm_startup(self) -> list[tuple[str, ...]]:
        return []

    def iteration(self) -> list[tuple[str, ...]]:
        return list(ITERATION)

    def closing(self) -> list[tuple[str, ...]]:
        return list(CLOSING)

    def operation_counts(
        self, problem: Problem, settings: Settings, latencies: dict[str, dict[str, int]]
    ) -> dict[str, dict[str, dict[str, int]]]:
        self.asked.append(latencies)
        chain = {preset: sum(cycles.values()) for preset, cycles in latencies.items()}
        counted = dict.fromkeys(OPERATIONS, problem.n)
        return {stage: {"operations": counted, "critical_path": chain} for stage in STAGES}


class FinishedEngine:
    def events(self) -> list[tuple[str, int]]:
        return [("scale", 0), ("start", 0), ("factorize", 1), ("check", 1)]

    def buffer_words(self) -> dict[str, int]:
        return WORDS


def problem(a: float = 1.0, *, column: int = 0, h: float = 0.0) -> Problem:
    row = np.zeros((1, 2))
    row[0, column] = a
    return Problem(c=[1.0, 2.0], A=row, b=[a], G=-np.eye(2), h=[h, 0.0], cones=Cones(l=2))


def solution(status: Status = Status.SOLVED) -> Solution:
    empty = np.zeros(0)
    return Solution(
        status=status, x=empty, y=empty, z=empty, s=empty, objective=0.0, dual_objective=0.0, iterations=1,
        refinements=0, setup_s=0.0, solve_s=0.0, certificate=Certificate(0.0, 0.0, 0.0, 0.0), message="",
        nnz_kkt=9, nnz_l=7,
    )  # fmt: skip


def recorded(*problems: Problem) -> tuple[TraceRecorder, FakeCore]:
    core = FakeCore()
    recorder = TraceRecorder(core, operation_latencies())
    for each in problems:
        recorder.add(each, Settings(), FinishedEngine(), solution())
    return recorder, core


def test_a_trace_is_what_the_hardware_model_reads() -> None:
    recorder, _ = recorded(problem())
    trace = hw_model.parse_trace(json.loads(json.dumps(recorder.as_dict())))
    (pattern,) = trace.patterns
    assert (pattern.n, pattern.p, pattern.m, pattern.nnz_kkt, pattern.nnz_l) == (2, 1, 2, 9, 7)
    assert pattern.buffers == WORDS
    assert pattern.stages["refine"].reads == ("factor", "error", "direction")
    assert pattern.stages["refine"].module == "linear_solve"
    (solve,) = trace.solves
    assert solve.events == tuple(FinishedEngine().events())
    assert (solve.pattern, solve.status, solve.iterations) == (0, "SOLVED", 1)


def test_solves_of_one_pattern_share_it_and_its_operations_are_counted_once() -> None:
    recorder, core = recorded(problem(1.0), problem(5.0), problem(-2.0))
    trace = recorder.as_dict()
    assert len(trace["patterns"]) == len(core.asked) == 1
    assert [solve["pattern"] for solve in trace["solves"]] == [0, 0, 0]


@pytest.mark.parametrize("other", [problem(column=1), problem(h=np.inf)], ids=["nonzeros", "an absent row"])
def test_another_pattern_gets_its_own_entry(other: Problem) -> None:
    recorder, core = recorded(problem(), other, problem(3.0))
    trace = recorder.as_dict()
    assert len(trace["patterns"]) == len(core.asked) == 2
    assert [solve["pattern"] for solve in trace["solves"]] == [0, 1, 0]


def test_a_trace_handed_out_does_not_change_with_later_solves() -> None:
    recorder, _ = recorded(problem())
    before = recorder.as_dict()
    recorder.add(problem(column=1), Settings(), FinishedEngine(), solution(Status.MAX_ITERATIONS))
    assert (len(before["solves"]), len(before["patterns"])) == (1, 1)
    assert recorder.as_dict()["solves"][1]["status"] == "MAX_ITERATIONS"


def test_every_operation_has_a_latency_in_every_preset() -> None:
    latencies = operation_latencies()
    assert tuple(latencies) == LATENCY_PRESETS
    assert all(set(cycles) == set(OPERATIONS) for cycles in latencies.values())
    assert all(isinstance(c, int) and c >= 1 for cycles in latencies.values() for c in cycles.values())


@pytest.mark.parametrize(
    ("preset", "add", "mul", "div"), [("orbsoc_rtl", 7, 8, 35), ("vendor_ip", 15, 16, 57)]
)
def test_latencies_are_those_of_the_units(preset: str, add: int, mul: int, div: int) -> None:
    cycles = operation_latencies()[preset]
    assert (cycles["add"], cycles["sub"], cycles["mul"], cycles["div"], cycles["sqrt"]) == (
        add,
        add,
        mul,
        div,
        div,
    )
    assert cycles["mul_add"] == cycles["mul_sub"] == mul + add


def test_a_platform_finds_its_preset_in_every_trace() -> None:
    for name in hw_model.platform_names():
        assert hw_model.load_platform(name).pl.latency_preset in LATENCY_PRESETS
