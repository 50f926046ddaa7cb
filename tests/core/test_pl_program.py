"""Schedules from Python: what a program says of itself, what is kept, and what is refused."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy import sparse

from orbsoc import Settings, _core
from orbsoc.pl_figure import busy_shares
from orbsoc.pl_program import Engine, EngineError, PlProgram, pattern_digest, pl_program
from orbsoc.problem import Cones, Problem
from orbsoc.rtl_validation import problems

SMALL = problems()["12 variables, cones 4 6"]


@pytest.fixture(scope="module")
def program() -> PlProgram:
    return pl_program(SMALL)


def test_every_stage_of_the_six_modules_has_a_segment(program: PlProgram) -> None:
    modules = {segment.module for segment in program.segments.values()}
    assert modules == {
        "matrix_update", "matrix_scaling", "factorization", "linear_solve", "cone_ops", "line_search",
    }  # fmt: skip
    on_pl = {name for name, info in _core.stages().items() if info.module != "ps"}
    assert set(program.segments) == on_pl


def test_causes_sum_to_the_cycles_and_bounds_stay_below(program: PlProgram) -> None:
    for segment in program.segments.values():
        assert sum(segment.causes.values()) == segment.cycles
        assert sum(segment.lane_causes.values()) == segment.cycles * program.engine.lanes
        assert segment.lane_causes["issue"] == segment.lane_operations
        assert segment.lower_bound <= segment.cycles


def test_other_numbers_of_the_same_pattern_are_not_scheduled_again(program: PlProgram) -> None:
    other = Problem(
        P=SMALL.P, c=SMALL.c + 1.0, A=SMALL.A, b=SMALL.b, G=SMALL.G, h=2.0 * SMALL.h, cones=SMALL.cones
    )
    assert pl_program(other) is program
    assert pl_program(SMALL, Settings(ruiz_passes=2)) is not program
    assert pl_program(SMALL, engine=Engine(lanes=2)) is not program


def test_an_absent_row_is_part_of_the_pattern() -> None:
    g, cones = sparse.csc_array(-np.eye(2)), Cones(l=2, q=[])
    both = Problem(c=[1.0, 1.0], G=g, h=[0.0, 0.0], cones=cones)
    one = Problem(c=[1.0, 1.0], G=g, h=[0.0, np.inf], cones=cones)
    assert pattern_digest(both) != pattern_digest(one)


@pytest.mark.parametrize(
    ("field", "value", "allowed"),
    [
        ("lanes", 0, "1 to 16"),
        ("banks", 12, "a power of two"),
        ("dividers", 9, "1 to 4"),
        ("address_bits", 30, "8 to 20"),
        ("microcode_words", 10, "microcode_words"),
        ("address_bits", 8, "words of storage"),
    ],
)
def test_engines_that_cannot_be_are_refused_by_field(field: str, value: int, allowed: str) -> None:
    with pytest.raises(EngineError, match=rf"`{field}`.*") as refused:
        pl_program(SMALL, engine=replace(Engine(), **{field: value}))
    assert allowed in str(refused.value)


def test_storage_is_the_least_power_of_two_that_holds_the_problem(program: PlProgram) -> None:
    bits = program.engine.address_bits
    assert bits is not None
    assert program.home_words <= program.storage_words <= 2**bits
    with pytest.raises(EngineError, match="address_bits"):
        pl_program(SMALL, engine=Engine(address_bits=bits - 1))


def test_gaps_in_the_fetch_only_ever_cost_cycles(program: PlProgram) -> None:
    steady, gappy = program.core.in_order(1, 0), program.core.in_order(1, 128)
    assert all(steady[stage] <= gappy[stage] for stage in steady)
    assert sum(gappy.values()) > sum(steady.values())


def test_the_figures_shares_add_up_to_the_operations(program: PlProgram) -> None:
    edges, shares = busy_shares(program, "factorize", bins=7)
    lanes = program.engine.lanes
    width = edges[1] - edges[0]
    segment = program.segments["factorize"]
    assert shares[:lanes].sum() * width == pytest.approx(segment.lane_operations)
    assert shares.min() >= 0.0
    assert shares.max() <= 1.0 + 1e-12


def test_the_hardware_model_gets_exact_cycles_where_a_problem_is_at_hand(program: PlProgram) -> None:
    from hw_model import load_platform
    from orbsoc.pl_cycles import scheduled_cycles
    from orbsoc.ps import PsScheduler
    from orbsoc.workload import record_trace

    scheduler = PsScheduler()
    scheduler(SMALL)
    trace = record_trace(scheduler.trace, "small", "solve", scheduler.patterns).trace
    platform = load_platform("zu9eg")
    exact = scheduled_cycles([SMALL])(trace, platform, 0, "factorize")
    assert (exact.origin, exact.cycles) == ("schedule", program.segments["factorize"].cycles)
    assert exact.lower_bound <= exact.cycles
    assert scheduled_cycles([])(trace, platform, 0, "factorize").origin == "estimate"
    slower = platform.with_value("pl.latency_preset", "vendor_ip")
    assert scheduled_cycles([SMALL])(trace, slower, 0, "factorize").origin == "estimate"
