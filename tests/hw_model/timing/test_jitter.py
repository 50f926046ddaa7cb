"""Jitter: the analytic worst case bounds every run, and is met when every jitter is at its maximum."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hw_model.errors import HwModelError
from hw_model.platform.platform import Platform, load_platform
from hw_model.report.speedup import speedup
from hw_model.timing.jitter import distribution
from hw_model.vocabulary import PL_MODULES
from tests.hw_model.random_traces import platforms, traces
from tests.hw_model.synthetic import synthetic_trace
from tests.hw_model.timing.test_precedence import overlapped
from tests.hw_model.tiny import partition_of, tiny_platform, tiny_trace

TRACE = synthetic_trace(iterations=4)


def three_platforms() -> list[Platform]:
    zu9eg = load_platform("zu9eg")
    return [zu9eg, zu9eg.with_value("runtime.completion", "polling"), overlapped(load_platform("xc7z020"))]


@pytest.mark.parametrize("platform", three_platforms(), ids=["serial", "polling", "overlapped"])
def test_ten_thousand_runs_stay_below_the_bound_and_spread(platform: Platform) -> None:
    found = distribution(TRACE, platform, "paper", runs=10_000, seed=1)
    assert found.picoseconds.size == 10_000
    assert found.nominal_picoseconds < found.picoseconds[0] < found.picoseconds[-1] <= found.bound_picoseconds
    assert found.quantile_ms(0.5) < found.quantile_ms(0.99) <= found.quantile_ms(1.0)
    steady = distribution(
        TRACE, platform.with_value("runtime.jitter_exponent", 1.0), "paper", runs=100, seed=1
    )
    assert steady.picoseconds[0] > found.quantile_ms(0.5) * 1e9  # uniform draws are larger than cubed ones


@pytest.mark.parametrize("platform", three_platforms(), ids=["serial", "polling", "overlapped"])
def test_the_bound_is_met_when_every_jitter_is_at_its_maximum(platform: Platform) -> None:
    found = distribution(TRACE, platform, "paper", runs=2, draw=np.ones)
    assert found.picoseconds[-1] <= found.bound_picoseconds <= 1.001 * found.picoseconds[-1]


@settings(max_examples=30, deadline=None)
@given(trace=traces(), platform=platforms(), on_pl=st.sets(st.sampled_from(PL_MODULES)), side=st.booleans())
def test_on_any_computer_the_bound_holds_and_is_met(trace, platform, on_pl, side) -> None:  # type: ignore[no-untyped-def]
    if side:
        platform = overlapped(platform)
    partition = partition_of(*on_pl)
    drawn = distribution(trace, platform, partition, runs=50, seed=3)
    assert drawn.nominal_picoseconds <= drawn.picoseconds[0]
    assert drawn.picoseconds[-1] <= drawn.bound_picoseconds
    top = distribution(trace, platform, partition, runs=1, draw=np.ones)
    assert top.picoseconds[-1] == top.bound_picoseconds == drawn.bound_picoseconds


def test_without_jitter_every_run_is_the_nominal_one() -> None:
    platform = load_platform("zu9eg")
    for key in ("runtime.ps_jitter_fraction", "runtime.link_jitter_fraction", "runtime.interrupt_jitter_us"):
        platform = platform.with_value(key, 0.0)
    found = distribution(TRACE, platform, "paper", runs=5)
    assert set(found.picoseconds.tolist()) == {found.nominal_picoseconds}
    assert found.bound_picoseconds == found.nominal_picoseconds


def test_the_seed_is_the_run() -> None:
    one, same, other = (
        distribution(TRACE, "zu9eg", "paper", runs=20, seed=seed).picoseconds for seed in (7, 7, 8)
    )
    assert one.tolist() == same.tolist() != other.tolist()


def test_the_bound_by_hand(tmp_path: Path) -> None:
    """The run of test_timeline: 9440 ns of link at 25 %, 76 ns of PS at 50 %, one interrupt with 2 µs."""
    found = distribution(tiny_trace(), tiny_platform(tmp_path), partition_of("factorization"), runs=1)
    link_ns, ps_ns = 640 + 640 + 6000 + 240 + 460 + 800 + 640 + 200, 20 + 36
    assert found.nominal_picoseconds == 11_996_000
    assert found.bound_picoseconds == 11_996_000 + 250 * link_ns + 500 * ps_ns + 2_000_000


def test_a_report_says_the_worst_case_and_judges_by_it(tmp_path: Path) -> None:
    roomy = {
        f"resources.{kind}": 10**6 for kind in ("lut", "ff", "dsp", "bram36")
    }  # what does not fit fails whatever its time
    platform = tiny_platform(tmp_path).with_values(roomy)
    report = speedup(tiny_trace(), platform, partition_of("factorization"), deadline_ms=0.0150)
    assert report.jitter_ms == pytest.approx(
        report.worst_case_ms - 0.011996
    )  # the tiny computer has no bands
    assert report.deadline is not None
    assert report.deadline.verdict == "MARGINAL"
    assert report.deadline.worst_case_margin_ms == pytest.approx(0.0150 - report.worst_case_ms)


def test_polling_ends_between_one_and_two_reads_after_the_segment(tmp_path: Path) -> None:
    platform = tiny_platform(tmp_path).with_value("runtime.completion", "polling")
    waits = distribution(tiny_trace(), platform, partition_of("factorization"), runs=1, draw=np.ones)
    by_interrupt = distribution(tiny_trace(), tiny_platform(tmp_path), partition_of("factorization"), runs=1)
    assert waits.nominal_picoseconds == by_interrupt.nominal_picoseconds - 1_000_000 + 200_000
    assert (
        waits.bound_picoseconds - waits.nominal_picoseconds
        == by_interrupt.bound_picoseconds - 11_996_000 - 2_000_000 + 200_000
    )


def test_no_runs_are_refused() -> None:
    with pytest.raises(HwModelError, match=r"`runs` = 0: must be at least 1"):
        distribution(TRACE, "zu9eg", "paper", runs=0)


def test_runs_too_long_to_be_added_up_exactly_are_refused() -> None:
    """Sums of picoseconds beyond 63 bits would wrap around, silently."""
    sluggish = load_platform("zu9eg").with_values(
        {"runtime.interrupt_entry_us": 1e9, "link.register_write_ns": 1e9}
    )
    with pytest.raises(HwModelError, match=r"a run of .* s: at most 9007 s"):
        distribution(TRACE, sluggish, "paper", runs=2)
