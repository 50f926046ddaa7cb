"""Reports: bands, verdicts, provenance, and that nothing in them passes for a measurement."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

import hw_model
from hw_model.errors import HwModelError
from hw_model.platform.platform import load_platform, platform_names
from hw_model.report.speedup import Report, speedup
from hw_model.vocabulary import PL_MODULES
from tests.hw_model.synthetic import synthetic_trace
from tests.hw_model.tiny import partition_of, tiny_platform, tiny_trace

TRACE = synthetic_trace(iterations=4)
PAPERS = tuple(name for name in PL_MODULES if name != "statistics")
"""The modules of the trace, which has the PS's tasks on the PS."""


def test_speedup_by_hand(tmp_path: Path) -> None:
    report = speedup(tiny_trace(), tiny_platform(tmp_path), partition_of("factorization"), deadline_ms=0.02)
    # The two runs of test_timeline: 11 996 ns against 154 ns.
    assert report.makespan_picoseconds == 11_996_000
    assert report.speedup.nominal == pytest.approx(154 / 11_996, rel=1e-12)
    assert (report.makespan_ms.nominal, report.baseline_ms.nominal) == pytest.approx((0.011996, 0.000154))
    assert report.cycles == {"ps": 56, "pl": 132}
    assert (report.launches, report.interrupts) == (1, 1)
    assert [(row.buffer, row.to, row.count, row.size_bytes, row.picoseconds) for row in report.copies] == [
        ("v", "pl", 1, 800, 6_000_000), ("w", "ps", 1, 16, 800_000),
    ]  # fmt: skip
    assert "SLOWER" in report.headline
    assert report.deadline is not None
    assert report.deadline.margin_ms == pytest.approx(0.02 - 0.011996)


def test_bands_are_the_runs_at_the_ends() -> None:
    platform = load_platform("zu9eg")
    report = speedup(TRACE, platform, "paper")

    def run(ps: Any, fabric: Any, build: Any, partition: str) -> float:
        return (
            hw_model.simulate(TRACE, platform.corner(ps, fabric, build), partition).makespan_picoseconds / 1e9
        )

    assert report.makespan_ms.low == run("fast", "fast", "fast", "paper")
    assert report.makespan_ms.high == run("slow", "slow", "slow", "paper")
    assert report.baseline_ms.low == run("fast", "nominal", "fast", "all_ps")

    def ratios(ps: Any, fabric: Any) -> list[float]:
        return [
            run(ps, fabric, build, "all_ps") / run(ps, fabric, build, "paper") for build in ("slow", "fast")
        ]

    assert report.speedup.low == min(ratios("fast", "slow"))
    assert report.speedup.high == max(ratios("slow", "fast"))
    assert report.speedup.low < report.speedup.nominal < report.speedup.high


def test_no_point_inside_the_bands_leaves_the_reported_band() -> None:
    platform = load_platform("fmql45t900")
    band = speedup(TRACE, platform, "paper").speedup
    for key, value in {
        "ps.clock_mhz": 830.0, "ps.flop_per_cycle": 0.27, "runtime.interrupt_entry_us": 0.9,
        "ps.build_flops_per_nonzero": 150.0, "pl.overlap_exponent": 3.1,
    }.items():  # fmt: skip
        platform = platform.with_value(key, value)
        inside = speedup(TRACE, platform, "paper").speedup.nominal
        assert band.low <= inside <= band.high


def test_without_bands_the_band_is_a_point(tmp_path: Path) -> None:
    report = speedup(tiny_trace(), tiny_platform(tmp_path), partition_of("factorization"))
    assert report.speedup.low == report.speedup.nominal == report.speedup.high


@pytest.mark.parametrize("device", platform_names())
@pytest.mark.parametrize("partition", ["all_ps", "paper", "factor_only"])
def test_tables_add_up_to_the_makespan(device: str, partition: str) -> None:
    report = speedup(synthetic_trace(iterations=3, solves=2), device, partition)
    makespan = report.makespan_picoseconds
    assert sum(report.causes_picoseconds.values()) == makespan
    for rows in (report.modules, report.iterations):
        assert sum(row.picoseconds for row in rows) == makespan
        for row in rows:
            assert sum(row.causes_picoseconds.values()) == row.picoseconds
    assert sum(row.picoseconds for row in report.solves) == makespan
    assert sum(row.baseline_picoseconds for row in report.modules) == round(report.baseline_ms.nominal * 1e9)
    assert sum(row.cycles_each * row.runs for row in report.stages) == sum(report.cycles.values())
    assert sum(row.ps_cycles for row in report.iterations) == report.cycles["ps"]
    assert sum(row.pl_cycles for row in report.iterations) == report.cycles["pl"]
    for row in report.stages:
        assert sum(row.causes_each.values()) == row.cycles_each
        assert row.lower_bound_each is None or row.lower_bound_each <= row.cycles_each


def test_the_baseline_against_itself_is_one_without_transfers() -> None:
    report = speedup(TRACE, "zu9eg", "all_ps")
    assert (report.speedup.low, report.speedup.nominal, report.speedup.high) == (1.0, 1.0, 1.0)
    assert (report.copies, report.interrupts, report.launches) == ((), 0, 0)
    assert report.causes_picoseconds == dict.fromkeys(report.causes_picoseconds, 0) | {
        "ps": report.makespan_picoseconds
    }
    assert report.headline.startswith("modelled: all_ps on zu9eg takes ")


def test_any_partition_may_be_the_baseline() -> None:
    forth = speedup(TRACE, "zu9eg", "paper", baseline="factor_only").speedup.nominal
    back = speedup(TRACE, "zu9eg", "factor_only", baseline="paper").speedup.nominal
    assert forth * back == pytest.approx(1.0, rel=1e-12)


@pytest.mark.parametrize("partition", ["paper", "factor_only", *PAPERS])
def test_more_lanes_are_never_slower(partition: str) -> None:
    chosen = partition_of(partition) if partition in PAPERS else partition
    times = [
        speedup(TRACE, load_platform("zu9eg").with_value("pl.lanes", lanes), chosen).makespan_picoseconds
        for lanes in (1, 2, 3, 4, 8, 16)
    ]
    assert times == sorted(times, reverse=True)
    assert times[0] > times[-1]


def _deadline(deadline_ms: float) -> tuple[Report, str]:
    report = speedup(TRACE, "zu9eg", "paper", deadline_ms=deadline_ms)
    assert report.deadline is not None
    return report, report.deadline.verdict


def test_the_verdict_follows_the_band() -> None:
    band = speedup(TRACE, "zu9eg", "paper").makespan_ms
    worst_ms = speedup(TRACE, "zu9eg", "paper").worst_case_ms
    assert worst_ms > band.high  # jitter comes on top of the slow end
    assert _deadline(worst_ms)[1] == "PASS"
    assert _deadline(worst_ms * (1 - 1e-9))[1] == "MARGINAL"
    assert _deadline(band.high)[1] == "MARGINAL"
    assert _deadline(band.nominal)[1] == "MARGINAL"
    assert _deadline(band.low)[1] == "MARGINAL"
    report, verdict = _deadline(band.low * (1 - 1e-9))
    assert verdict == "FAIL"
    assert report.deadline is not None
    assert report.deadline.worst_case_margin_ms < report.deadline.margin_ms < 0.0
    assert "FAIL" in report.deadline_line


@pytest.mark.parametrize("deadline_ms", [0.0, -1.0, float("nan"), float("inf")])
def test_an_impossible_deadline_is_refused(deadline_ms: float) -> None:
    with pytest.raises(HwModelError, match=r"`deadline_ms` = .*: must be a positive number of milliseconds"):
        speedup(TRACE, "zu9eg", "paper", deadline_ms=deadline_ms)


def test_a_trace_of_nothing_is_refused() -> None:
    empty = synthetic_trace(iterations=0)
    empty["patterns"][0]["nnz_kkt"] = 0
    empty["solves"][0]["events"] = []
    with pytest.raises(HwModelError, match="takes no time at all"):
        speedup(empty, "zu9eg", "all_ps")


@pytest.mark.parametrize("partition", ["paper", "all_ps"])
def test_changing_one_parameter_changes_the_echo_of_that_one_only(partition: str) -> None:
    """And no parameter that counts as used is ignored: each changes the modelled times."""
    # Two cores, so that they may share work, and a PL clock at which DMA pays and feels the port.
    platform = load_platform("xc7z045").with_value("runtime.cores_used", 2).with_value("pl.clock_mhz", 400.0)
    platform = platform.with_value("link.dma_fixed_us", 0.2).with_value("ps.fork_join_us", 0.1)
    platform = platform.with_value("link.cache_clean_ns_per_line", 1.0)
    before = speedup(TRACE, platform, partition)
    steps = {"pl.lanes": 5, "pl.dividers": 2, "link.flags_per_register": 4, "link.ddr_efficiency": 0.5} | {
        "runtime.completion": "polling", "runtime.schedule": "overlapped", "runtime.cores_used": 1,
        "pl.storage_memory": "ultra_ram", "pl.storage_depth": "exact", "pl.microcode_memory": "ultra_ram",
        "resources.uram": 4, "pl.microcode_format": "flat", "ps.cache_line_bytes": 16, "ps.parallel_fraction": 0.7,
        "ps.price": "executed_instructions", "pl.parity": "per_word",
    }  # fmt: skip
    steps |= {
        "link.dma_to_pl_bytes_per_pl_cycle": 1.0,
        "pl.load_bytes_per_cycle": 1.0,
    }  # above the port already
    for row in before.assumptions:
        if row.key.startswith("pl.latencies.") or row.key == "pl.interleaved":  # refused here: another report
            continue
        value = (
            steps[row.key]
            if row.key in steps
            else row.value * (2 if isinstance(row.value, int) else 1.25) or 1.0
        )
        after = speedup(TRACE, platform.with_value(row.key, value), partition)
        pairs = zip(after.assumptions, before.assumptions, strict=True)
        changed = {a.key for a, b in pairs if replace(a, used=b.used) != b}
        assert changed == {row.key}
        [echo] = [entry for entry in after.assumptions if entry.key == row.key]
        assert (echo.value, echo.tag) == (value, "assumed")
        same = all(
            getattr(after, what) == getattr(before, what)
            for what in (
                "causes_picoseconds",
                "baseline_ms",
                "loading",
                "worst_case_ms",
                "energy",
                "baseline_energy",
                "throughput",
                "prices",
            )
        )
        shares = [[use.share / use.ceiling for use in report.area.uses] for report in (before, after)]
        assert (same and shares[0] == shares[1]) == (not row.used), row.key


def test_the_latency_preset_is_echoed_and_felt() -> None:
    before = speedup(TRACE, "zu9eg", "paper")
    after = speedup(TRACE, load_platform("zu9eg").with_value("pl.latency_preset", "vendor_ip"), "paper")
    values = [{row.key: row.value for row in report.assumptions} for report in (before, after)]
    assert [found["pl.latencies.f64.div_cycles"] for found in values] == [35, 57]
    assert after.makespan_picoseconds != before.makespan_picoseconds


def test_assumptions_of_the_other_datapath_and_of_an_idle_pl_do_not_count_as_used() -> None:
    used = {row.key for row in speedup(TRACE, "zu9eg", "paper").assumptions if row.used}
    assert "ps.div_f64_cycles" in used
    assert not {key for key in used if "f32" in key}
    assert {
        "resources.lut",
        "area.lut_ceiling",
        "pl.load_bytes_per_cycle",
    } <= used  # of whether it fits, and of the load
    idle = {row.key for row in speedup(TRACE, "zu9eg", "all_ps").assumptions if row.used}
    assert {key for key in idle if not key.startswith(("ps.", "energy."))} == {
        "runtime.cores_used",
        "runtime.ps_jitter_fraction",
    }
    assert "ps.cache_line_bytes" not in idle
    assert {key for key in idle if key.startswith("energy.")} == {
        f"energy.{name}"
        for name in ("core_cycle_pj", "core_idle_mw", "ps_static_mw", "pl_static_mw", "memory_static_mw")
    }


@pytest.mark.parametrize("device", platform_names())
@pytest.mark.parametrize("partition", ["all_ps", "paper", "factor_only"])
def test_every_headline_says_modelled(device: str, partition: str) -> None:
    report = speedup(TRACE, device, partition, deadline_ms=5.0)
    assert "modelled" in report.headline
    assert "modelled" in report.deadline_line
    text = report.to_markdown()
    rows = [
        line for line in text.splitlines() if not line.startswith("| `")
    ]  # of an assumption, with its own tag
    assert "measured" not in "\n".join(rows)
    titles = [line for line in text.splitlines() if line.startswith("#") and "cycle" in line + "time"]
    assert titles[0] == f"# Modelled cycle budget: {partition} on {device}"
    assert all("odelled" in title for title in titles if "time" in title or "cycles" in title)


def test_slower_is_said_plainly(tmp_path: Path) -> None:
    slow = load_platform("zu9eg").with_value("pl.clock_mhz", 20.0)
    report = speedup(TRACE, slow, "paper")
    assert report.speedup.high < 1.0
    assert "is SLOWER than all_ps" in report.headline
    assert "Modelled slower on the PL than in all_ps" in report.to_markdown()
    assert {row.module for row in report.slower_modules} >= {"cone_ops", "line_search"}
    undecided = speedup(TRACE, "zu9eg", "paper")
    assert undecided.speedup.low < 1.0 < undecided.speedup.high
    assert "may be faster or slower" in undecided.headline
    fast = speedup(TRACE, load_platform("fmql45t900"), "paper")
    assert fast.speedup.low > 1.0
    assert "is faster than all_ps" in fast.headline


def test_the_report_is_plain_data() -> None:
    report = speedup(TRACE, "zu9eg", "paper", deadline_ms=3.0)
    plain = report.to_dict()
    assert json.loads(json.dumps(plain, allow_nan=False)) == json.loads(json.dumps(plain))
    assert plain["schema"] == "orbsoc.hardware-report/1"
    assert plain["speedup"]["nominal"] == report.speedup.nominal
    assert plain["deadline"]["verdict"] in ("PASS", "FAIL", "MARGINAL")
    assert len(plain["assumptions"]) == len(list(load_platform("zu9eg").parameters()))
    assert plain["headline"] == report.headline
    assert {row["module"] for row in plain["modules"]} == {"ps", *PAPERS}


def test_markdown_puts_the_verdict_and_the_assumptions_first() -> None:
    text = speedup(TRACE, "zu9eg", "paper", deadline_ms=3.0).to_markdown()
    order = [
        "**modelled: paper on zu9eg", "**modelled deadline verdict", "## Assumptions", "| `ps.flop_per_cycle` | 0.32 ",
        "Not modelled:", "## Modelled time by cause", "## Modelled time by module", "| factorization | PL | 5 |",
        "## Modelled cycles of one run of each stage", "## Modelled time by iteration", "## Transfers and interrupts",
    ]  # fmt: skip
    places = [text.index(part) for part in order]
    assert places == sorted(places)
    assert "| `resources.lut` |" in text  # of whether it fits


def test_many_iterations_are_summarised_per_solve() -> None:
    report = speedup(synthetic_trace(iterations=12, solves=8), "zu9eg", "paper")
    text = report.to_markdown()
    assert "| solve | status | iterations | shortest µs | mean µs | longest µs | sum µs |" in text
    assert text.count("| SOLVED | 12 |") == 8
    assert len(report.iterations) == 8 * 13
