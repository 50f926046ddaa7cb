"""Differences add up, and timelines reach Perfetto whole."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from hw_model.area_figure import area_figure
from hw_model.difference_figure import difference_figure
from hw_model.explain import Configuration, explain
from hw_model.gantt_figure import gantt_figure
from hw_model.partition import load_partition
from hw_model.perfetto import trace_events
from hw_model.platform import Platform, load_platform
from hw_model.resources import budget
from hw_model.timeline import simulate
from hw_model.trace import parse_trace
from tests.hw_model.synthetic import synthetic_trace
from tests.hw_model.test_order import overlapped

TRACE = synthetic_trace(iterations=3, solves=2)
PNG = b"\x89PNG\r\n\x1a\n"


def configuration(platform: Platform, split: str) -> Configuration:
    return Configuration(f"{platform.name}:{split}", platform, load_partition(split))


A = configuration(load_platform("zu9eg"), "paper")
PAIRS = [
    (A, A),
    (A, configuration(load_platform("zu9eg").with_value("pl.lanes", 8), "factorization+linear_solve")),
    (A, configuration(load_platform("fmql45t900"), "all_ps")),
    (A, configuration(overlapped(load_platform("zu9eg")), "paper")),
]


@pytest.mark.parametrize(("a", "b"), PAIRS)
def test_the_parts_of_a_difference_add_up_to_it(a: Configuration, b: Configuration) -> None:
    found = explain(TRACE, a, b)
    for level in (found.by_cause, found.by_module, found.by_module_and_cause):
        assert sum(pair[0] for pair in level.values()) == found.a_picos
        assert sum(pair[1] for pair in level.values()) == found.b_picos
    assert found.a_picos == simulate(TRACE, a.platform, a.partition).makespan_picos
    assert found.headline.startswith("modelled: ")
    plain = found.to_dict()
    assert json.loads(json.dumps(plain, allow_nan=False)) == plain
    total = sum(row["difference"] for row in plain["by_cause_ms"].values())
    assert total == pytest.approx((found.b_picos - found.a_picos) / 1e9, abs=1e-9)


def test_a_difference_names_what_was_changed() -> None:
    found = explain(TRACE, *PAIRS[1])
    assert found.parameters == (("pl.lanes", 4, 8),)
    assert set(found.moved) == {"matrix_update", "matrix_scaling", "cone_ops", "line_search"}
    assert explain(TRACE, *PAIRS[0]).headline.endswith("ms")
    assert "take the same time" in explain(TRACE, *PAIRS[0]).headline


@pytest.mark.parametrize("machine", [load_platform("zu9eg"), overlapped(load_platform("xc7z020"))])
def test_every_segment_reaches_the_trace_viewer(machine: Platform) -> None:
    timeline = simulate(TRACE, machine, "paper")
    document = json.loads(json.dumps(trace_events(timeline, machine), allow_nan=False))
    names = {
        (e["pid"], e["tid"]): e["args"]["name"] for e in document["traceEvents"] if e["name"] == "thread_name"
    }
    events = [event for event in document["traceEvents"] if event["ph"] == "X"]
    assert {(event["pid"], event["tid"]) for event in events} <= names.keys()
    on_causes = [event for event in events if names[event["pid"], event["tid"]].startswith("cycles: ")]
    others = [event for event in events if event not in on_causes]
    assert len(others) == len(timeline.segments)
    assert len(on_causes) == sum(segment.side == "pl" for segment in timeline.segments)
    ends = max(event["ts"] + event["dur"] for event in events)
    assert ends == pytest.approx(timeline.makespan_picos / 1e6) == document["otherData"]["makespan_us"]
    assert {names[event["pid"], event["tid"]] for event in others} >= {"core 0", "factorization", "interrupt"}
    echo = document["otherData"]["parameters"]
    assert echo.keys() == {row.key for row in machine.assumptions()}
    assert all(row["tag"] in ("sourced", "measured", "assumed") for row in echo.values())
    by_track: dict[tuple[int, int], float] = {}
    for event in events:  # events of one track do not overlap
        key = (event["pid"], event["tid"])
        assert event["ts"] >= by_track.get(key, 0.0) - 1e-9
        by_track[key] = event["ts"] + event["dur"]


def test_figures_are_drawn(tmp_path: Path) -> None:
    gantt_figure(simulate(TRACE, A.platform, A.partition), tmp_path / "a.png")
    figure = difference_figure(explain(TRACE, *PAIRS[1]), tmp_path / "b.png")
    bars = [patch.get_height() for patch in figure.axes[0].patches]
    found = explain(TRACE, *PAIRS[1])
    assert (bars[0], bars[-1]) == (found.a_picos / 1e9, found.b_picos / 1e9)
    area_figure(budget(parse_trace(TRACE), A.platform, A.partition), "title", tmp_path / "c.png")
    for name in "abc":
        assert (tmp_path / f"{name}.png").read_bytes().startswith(PNG)
