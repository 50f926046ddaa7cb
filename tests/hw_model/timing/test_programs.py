"""Loads of programs: which stay, what a change of the pattern takes, and that a run has each change once."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

from hw_model import load_partition, load_platform, parse_trace, simulate, speedup
from hw_model.area.budget import Budget, budget
from hw_model.report.loading import loading
from hw_model.report.study import Study
from hw_model.timing import link
from hw_model.timing.actions import actions_of
from hw_model.timing.programs import (
    LITERALS,
    changes_of,
    follows_another,
    microcode_picoseconds,
    plan_picoseconds,
    program_of,
    tables_picoseconds,
)
from hw_model.timing.stage_cycles import Microcode, PlCycles
from hw_model.timing.trace import Trace
from orbsoc import _core
from orbsoc.hw.emulation import resident_program
from orbsoc.hw.schedules import Engine, pl_program
from orbsoc.ps.segments import Method
from tests.hw_model.timing.test_groups import RESIDENT, ZU9EG, solves
from tests.integration.small_problem import small_problem

PAPER = load_partition("paper")
DRIVER = Path(__file__).parents[3] / "docs" / "driver.md"


def scheduled(trace: Trace, platform: Any, pattern: int, stage: str) -> PlCycles:
    """Segments of 4 000 cycles for the first pattern, 2 000 more for each further one."""
    cycles = 4_000 + 2_000 * pattern
    return PlCycles(
        {"issue": cycles}, 0, "issue", "schedule", Microcode(cycles, 300 * cycles, 100 * cycles), 100
    )


def test_a_change_is_a_solve_after_one_of_another_pattern_and_the_first_follows_the_last() -> None:
    trace = solves(0, 0, 1, 1, 0)
    assert follows_another(trace) == [False, False, True, False, True]
    assert changes_of(trace) == (1, 1)
    assert follows_another(solves(0, 1)) == [True, True]
    assert follows_another(solves(0, 0)) == [False, False]


def test_one_pattern_is_loaded_once_a_boot_and_never_in_a_run() -> None:
    found = budget(solves(0, 0), ZU9EG, RESIDENT, scheduled).programs
    assert (found.resident, found.loads, plan_picoseconds(ZU9EG, found)) == ((0,), 0, 0)
    assert found.boot_bytes == found.each[0].microcode_bytes > 0
    assert not [a for a in actions_of(solves(0, 0), RESIDENT) if a.work.kind == "load"]


def _with_bram(blocks: int) -> Any:
    return ZU9EG.with_values({"resources.bram36": blocks, "area.bram36_ceiling": 1.0})


def _fitting(trace: Trace) -> dict[int, Budget]:
    """By block RAM what stays."""
    return {blocks: budget(trace, _with_bram(blocks), RESIDENT, scheduled) for blocks in range(40, 3000, 20)}


def test_as_many_programs_stay_as_fit_and_the_most_wanted_first() -> None:
    trace = solves(0, 1, 2, 1, 0, 1, 2, 1)
    assert changes_of(trace) == (2, 4, 2)
    kept = [found.programs.resident for found in _fitting(trace).values() if found.fits]
    assert list(dict.fromkeys(kept)) == [(), (1,), (0, 1, 2)]
    assert [found.of("bram36").used for found in _fitting(trace).values()] == sorted(
        found.of("bram36").used for found in _fitting(trace).values()
    )


def test_what_fits_no_program_at_all_does_not_fit() -> None:
    found = budget(solves(0, 1), _with_bram(10), RESIDENT, scheduled)
    assert not found.fits
    assert found.programs.resident == ()


def test_a_load_takes_what_the_slower_of_link_and_slave_takes() -> None:
    for key, value in (("link.dma_to_pl_bytes_per_pl_cycle", 16.0), ("pl.load_bytes_per_cycle", 0.5)):
        platform = ZU9EG.with_value(key, value)
        rate = platform.pl.load_bytes_per_cycle.value * platform.pl.clock_mhz.value
        assert microcode_picoseconds(platform, 10**6) == pytest.approx(1e12 / rate, rel=1e-3)
    assert microcode_picoseconds(ZU9EG, 10**6) == link.dma(ZU9EG.link, ZU9EG.pl.clock_mhz.value, 10**6, "pl")
    assert microcode_picoseconds(ZU9EG, 0) == 0


def test_the_run_has_each_change_once_and_the_report_says_so() -> None:
    trace = solves(0, 1, 0, 1)
    small = next(_with_bram(k) for k, found in _fitting(trace).items() if found.fits)
    programs = budget(trace, small, RESIDENT, scheduled).programs
    assert (programs.loads, programs.resident) == (4, ())
    there = [simulate(trace, each, RESIDENT, scheduled) for each in (small, _with_bram(10**6))]
    tables = sum(
        count * tables_picoseconds(small, program)
        for count, program in zip(programs.changes, programs.each, strict=True)
    )
    apart = there[0].makespan_picoseconds - there[1].makespan_picoseconds
    assert apart == plan_picoseconds(small, programs) - tables > 0
    report = speedup(trace, small, RESIDENT, cycles=scheduled)
    assert report.makespan_picoseconds == there[0].makespan_picoseconds
    assert report.loading == loading(small, programs)
    assert "none of them stays; 4 loads a plan" in report.loading.words
    (point,) = Study(trace, scheduled).points(small, [RESIDENT])
    assert point.times_ms[0] == report.makespan_ms.nominal
    assert point.row()["plan_loads"] == 4


def test_an_engine_that_does_not_fit_is_said_in_the_headline_and_fails_the_deadline() -> None:
    report = speedup(solves(0), _with_bram(10), RESIDENT, deadline_ms=1e6, cycles=scheduled)
    assert "does NOT FIT" in report.headline
    assert report.deadline is not None
    assert report.deadline.verdict == "FAIL"
    assert "does NOT FIT" not in speedup(solves(0), ZU9EG, RESIDENT, cycles=scheduled).headline


def test_tables_are_what_the_driver_writes() -> None:
    control, problem = resident_program(), small_problem()
    whole, own = Method.from_core(_core, resident=True), Method.from_core(_core)
    trace = parse_trace(_recorded(problem))
    for partition, streams, rows, instructions in (
        (RESIDENT, control.streams, len(whole.numbered(control)), len(control.instructions)),
        (PAPER, (), len(own.segments), 0),
    ):
        found = program_of(trace, partition, 1, 128, compressed=True)
        assert found.register_writes == 1 + 8 * rows + 2 * instructions
        image = _core.program_image(
            pl_program(problem, None, Engine(lanes=2), None, streams).core, "compressed"
        )
        assert len(image.literals[0]) <= LITERALS
        assert len(image.templates) <= 64


def _recorded(problem: Any) -> dict[str, Any]:
    from orbsoc.hw.emulation import PsScheduler

    scheduler = PsScheduler()
    scheduler(problem)
    return scheduler.trace


def test_lines_lie_at_powers_of_two_of_pieces() -> None:
    trace = solves(0)
    sizes = {
        bits: program_of(trace, PAPER, 10, bits, compressed=False).microcode_bytes for bits in (33, 128, 285)
    }
    assert sizes == {33: 80, 128: 160, 285: 640}


def test_the_slaves_rate_is_that_of_the_documented_burst() -> None:
    (clocks,) = re.findall(r"\| 16 beats: microcode written by 8 bytes, f64 \| (\d+) \|", DRIVER.read_text())
    assert load_platform("zu9eg").pl.load_bytes_per_cycle.value == 16 * 8 / int(clocks)


def test_the_table_beside_the_processor_has_one_core_and_all_of_them() -> None:
    report = speedup(solves(0, 0), ZU9EG, RESIDENT, cycles=scheduled)
    one, bare, all_cores, both = report.beside
    assert one.energy_mj.nominal == report.baseline_energy.nominal_mj
    leakage = next(row for row in report.baseline_energy.rows if row.action == "pl_static")
    assert bare.energy_mj.nominal == pytest.approx(one.energy_mj.nominal - leakage.nominal_mj)
    assert all_cores.energy_mj.nominal < bare.energy_mj.nominal
    assert [gain for _, gain in one.gains] == [found.speedup.nominal for found in report.prices]
    for row, in_flight in ((all_cores, 1), (both, 2)):
        known = next(each for each in report.throughput if each.in_flight == in_flight)
        assert row.gains[0][1] == pytest.approx(known.gain)
    assert "4 cores of a chip without a PL" in report.to_markdown()
