"""The law of executed instructions against counts on patterns that it has not seen."""

from __future__ import annotations

import json
from functools import cache
from statistics import geometric_mean
from typing import Any

import pytest

from hw_model.platform.platform import load_platform
from hw_model.report.speedup import speedup
from hw_model.timing import ps
from hw_model.timing.instructions import RECORD, recorded
from hw_model.timing.trace import Pattern, parse_trace
from orbsoc.hw.emulation import PsScheduler
from scripts.instruction_problems import FAMILIES, SCENARIOS, first_patterns

RECORDED: dict[str, Any] = json.loads(RECORD.read_text(encoding="utf-8"))
HELD_OUT: dict[str, dict[str, list[int]]] = {row["name"]: row["stages"] for row in RECORDED["held_out"]}
CORES = {"Cortex-A53": "zu9eg", "Cortex-A9": "xc7z020", "Cortex-A7": "fmql45t900", "Cortex-R52": "ng_ultra"}
SEEN = {row.name for row in recorded().measured}


@cache
def pattern_of(name: str) -> Pattern:
    family, _, size = name.rpartition("-")
    scheduler = PsScheduler()
    if family in FAMILIES:
        scheduler(FAMILIES[family][0](int(size)))
    else:  # of a mission, the first problems that differ in their sizes
        scheduler(first_patterns(SCENARIOS / f"{family}.toml")[int(size)])
    trace: dict[str, Any] = scheduler.trace
    return parse_trace(trace).patterns[0]


def test_the_law_has_not_seen_what_it_is_judged_by() -> None:
    assert len(HELD_OUT) > 30
    assert not SEEN & set(HELD_OUT)


@pytest.mark.parametrize("name", HELD_OUT)
def test_a_solve_has_the_instructions_that_the_law_says(name: str) -> None:
    """The total within a tenth, stages that take a twentieth of it within 15 %."""
    law, pattern = recorded(), pattern_of(name)
    counts = {stage: found for stage, found in HELD_OUT[name].items() if stage in pattern.stages}
    total = sum(instructions for _, instructions in counts.values())
    said = {stage: runs * law.instructions(stage, pattern) for stage, (runs, _) in counts.items()}
    assert sum(said.values()) == pytest.approx(total, rel=0.10)
    for stage, (_, instructions) in counts.items():
        if instructions >= 0.05 * total:
            assert said[stage] == pytest.approx(instructions, rel=0.15), stage


@pytest.mark.parametrize("core", CORES)
def test_every_core_has_solved_every_problem_to_the_same_bits(core: str) -> None:
    found = RECORDED["cores"][core]
    assert set(found["totals"]) == set(RECORDED["totals"])
    assert found["other_answers"] == []


@pytest.mark.parametrize(("core", "platform"), CORES.items())
def test_a_core_has_the_factor_that_was_counted(core: str, platform: str) -> None:
    """Geometric mean of the problems' ratios, and their range, as printed in the preset with two decimals."""
    totals, first = RECORDED["cores"][core]["totals"], RECORDED["cores"]["Cortex-A53"]["totals"]
    ratios = [totals[name] / first[name] for name in first]
    factor = load_platform(platform).ps.instruction_factor
    assert factor.tag == "executed"
    assert factor.value == pytest.approx(geometric_mean(ratios), abs=0.006)
    if core != "Cortex-A53":
        assert (factor.low, factor.high) == pytest.approx((min(ratios), max(ratios)), abs=0.006)


@pytest.mark.parametrize("core", ["Cortex-A9", "Cortex-R52"])
def test_a_core_has_the_cycles_that_its_pipeline_model_says(core: str) -> None:
    model = RECORDED["cores"][core]["pipeline"][core.lower()]
    cycles = load_platform(CORES[core]).ps.cycles_per_instruction
    assert cycles.tag == "scaled"
    halfway = geometric_mean([model["issue"], model["repeated"]])
    assert cycles.high == pytest.approx(model["once"], abs=0.006)
    if core == "Cortex-R52":  # in order, as the core that was counted in RTL
        assert (cycles.low, cycles.value) == pytest.approx(
            (halfway, geometric_mean([halfway, model["once"]])), abs=0.006
        )
    else:
        assert (cycles.low, cycles.value) == pytest.approx((model["issue"], halfway), abs=0.006)


def test_both_prices_stand_side_by_side_in_a_comparison() -> None:
    scheduler = PsScheduler()
    scheduler(FAMILIES["rendezvous"][0](15))
    for device, words in (("zu9eg", "NEON)"), ("xc7z020", "NEON, scaled to Arm Cortex-A9)")):
        report = speedup(scheduler.trace, device, "paper")
        flops, executed = report.prices
        assert (flops.makespan_ms, flops.speedup) == (report.makespan_ms, report.speedup)
        assert executed.baseline_ms != flops.baseline_ms
        assert f"by flop a cycle, assumed {flops.speedup.nominal:.2f}×" in report.price_line
        assert (
            f"executed instructions (Cortex-A53, {words} {executed.speedup.nominal:.2f}×" in report.price_line
        )
        chosen = load_platform(device).with_value("ps.price", "executed_instructions")
        assert speedup(scheduler.trace, chosen, "paper").makespan_ms == executed.makespan_ms


def test_a_deadline_is_judged_at_the_dearest_price_and_lost_at_the_cheapest() -> None:
    scheduler = PsScheduler()
    scheduler(FAMILIES["rendezvous"][0](15))

    def verdict(deadline_ms: float) -> str:
        found = speedup(scheduler.trace, "mpfs250t", "paper", deadline_ms=deadline_ms).deadline
        assert found is not None
        return found.verdict

    report = speedup(scheduler.trace, "mpfs250t", "paper")
    dearest = max(report.prices, key=lambda each: each.worst_case_ms)
    assert report.worst_case_ms < dearest.worst_case_ms
    assert verdict(report.worst_case_ms) == "MARGINAL"
    assert verdict(dearest.worst_case_ms) == "PASS"
    cheapest = min(each.makespan_ms.low for each in report.prices)
    assert [verdict(cheapest), verdict(cheapest * (1.0 - 1e-9))] == ["MARGINAL", "FAIL"]
    line = speedup(scheduler.trace, "mpfs250t", "paper", deadline_ms=1e3).deadline_line
    assert f"worst case (by {dearest.price}; with jitter) {dearest.worst_case_ms:.3f} ms" in line


def test_the_price_is_instructions_times_cycles_and_divisions() -> None:
    core = load_platform("zu9eg").with_value("ps.price", "executed_instructions").ps
    pattern = pattern_of("rendezvous-15")
    executed = recorded().instructions("factorize", pattern)
    found = ps.run_cycles("factorize", pattern, core, "f64")
    divisions = pattern.stages["factorize"].operations["div"] * core.div_f64_cycles.value
    assert found == pytest.approx(executed * core.cycles_per_instruction.value + divisions, abs=1.0)
    assert found != ps.run_cycles("factorize", pattern, load_platform("zu9eg").ps, "f64")
