"""The timeline: worked out by hand on a tiny computer, then conserved on random traces."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hw_model.report.run import simulate
from hw_model.timing.timeline import Timeline
from hw_model.vocabulary import CAUSES, PL_MODULES, picoseconds_of_cycles
from tests.hw_model.random_traces import platforms, traces
from tests.hw_model.synthetic import synthetic_trace
from tests.hw_model.tiny import partition_of, tiny_platform, tiny_trace


def lines(timeline: Timeline) -> list[tuple[str, str, str, int]]:
    """(stage, side, cause, nanoseconds) of every segment."""
    return [(s.stage, s.side, s.cause, s.duration_picoseconds // 1000) for s in timeline.segments]


def test_all_ps_by_hand(tmp_path: Path) -> None:
    timeline = simulate(tiny_trace(), tiny_platform(tmp_path), "all_ps")
    # 1 ns a cycle: 10 flops / 0.5; (9·2 + 1) / 0.5 + 2·30; 3 / 0.5 + 30.
    assert lines(timeline) == [
        ("make", "ps", "ps", 20),
        ("factor", "ps", "ps", 98),
        ("check", "ps", "ps", 36),
    ]
    assert timeline.makespan_picoseconds == 154_000


def test_factorization_on_the_pl_by_hand(tmp_path: Path) -> None:
    timeline = simulate(tiny_trace(), tiny_platform(tmp_path), partition_of("factorization"))
    # A write takes 60 ns, a read 100 + 10 cycles of 10 ns = 200 ns. A frame is 4 writes, its confirmation
    # 2 reads. v: 800 bytes by DMA, 2000 ns + 800 / 0.2; by the core 200 · 60 would be longer.
    # w: 16 bytes by the core, 4 · 200; by DMA 2000 + 16 / 0.1 would be longer.
    # factor: issue ⌈10/2⌉ = 5, divider 2 · 4 = 8, chain 100, no overlap; drain 8 + 7 + 4.
    assert lines(timeline) == [
        ("(problem data)", "ps", "link", 4 * 60 + 2 * 200),
        ("make", "ps", "ps", 20),
        ("make", "ps", "link", 640),
        ("factor", "ps", "link", 6000),
        ("factor", "ps", "link", 240),
        ("factor", "pl", "issue", 50),
        ("factor", "pl", "dependency", 1000),
        ("factor", "pl", "divider", 80),
        ("factor", "pl", "drain", 190),
        ("factor", "ps", "interrupt", 1000),
        ("factor", "ps", "link", 2 * 200 + 60),
        ("check", "ps", "link", 800),
        ("check", "ps", "ps", 36),
        ("check", "ps", "link", 640),
        ("(result)", "ps", "link", 200),
    ]
    assert timeline.makespan_picoseconds == 11_996_000
    assert timeline.totals("iteration") == {(0,): 1_300_000, (1,): 10_696_000}
    assert timeline.totals("module", "side") == {
        ("ps", "ps"): 2_976_000,
        ("factorization", "ps"): 7_700_000,
        ("factorization", "pl"): 1_320_000,
    }


def test_a_result_left_on_the_pl_is_brought_back(tmp_path: Path) -> None:
    trace = tiny_trace()
    trace["solves"][0]["events"] = [["factor", 0]]
    timeline = simulate(trace, tiny_platform(tmp_path), partition_of("factorization"))
    assert lines(timeline)[-2:] == [("(result)", "ps", "link", 200), ("(result)", "ps", "link", 800)]
    assert timeline.segments[-1].detail == "copy w to the PS by core"


def test_single_precision_halves_the_words_and_takes_its_own_latencies(tmp_path: Path) -> None:
    trace = tiny_trace() | {"datapath": "f32"}
    timeline = simulate(trace, tiny_platform(tmp_path), partition_of("factorization"))
    found = {(s.stage, s.detail, s.cause): s.duration_picoseconds // 1000 for s in timeline.segments}
    assert found["factor", "copy v to the PL by dma", "link"] == 2000 + 400 * 5
    assert found["factor", "compute", "divider"] == 2 * 4 * 10
    assert found["check", "compute", "ps"] == 6 + 15


@pytest.mark.parametrize("clock_mhz", [150.0, 333.3333, 1.0, 997.0])
def test_rounded_parts_add_up_to_the_rounded_whole(clock_mhz: float) -> None:
    parts = [1, 3, 0, 7, 10**6, 2]
    [whole] = picoseconds_of_cycles([sum(parts)], clock_mhz)
    assert sum(picoseconds_of_cycles(parts, clock_mhz)) == whole
    assert picoseconds_of_cycles([1, 1, 1], 150.0) == [6667, 6666, 6667]


@settings(max_examples=60, deadline=None)
@given(trace=traces(), platform=platforms(), on_pl=st.sets(st.sampled_from(PL_MODULES)))
def test_causes_sum_to_the_makespan_at_every_level(trace, platform, on_pl) -> None:  # type: ignore[no-untyped-def]
    timeline = simulate(trace, platform, partition_of(*on_pl))
    now = 0
    for segment in timeline.segments:
        assert segment.start_picoseconds == now
        assert segment.duration_picoseconds >= 0
        assert segment.cause in CAUSES
        now += segment.duration_picoseconds
    assert now == timeline.makespan_picoseconds
    for levels in (
        ("cause",), ("side",), ("module", "cause"), ("stage", "cause"), ("solve", "iteration", "cause"), ("kind",),
    ):  # fmt: skip
        assert sum(timeline.totals(*levels).values()) == timeline.makespan_picoseconds
    # Within one level the causes of each member add up to that member.
    for fine, coarse in (
        (("module", "cause"), ("module",)),
        (("solve", "iteration", "cause"), ("solve", "iteration")),
    ):
        whole = timeline.totals(*coarse)
        for key, picoseconds in timeline.totals(*fine).items():
            whole[key[:-1]] -= picoseconds
        assert set(whole.values()) <= {0}


@settings(max_examples=40, deadline=None)
@given(trace=traces(), platform=platforms())
def test_a_partition_moves_work_but_loses_none(trace, platform) -> None:  # type: ignore[no-untyped-def]
    events = sum(len(solve["events"]) for solve in trace["solves"])
    for partition in (partition_of(), partition_of("factorization"), partition_of(*PL_MODULES)):
        timeline = simulate(trace, platform, partition)
        done = {(s.solve, s.event) for s in timeline.segments if s.kind == "compute"}
        # A stage without operations takes no PS time; every other one appears exactly once.
        idle = sum(
            not any(trace["patterns"][solve["pattern"]]["stages"][name]["operations"].values())
            and partition.side(trace["patterns"][solve["pattern"]]["stages"][name]["module"]) == "ps"
            for solve in trace["solves"]
            for name, _ in solve["events"]
        )
        assert len(done) == events - idle


def test_nothing_of_the_pl_happens_when_all_is_on_the_ps() -> None:
    timeline = simulate(synthetic_trace(iterations=3), "zu9eg", "all_ps")
    assert {(s.kind, s.cause, s.side) for s in timeline.segments} == {
        ("build", "ps", "ps"),
        ("compute", "ps", "ps"),
    }


def test_a_module_on_the_pl_interrupts_once_a_run() -> None:
    trace = synthetic_trace(iterations=5)
    timeline = simulate(trace, "zu9eg", "factor_only")
    launches = [s for s in timeline.segments if s.kind == "launch"]
    interrupts = [s for s in timeline.segments if s.kind == "interrupt"]
    assert len(launches) == len(interrupts) == 6  # start-up and five iterations
    assert {s.stage for s in interrupts} == {"factorize"}


def test_cache_maintenance_and_cores_by_hand(tmp_path: Path) -> None:
    platform = tiny_platform(tmp_path).with_value("link.cache_clean_ns_per_line", 3.0)
    platform = platform.with_value("link.cache_invalidate_ns_per_line", 2.0)
    timeline = simulate(tiny_trace(), platform, partition_of("factorization"))
    # v: 800 bytes by DMA are 13 lines of 64; w goes by the core, past the cache.
    assert [s.duration_picoseconds for s in timeline.segments if s.cause == "cache"] == [13 * 3_000]
    shared = simulate(tiny_trace(), platform.with_value("runtime.cores_used", 2), "all_ps")
    # Half of a stage is shared by two cores, and forking and joining costs 10 ns where it pays.
    assert [s.duration_picoseconds // 1000 for s in shared.segments] == [20, 84, 36]


def test_generating_a_problem_comes_first_on_either_side(tmp_path: Path) -> None:
    platform = tiny_platform(tmp_path).with_value("ps.build_flops_per_nonzero", 10.0)
    for partition in ("all_ps", "paper"):
        first = simulate(tiny_trace(), platform, partition).segments[0]
        # 5 nonzeros of 10 flops at half a flop per nanosecond.
        assert (first.kind, first.cause, first.duration_picoseconds) == ("build", "ps", 100_000)
