"""Schedules from Python: what a program says of itself, what is kept, and what is refused."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Any, cast

import numpy as np
import pytest
from scipy import sparse

from hw_model.platform.rtl_latency import rtl_latencies
from orbsoc import Settings, _core
from orbsoc.conic.pattern import pattern_digest
from orbsoc.conic.problem import Cones, Problem
from orbsoc.hw.schedules import Engine, EngineError, PlProgram, Stream, pl_program
from orbsoc.hw.utilisation_figure import busy_shares
from orbsoc.rtl.validation import MODULES, problems

SMALL = problems()["12 variables, cones 4 6"]


@pytest.fixture(scope="module")
def program() -> PlProgram:
    return pl_program(SMALL)


def test_every_stage_of_the_six_modules_has_a_segment(program: PlProgram) -> None:
    modules = {segment.module for segment in program.segments.values()}
    assert modules == {
        "matrix_update", "matrix_scaling", "factorization", "linear_solve", "cone_ops", "line_search",
    }  # fmt: skip
    on_pl = {name for name, info in _core.stages().items() if info.module in modules}
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


def test_interleaved_copies_take_less_than_one_after_the_other(program: PlProgram) -> None:
    two = pl_program(SMALL, copies=2)
    for name, one in program.segments.items():
        assert two.segments[name].operations >= 2 * one.operations, name
    assert sum(each.cycles for each in two.segments.values()) < 1.5 * sum(
        each.cycles for each in program.segments.values()
    )
    assert two.home_words > program.home_words


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


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("lanes", -1),
        ("lanes", 2.5),
        ("lanes", "4"),
        ("lanes", True),
        ("lanes", None),
        ("banks", 1 << 64),
        ("address_bits", -3),
        ("microcode_words", -1),
        ("fp", 64.0),
    ],
)
def test_fields_of_an_engine_are_whole_numbers(field: str, value: Any) -> None:
    with pytest.raises(EngineError, match=re.escape(f"`{field}` = {value!r}: allowed is a whole number")):
        Engine(**{field: value})


def test_a_number_of_numpy_makes_the_same_engine() -> None:
    engine = Engine(lanes=cast("Any", np.int64(2)))
    assert engine == Engine(lanes=2)
    assert type(engine.lanes) is int


@pytest.mark.parametrize(
    ("field", "value"), [("stages", ()), ("stages", "factorize"), ("stages", (1,)), ("leaves", ())]
)
def test_a_stream_is_of_names(field: str, value: Any) -> None:
    given: dict[str, Any] = {"stages": ("factorize",), field: value}
    with pytest.raises(EngineError, match=re.escape(f"stream `{field}` = {value!r}: allowed is a tuple")):
        Stream(**given)


def test_a_stream_leaves_what_its_stages_write() -> None:
    message = "'pair_solution' is written by none of factorize; allowed: factor_l, pivot_inverse"
    with pytest.raises(EngineError, match=message):
        Stream(("factorize",), ("factor_l", "pair_solution"))


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


def test_validation_runs_every_segment_those_of_a_warm_start_too(program: PlProgram) -> None:
    texts = [program.core.case(module, "flat") for module in MODULES]
    assert {match[1] for text in texts for match in re.finditer(r"^run (\w+) ", text, re.MULTILINE)} == set(
        program.segments
    )


def test_a_divider_that_is_seldom_used_is_not_drawn_busy_in_between(program: PlProgram) -> None:
    """Held for as long as the unit takes, however far apart its operations are."""
    names = program.core.operation_names()
    table = rtl_latencies()["f64"]
    cycles = [table[f"{name}_cycles"]["value"] if name in ("div", "sqrt") else 0 for name in names]
    assert sum(map(bool, cycles)) == 2
    for stage, segment in program.segments.items():
        edges, shares = busy_shares(program, stage, bins=5)
        _, _, operations = program.core.issues(stage)
        held = sum(cycles[operation] for operation in operations)
        assert (shares[-1] * np.diff(edges)).sum() <= held + 1e-9
        if not held:
            assert not shares[-1].any()
        assert segment.words >= 1


@pytest.mark.parametrize("lanes", [1, 2, 4])
@pytest.mark.parametrize("dividers", [1, 2])
def test_every_engine_has_compressed_microcode(lanes: int, dividers: int) -> None:
    engine = Engine(lanes=lanes, dividers=dividers, banks=4 * lanes)
    segments = pl_program(SMALL, engine=engine).segments.values()
    stored, flat = sum(s.compressed_bits for s in segments), sum(s.flat_bits for s in segments)
    assert 2 * stored < flat
    assert all(s.compressed_cycles > s.cycles // 2 for s in segments)
