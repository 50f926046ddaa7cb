"""Differences add up."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from hw_model.area.budget import budget
from hw_model.figures.area import area_figure
from hw_model.figures.difference import difference_figure
from hw_model.figures.gantt import gantt_figure
from hw_model.platform.partition import load_partition
from hw_model.platform.platform import Platform, load_platform
from hw_model.report.explain import Configuration, explain
from hw_model.report.run import simulate
from hw_model.timing.trace import parse_trace
from tests.hw_model.synthetic import synthetic_trace
from tests.hw_model.timing.test_precedence import overlapped

TRACE = synthetic_trace(iterations=3, solves=2)
PNG = b"\x89PNG\r\n\x1a\n"


def configuration(platform: Platform, partition: str) -> Configuration:
    return Configuration(f"{platform.name}:{partition}", platform, load_partition(partition))


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
        assert sum(pair[0] for pair in level.values()) == found.a_picoseconds
        assert sum(pair[1] for pair in level.values()) == found.b_picoseconds
    assert found.a_picoseconds == simulate(TRACE, a.platform, a.partition).makespan_picoseconds
    assert found.headline.startswith("modelled: ")
    plain = found.to_dict()
    assert json.loads(json.dumps(plain, allow_nan=False)) == plain
    total = sum(row["difference"] for row in plain["by_cause_ms"].values())
    assert total == pytest.approx((found.b_picoseconds - found.a_picoseconds) / 1e9, abs=1e-9)


def test_a_difference_names_what_was_changed() -> None:
    found = explain(TRACE, *PAIRS[1])
    assert found.parameters == (("pl.lanes", 4, 8),)
    assert set(found.moved) == {"matrix_update", "matrix_scaling", "cone_ops", "line_search"}
    assert explain(TRACE, *PAIRS[0]).headline.endswith("ms; PL cycles are estimated, not scheduled")
    assert "take the same time" in explain(TRACE, *PAIRS[0]).headline


def test_a_difference_names_no_parameter_that_neither_run_reads() -> None:
    """Units of the other family differ in both widths, and this run computes in one."""
    found = explain(
        TRACE, A, configuration(load_platform("zu9eg").with_value("pl.latency_preset", "vendor_ip"), "paper")
    )
    keys = {key for key, _, _ in found.parameters}
    assert "pl.latencies.f64.add_cycles" in keys
    assert not [key for key in keys if ".f32." in key]


def test_figures_are_drawn(tmp_path: Path) -> None:
    gantt_figure(simulate(TRACE, A.platform, A.partition), tmp_path / "a.png")
    figure = difference_figure(explain(TRACE, *PAIRS[1]), tmp_path / "b.png")
    bars = [patch.get_height() for patch in figure.axes[0].patches]
    found = explain(TRACE, *PAIRS[1])
    assert (bars[0], bars[-1]) == (found.a_picoseconds / 1e9, found.b_picoseconds / 1e9)
    area_figure(budget(parse_trace(TRACE), A.platform, A.partition), "title", tmp_path / "c.png")
    for name in "abc":
        assert (tmp_path / f"{name}.png").read_bytes().startswith(PNG)
