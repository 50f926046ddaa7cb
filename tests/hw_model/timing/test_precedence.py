"""Overlapped runs: what may not overtake what, and that the critical path still accounts for every picosecond."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hw_model.errors import PlatformError
from hw_model.platform.platform import Platform, load_platform
from hw_model.report.run import simulate
from hw_model.timing.actions import actions_of
from hw_model.timing.durations import Durations
from hw_model.timing.timeline import Timeline, lay_out, makespan_picoseconds, precedence_of
from hw_model.timing.trace import parse_trace
from hw_model.vocabulary import PL_MODULES
from tests.hw_model.random_traces import platforms, traces
from tests.hw_model.synthetic import stage, synthetic_trace
from tests.hw_model.timing.test_actions import trace_of
from tests.hw_model.tiny import partition_of, tiny_platform


def overlapped(platform: Platform) -> Platform:
    """The same with two cores, one of which controls the PL while everything runs side by side."""
    two = platform.with_value("runtime.cores_used", 2)
    return two.with_value("runtime.schedule", "overlapped")


def span(timeline: Timeline, name: str, kind: str, nth: int = 0) -> tuple[int, int]:
    """Start and end, in ns, of the nth run of a stage."""
    events = sorted({s.event for s in timeline.segments if s.stage == name and s.kind == kind})
    own = [s for s in timeline.segments if (s.stage, s.kind, s.event) == (name, kind, events[nth])]
    first, last = own[0], own[-1]
    return first.start_picoseconds // 1000, (last.start_picoseconds + last.duration_picoseconds) // 1000


STAGES = {
    "long": stage("factorization", "a", "b", 3, mul_sub=9000),
    "beside": stage("ps", "c", "d", 3, mul=5000),
    "after": stage("ps", "b", "e", 3, mul=5),
    "reuse": stage("ps", "c", "a", 3, mul=5),
}


def test_the_ps_works_beside_the_pl_on_what_the_pl_does_not_touch(tmp_path: Path) -> None:
    platform = overlapped(tiny_platform(tmp_path))
    timeline = simulate(trace_of(STAGES, ["long", "beside"]), platform, partition_of("factorization"))
    pl, ps = span(timeline, "long", "compute"), span(timeline, "beside", "compute")
    assert pl[0] < ps[1] < pl[1]
    assert ps[0] < pl[1]


@pytest.mark.parametrize("follower", ["after", "reuse"])
def test_neither_a_read_nor_an_overwrite_overtakes_the_pl(tmp_path: Path, follower: str) -> None:
    """`after` reads what the PL writes; `reuse` writes on the PS what the PL has its own copy of, and may not wait."""
    platform = overlapped(tiny_platform(tmp_path))
    timeline = simulate(trace_of(STAGES, ["long", follower]), platform, partition_of("factorization"))
    pl, ps = span(timeline, "long", "compute"), span(timeline, follower, "compute")
    if follower == "after":
        assert ps[0] > pl[1]
    else:
        copied = span(timeline, "long", "copy")
        assert copied[1] <= ps[0] < pl[1]


def test_one_thing_at_a_time_on_each_resource() -> None:
    timeline = simulate(synthetic_trace(iterations=3, solves=2), overlapped(load_platform("zu9eg")), "paper")
    for resource in ("core", "control", "pl", "dma"):
        own = sorted(
            (s for s in timeline.segments if s.resource == resource), key=lambda s: s.start_picoseconds
        )
        assert all(
            one.start_picoseconds + one.duration_picoseconds <= two.start_picoseconds
            for one, two in pairwise(own)
        )
    assert sum(timeline.busy().values()) > timeline.makespan_picoseconds


@settings(max_examples=60, deadline=None)
@given(trace=traces(), platform=platforms(), on_pl=st.sets(st.sampled_from(PL_MODULES)))
def test_the_critical_path_tiles_the_makespan_and_its_causes_add_up(trace, platform, on_pl) -> None:  # type: ignore[no-untyped-def]
    timeline = simulate(trace, overlapped(platform), partition_of(*on_pl))
    now = 0
    for segment in timeline.segments:
        if segment.critical:
            assert segment.start_picoseconds == now
            now += segment.duration_picoseconds
    assert now == timeline.makespan_picoseconds
    for levels in (("cause",), ("module", "cause"), ("solve", "iteration", "stage", "cause"), ("resource",)):
        assert sum(timeline.totals(*levels).values()) == timeline.makespan_picoseconds


@settings(max_examples=60, deadline=None)
@given(trace=traces(), platform=platforms(), on_pl=st.sets(st.sampled_from(PL_MODULES)))
def test_overlapping_is_never_slower_than_the_same_work_one_by_one(trace, platform, on_pl) -> None:  # type: ignore[no-untyped-def]
    checked, partition, platform = parse_trace(trace), partition_of(*on_pl), overlapped(platform)
    actions = actions_of(checked, partition)
    durations = Durations(checked, platform, partition)
    one_by_one = sum(durations.picoseconds(action.work) for action in actions)
    assert makespan_picoseconds(actions, durations) <= one_by_one
    assert all(
        k > max(before, default=-1) for k, before in enumerate(precedence_of(actions, durations).before)
    )
    assert lay_out(actions, durations, "").makespan_picoseconds == makespan_picoseconds(actions, durations)


def test_overlap_needs_a_core_for_control() -> None:
    with pytest.raises(PlatformError, match=r"`runtime\.cores_used` = 1: schedule \"overlapped\" needs 2"):
        load_platform("zu9eg").with_value("runtime.schedule", "overlapped")
    with pytest.raises(PlatformError, match=r"`runtime\.cores_used` = 5: this PS has 4"):
        load_platform("zu9eg").with_value("runtime.cores_used", 5)


def test_an_unknown_way_to_run_is_refused_by_name() -> None:
    with pytest.raises(PlatformError, match=r"`runtime\.schedule` = 'fast'.*serial\|overlapped"):
        load_platform("zu9eg").with_value("runtime.schedule", "fast")
    with pytest.raises(PlatformError, match=r"`runtime\.completion` = 'hope'.*interrupt\|polling"):
        load_platform("zu9eg").with_value("runtime.completion", "hope")
