"""The modelled tables of docs/pl-schedules.md: sums over segments, weighted as a solve runs them."""

from __future__ import annotations

from collections import Counter

import pytest

from orbsoc import PsScheduler, Settings
from orbsoc.hw.schedules import KKT_SOLVES, Engine, PlProgram, pl_program
from orbsoc.rtl.tables import (
    LANES,
    SHAPES,
    WITH_RESIDUALS,
    module_savings,
    problem_savings,
    saving,
    stage_runs,
    stream_rows,
    tables,
)
from orbsoc.rtl.validation import MODULES, problems

NAME = "6 variables, cones 3"
PROBLEM = problems()[NAME]


@pytest.fixture(scope="module")
def program() -> PlProgram:
    return pl_program(PROBLEM, engine=Engine(lanes=4))


def test_a_saving_is_the_ratio_of_bits_and_of_cycles_as_often_as_segments_run(program: PlProgram) -> None:
    one, other = list(program.segments.values())[:2]
    found = saving([one, other], {one.stage: 3})
    assert found.flat_bits == one.flat_bits + other.flat_bits
    assert found.smaller == (one.flat_bits + other.flat_bits) / (one.compressed_bits + other.compressed_bits)
    assert (found.flat_cycles, found.compressed_cycles) == (3 * one.cycles, 3 * one.compressed_cycles)
    assert found.longer == one.compressed_cycles / one.cycles - 1


def test_stages_run_as_often_as_the_processing_system_launches_them() -> None:
    ps = PsScheduler()
    ps(PROBLEM)
    trace = Counter(stage for solve in ps.trace["solves"] for stage, _ in solve["events"])
    assert trace
    assert stage_runs(PROBLEM, Settings()) == trace


def test_the_modules_of_a_program_add_up_to_all_of_it(program: PlProgram) -> None:
    found = module_savings(PROBLEM, Engine(lanes=4))
    assert set(found) == {*MODULES, "all"}
    total = found.pop("all")
    assert total.flat_bits == sum(segment.flat_bits for segment in program.segments.values())
    assert total.compressed_cycles == sum(module.compressed_cycles for module in found.values())


def test_streams_without_residuals_are_the_shorter_ones() -> None:
    rows = stream_rows(PROBLEM)
    assert [(row.lanes, row.dividers) for row in rows] == list(SHAPES)
    assert all(row.cycles <= row.cycles_with_residuals for row in rows)
    found = problem_savings(PROBLEM, 4)
    (alone,), (whole,) = (
        pl_program(PROBLEM, engine=Engine(lanes=4), stream=stream).segments.values()
        for stream in (KKT_SOLVES, WITH_RESIDUALS)
    )
    assert found["L, D and two solutions"].compressed_bits == alone.compressed_bits
    assert found["with residuals"].compressed_bits == whole.compressed_bits
    assert found["whole solve"].flat_cycles > found["program"].flat_cycles


def test_the_document_and_the_page_have_a_row_for_each_module_and_lane_count() -> None:
    document, lines = tables({NAME: PROBLEM})
    assert set(document[NAME]["modules_on_4_lanes"]) == {*MODULES, "all"}
    assert list(document[NAME]["savings_by_lanes"]) == list(LANES)
    assert sum(line.startswith("| ") for line in lines) == 3 + len(SHAPES) + len(MODULES) + 1 + len(LANES)
    assert "modelled" in document["provenance"]
