"""Timelines reach the trace viewer whole: on each track one thing at a time, and on the units what they execute."""

from __future__ import annotations

import json
from collections import defaultdict
from collections.abc import Iterator
from itertools import pairwise
from typing import Any, get_args

import numpy as np
import pytest

from hw_model.platform.parameter import Tag
from hw_model.platform.partition import load_partition
from hw_model.platform.platform import Platform, load_platform
from hw_model.report import unit_tracks
from hw_model.report.perfetto import as_text, trace_events
from hw_model.report.run import simulate
from hw_model.timing.stage_cycles import PlCycles, StageCycles, estimated
from hw_model.timing.trace import Trace, parse_trace
from hw_model.timing.unit_schedules import UnitSchedule, UnitSchedules
from tests.hw_model.synthetic import synthetic_trace
from tests.hw_model.timing.test_precedence import overlapped

TRACE = parse_trace(synthetic_trace(iterations=3, solves=2))
ZU9EG = load_platform("zu9eg").with_value("pl.clock_mhz", 150.0)
NAMES = ("mul", "sub_mul", "div")
EVERY, OPERATIONS = 3, 400


def cycles(trace: Trace, platform: Platform, pattern: int, stage: str) -> PlCycles:
    """Every segment takes as long as `units` needs."""
    return PlCycles({"issue": OPERATIONS * EVERY + 40}, 0, "issue", "schedule")


def units(trace: Trace, platform: Platform, pattern: int, stage: str) -> UnitSchedule:
    """Lane 0: two kinds in turn, without a pause; lane 1: one a few cycles; lane 3: once, late; a divider: three times."""
    dense, sparse, rare = np.arange(OPERATIONS), EVERY * np.arange(OPERATIONS), np.array([900])
    divisions = np.array([0, 32, 700])
    began = np.r_[dense, sparse, rare, divisions]
    on = np.repeat([0, 1, 3, 4], [len(dense), len(sparse), 1, 3])
    kinds = np.r_[dense // 10 % 2, np.ones(len(sparse)), 0, np.full(3, 2)].astype(int)
    return UnitSchedule(4, began, on, kinds, NAMES)


def tracks(document: dict[str, Any]) -> dict[str, list[dict[str, Any]]]:
    """Complete events of each named track, by time."""
    found: defaultdict[str, list[dict[str, Any]]] = defaultdict(list)
    names: dict[tuple[int, int], str] = {}
    for event in json.loads(as_text(document))["traceEvents"]:
        key = (event["pid"], event["tid"])
        if event["ph"] == "X":
            found[names[key]].append(event)
        elif event["name"] == "thread_name":
            assert key not in names
            names[key] = event["args"]["name"]
    return {name: sorted(own, key=lambda event: event["ts"]) for name, own in found.items()}


def drawn(
    platform: Platform,
    name: str = "paper",
    source: StageCycles = cycles,
    schedules: UnitSchedules | None = units,
) -> dict[str, Any]:
    partition = load_partition(name)
    timeline = simulate(TRACE, platform, partition, source)
    return trace_events(timeline, TRACE, platform, partition, source, schedules)


def ends_ns(event: dict[str, Any]) -> tuple[int, int]:
    start = round(1000 * event["ts"])
    return start, start + round(1000 * event["dur"])


def platforms() -> Iterator[Platform]:
    for clock in (150.0, 333.3, 997.0):
        platform = ZU9EG.with_values({"pl.clock_mhz": clock, "runtime.cores_used": 3})
        yield from (platform, platform.with_value("runtime.schedule", "overlapped"))
    yield overlapped(load_platform("xc7z020"))
    yield ZU9EG.with_value("runtime.completion", "polling")


@pytest.mark.parametrize("platform", list(platforms()))
def test_on_one_track_no_event_overlaps_another(platform: Platform) -> None:
    found = tracks(drawn(platform))
    assert {"core 0", "factorization", "lane 0", "lane 1", "lane 3", "divider 0"} <= found.keys()
    for name, own in found.items():
        for one, two in pairwise(own):
            assert ends_ns(one)[1] <= ends_ns(two)[0], name


def test_a_units_track_has_the_operations_of_its_schedule_in_every_run() -> None:
    found = tracks(drawn(ZU9EG))
    runs = sum(segment.side == "pl" for segment in simulate(TRACE, ZU9EG, "paper", cycles).segments)
    for name, operations, busy in (
        ("lane 0", OPERATIONS, OPERATIONS), ("lane 1", OPERATIONS, OPERATIONS), ("lane 3", 1, 1), ("divider 0", 3, 12),
    ):  # fmt: skip
        assert sum(event["args"]["operations"] for event in found[name]) == runs * operations
        assert sum(event["args"]["busy_cycles"] for event in found[name]) == runs * busy
    assert "lane 2" not in found


def test_the_longest_iteration_is_drawn_operation_by_operation_and_the_rest_coarsely() -> None:
    document = drawn(ZU9EG)
    timeline = simulate(TRACE, ZU9EG, "paper", cycles)
    chosen = timeline.longest_iteration()
    assert chosen[1] > 0
    found = tracks(document)
    period_ns = 1e3 / ZU9EG.pl.clock_mhz.value
    for name in ("lane 0", "lane 1", "divider 0"):
        full = [e for e in found[name] if (e["args"]["solve"], e["args"]["iteration"]) == chosen]
        rest = [e for e in found[name] if (e["args"]["solve"], e["args"]["iteration"]) != chosen]
        assert full
        assert rest
        for event in full:  # as long as the unit is held
            assert 1000 * event["dur"] == pytest.approx(period_ns * event["args"]["busy_cycles"], abs=1.0)
            assert event["name"].split(" ")[0] in NAMES
        for event in rest:
            mix = dict(part.rsplit(" ", 1) for part in event["args"]["executes"].split(", "))
            assert sum(map(int, mix.values())) == event["args"]["operations"]
            span = 1000 * event["dur"] / period_ns
            rounded = max(0.01, 1.0 / (1000 * event["dur"]))  # a nanosecond of the slice
            assert event["args"]["busy_share"] == pytest.approx(
                event["args"]["busy_cycles"] / span, rel=rounded
            )
    lane = [e for e in found["lane 0"] if (e["args"]["solve"], e["args"]["iteration"]) == chosen]
    assert {e["args"]["operations"] for e in lane} == {10}  # ten of a kind in a row are one slice
    assert all(e["args"]["executes"] == "mul 200, sub_mul 200" for e in found["lane 0"] if e not in lane)


def test_a_long_iteration_is_drawn_in_full_as_far_as_the_viewer_takes_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    whole = len(drawn(ZU9EG)["traceEvents"])
    monkeypatch.setattr(unit_tracks, "MOST_SLICES", 2000)
    found = tracks(drawn(ZU9EG))
    assert sum(map(len, found.values())) < whole - 1000
    full = [e for name in ("lane 0", "lane 1") for e in found[name] if "executes" not in e["args"]]
    assert 0 < len(full) <= 2000
    runs = sum(segment.side == "pl" for segment in simulate(TRACE, ZU9EG, "paper", cycles).segments)
    assert sum(event["args"]["operations"] for event in found["lane 1"]) == runs * OPERATIONS


def test_without_schedules_there_are_no_units_and_the_document_says_so() -> None:
    document = drawn(ZU9EG, source=estimated, schedules=None)
    assert not {"lane 0", "divider 0"} & tracks(document).keys()
    assert (document["otherData"]["unit_tracks"], document["otherData"]["pl_cycles"]) == (False, "estimated")
    assert drawn(ZU9EG)["otherData"]["pl_cycles"] == "exact schedules"
    assert drawn(ZU9EG, "all_ps")["otherData"]["pl_cycles"] == "none"


@pytest.mark.parametrize("schedule", ["serial", "overlapped"])
@pytest.mark.parametrize("cores", [2, 4])
def test_every_core_that_the_model_uses_is_drawn(schedule: str, cores: int) -> None:
    """Serial: all compute. Overlapped: the last one controls the PL, and does nothing else."""
    platform = ZU9EG.with_values({"runtime.cores_used": cores, "runtime.schedule": schedule})
    timeline = simulate(TRACE, platform, "paper", cycles)
    found = tracks(drawn(platform))
    computing = cores - (schedule == "overlapped")
    assert timeline.cores == computing
    shared = [segment for segment in timeline.segments if segment.shared_cycles]
    assert bool(shared) == (computing > 1)
    for core in range(1, computing):
        own = [event for event in found[f"core {core}"] if event["cat"] == "ps"]
        assert len(own) == len(shared)
        for event, segment in zip(own, shared, strict=True):
            start, end = ends_ns(event)
            assert end == (segment.end_picoseconds + 500) // 1000  # they join for the last part
            took = 1e3 * segment.shared_cycles / platform.ps.clock_mhz.value
            assert end - start == pytest.approx(took, abs=1.0)
            assert 0 < segment.shared_cycles < segment.cycles
    controlling = f"core {cores - 1 if schedule == 'overlapped' else 0}"
    launches = [event for event in found[controlling] if event["args"]["detail"] == "launch"]
    assert len(launches) == sum(segment.detail == "launch" for segment in timeline.segments)
    if schedule == "overlapped":
        assert {event["cat"] for event in found[controlling]} == {"link", "interrupt"}


@pytest.mark.parametrize("platform", [ZU9EG, overlapped(load_platform("xc7z020"))])
def test_every_segment_reaches_the_trace_viewer(platform: Platform) -> None:
    timeline = simulate(TRACE, platform, "paper")
    document = drawn(platform, source=estimated, schedules=None)
    found = tracks(document)
    causes = [event for name, own in found.items() if name.startswith("cycles: ") for event in own]
    assert len(causes) == sum(segment.side == "pl" for segment in timeline.segments)
    link = ("registers and copies by a core", "dma", "cache maintenance", "interrupt")
    others = [event for name, own in found.items() if name in link or name in PL_NAMES for event in own]
    on_ps = [event for event in found["core 0"] if event["cat"] == "ps"]
    assert len(others) + len(on_ps) == len(timeline.segments)
    ends = max(event["ts"] + event["dur"] for own in found.values() for event in own)
    assert ends == pytest.approx(timeline.makespan_picoseconds / 1e6, abs=1e-3)
    assert document["otherData"]["makespan_us"] == timeline.makespan_picoseconds / 1e6
    echo = document["otherData"]["parameters"]
    assert echo.keys() == {key for key, _ in platform.parameters()}
    assert all(row["tag"] in get_args(Tag) for row in echo.values())
    assert not echo["runtime.ps_jitter_fraction"]["used"]
    assert echo["ps.clock_mhz"]["used"]


PL_NAMES = {stage.module for stage in TRACE.patterns[0].stages.values()} - {"ps"}
