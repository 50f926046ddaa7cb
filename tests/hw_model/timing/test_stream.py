"""Microcode that is streamed: what a segment waits for, between its bounds."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hw_model import HwModelError, load_platform, parse_trace, speedup
from hw_model.timing.stream import fetch_cycles, is_streamed
from tests.hw_model.report.test_best import PAPER, TRACE, scheduled
from tests.hw_model.synthetic import synthetic_trace

STREAMED = load_platform("zu9eg").with_values({"pl.microcode_memory": "streamed", "pl.clock_mhz": 150.0})


@given(st.integers(1, 10**6), st.floats(1.0, 1e7), st.integers(1, 4))
def test_a_segment_takes_no_less_than_loading_and_no_more_than_loading_and_running(
    cycles: int, size_bytes: float, ports: int
) -> None:
    platform = STREAMED.with_value("pl.stream_ports", ports)
    wait = fetch_cycles(cycles, size_bytes, platform)
    loading = size_bytes / (8.0 * ports)  # what the stream takes; its port gives 26 a cycle
    start = platform.pl.stream_start_us.value * 150.0
    assert cycles + wait >= start + max(loading, cycles) - 1e-6
    assert cycles + wait <= start + loading + cycles + 2.0


def test_the_wait_is_the_first_half_where_running_takes_longer_than_loading() -> None:
    assert fetch_cycles(10**6, 10240.0, STREAMED) == 45 + 128  # 0.3 us, and 1024 bytes at 8 a cycle


def test_a_narrow_port_slows_the_stream() -> None:
    narrow = load_platform("xc7z045").with_values(
        {"pl.microcode_memory": "streamed", "pl.clock_mhz": 150.0}
    )  # 1200 MB/s at 75 %
    assert fetch_cycles(10**6, 10240.0, narrow) == 45 + 171  # 0.3 us, and 1024 bytes at 6 a cycle


def test_only_what_runs_once_an_attempt_is_streamed_at_the_start() -> None:
    start = STREAMED.with_value("pl.microcode_memory", "streamed_start")
    names = TRACE.patterns[0].stages
    streamed = {name for name in names if is_streamed(TRACE, start, 0, name)}
    assert "equilibrate" in streamed
    assert "factorize" not in streamed
    plain, some, all_of_it = (
        speedup(TRACE, platform, PAPER, cycles=scheduled(60.0)).causes_picoseconds["fetch"]
        for platform in (load_platform("zu9eg"), start, STREAMED)
    )
    assert plain == 0 < some < all_of_it


def test_an_estimate_cannot_be_streamed() -> None:
    with pytest.raises(HwModelError, match=r"`pl\.microcode_memory` = 'streamed': .* ask for schedules"):
        speedup(parse_trace(synthetic_trace(iterations=1)), STREAMED, PAPER)
