"""Microcode that is streamed: what a segment waits for, as the RTL's ports have it, and by its bits alone."""

from __future__ import annotations

from functools import cache

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hw_model import HwModelError, load_platform, parse_trace, speedup
from hw_model.area.budget import budget
from hw_model.area.engine import STREAM_ROWS
from hw_model.timing.stage_cycles import Memory
from hw_model.timing.stream import fetch_cycles, is_streamed, memory_of
from hw_model.timing.trace import Trace
from orbsoc.hw.emulation import PsScheduler, resident_program
from orbsoc.hw.exact_cycles import exact_cycles
from orbsoc.hw.schedules import Engine, pl_program
from orbsoc.rtl.validation import problems
from tests.hw_model.report.test_best import PAPER, TRACE, scheduled
from tests.hw_model.synthetic import synthetic_trace
from tests.rtl.engine_sources import parameters

STREAMED = load_platform("zu9eg").with_values({"pl.microcode_memory": "streamed", "pl.clock_mhz": 150.0})
PROBLEM = problems()["12 variables, cones 4 6"]
STREAMS = resident_program().streams


@cache
def recorded() -> Trace:
    """Of one solve."""
    scheduler = PsScheduler()
    scheduler(PROBLEM)
    return parse_trace(scheduler.trace)


@given(st.integers(1, 10**6), st.floats(1.0, 1e7), st.integers(1, 4))
def test_by_its_bits_a_segment_takes_the_longer_of_loading_and_running_after_its_first_line(
    cycles: int, size_bytes: float, ports: int
) -> None:
    platform = STREAMED.with_value("pl.stream_ports", ports)
    wait = fetch_cycles(cycles, size_bytes, platform)
    loading = size_bytes / (8.0 * ports)  # what the stream takes; its port gives 26 a cycle
    first = platform.pl.stream_start_us.value * 150.0 + 2
    assert max(loading, cycles) <= cycles + wait - first <= max(loading, cycles) + 1.0


def test_a_narrow_port_slows_the_stream() -> None:
    narrow = load_platform("xc7z045").with_values(
        {"pl.microcode_memory": "streamed", "pl.clock_mhz": 150.0}
    )  # 1200 MB/s at 75 %
    assert memory_of(narrow) == Memory(1, 64, 45, 768, 1024)
    assert (
        fetch_cycles(1000, 10240.0, narrow) == 45 + 2 + 707
    )  # 0.3 us; 10240 bytes at 6 a cycle, less 1000 cycles


def test_ports_of_128_bits_are_those_that_take_more_than_8_bytes_a_cycle() -> None:
    wide = STREAMED.with_values({"pl.stream_bytes_per_cycle": 12.0, "pl.stream_ports": 4})
    assert memory_of(wide) == Memory(4, 128, 45, 768, 1024)


@pytest.mark.parametrize("lanes", [4, 8])
def test_a_memory_as_fast_as_the_decoder_costs_the_way_of_the_first_line(lanes: int) -> None:
    program = pl_program(PROBLEM, None, Engine(lanes=lanes), None, STREAMS)
    for latency in (1, 60):
        for name, segment in program.segments.items():
            memory = Memory(lanes // 4, 128, latency, 1, 1)
            found = program.core.demand(name).cycles(**memory._asdict())
            assert found == segment.compressed_cycles + latency + 2


def test_a_slower_memory_takes_longer_and_no_less_than_its_beats() -> None:
    program = pl_program(PROBLEM, None, Engine(), None, STREAMS)
    for name, segment in program.segments.items():
        demand, before = program.core.demand(name), 0
        for per in (1, 2, 3, 7):
            found = demand.cycles(ports=1, beat_bits=64, latency=20, beats=1, per=per)
            assert found > max(before, segment.compressed_bits // 64 * per)
            before = found


def test_the_price_of_a_segment_is_what_its_items_take_of_the_platforms_memory() -> None:
    """By the bits alone it would be less: its words are not spread evenly."""
    platform = STREAMED.with_value("pl.stream_ports", 1)
    cycles = exact_cycles([PROBLEM])
    trace = recorded()
    core = pl_program(PROBLEM, None, None).core
    on_chip = platform.with_value("pl.microcode_memory", "block_ram")
    for stage in ("factorize", "nt_scaling"):
        plain = cycles(trace, on_chip, 0, stage)
        streamed = cycles(trace, platform, 0, stage).microcode
        assert streamed is not None
        assert streamed.streamed is not None
        assert plain.microcode == streamed
        found = streamed.streamed(memory_of(platform))
        assert found == core.demand(stage).cycles(**memory_of(platform)._asdict())
        assert found >= plain.cycles + fetch_cycles(plain.cycles, streamed.bits / 8, platform)


def test_lines_that_ports_cannot_divide_are_refused() -> None:
    """Lines have 128 bits here."""
    cycles = exact_cycles([PROBLEM])
    for ports in (3, 4):
        platform = STREAMED.with_value("pl.stream_ports", ports)
        allowed = f"`pl.stream_ports` = {ports}: allowed is 1, 2 or 4, with 64 bits or more each of a line"
        with pytest.raises(HwModelError, match=allowed):
            budget(recorded(), platform, PAPER, cycles)
        code = cycles(recorded(), platform, 0, "factorize").microcode
        assert code is not None
        assert code.streamed is not None
        with pytest.raises(HwModelError, match=f"`pl.stream_ports` = {ports} of 64 bits: configuration"):
            code.streamed(memory_of(platform))


def test_the_rows_of_a_port_are_the_rtls() -> None:
    assert parameters()["STREAM_ROWS"] == STREAM_ROWS


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
