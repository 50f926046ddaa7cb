"""Quantiles of drawn parameters lie within the corners, and follow the bands."""

from __future__ import annotations

import random

from hw_model.platform.partition import load_partition
from hw_model.platform.platform import load_platform
from hw_model.report.quantiles import drawn, speedup_quantiles
from hw_model.report.speedup import speedup
from hw_model.timing.trace import parse_trace
from tests.hw_model.synthetic import synthetic_trace


def test_a_draw_lies_in_every_band_and_moves_nothing_else() -> None:
    platform = load_platform("zu9eg")
    computer = drawn(platform, random.Random(3))
    was = dict(platform.parameters())
    moved = 0
    for key, row in computer.parameters():
        if row.low is None or isinstance(row.value, int | str):
            assert row.value == was[key].value, key
        elif key.split(".")[0] in {"ps", "pl", "link", "runtime"}:
            assert row.low <= row.value <= row.high, key
            moved += row.value != was[key].value
    assert moved > 10


def test_quantiles_lie_within_the_corners_and_are_narrower() -> None:
    trace, platform, partition = (
        parse_trace(synthetic_trace(iterations=3, solves=1)),
        load_platform("zu9eg"),
        load_partition("paper"),
    )
    corners = speedup(trace, platform, partition).speedup
    found = speedup_quantiles(trace, platform, partition, draws=200)
    assert corners.low < found.low < found.nominal < found.high < corners.high
    assert found == speedup_quantiles(trace, platform, partition, draws=200)


def test_without_a_band_there_is_one_quantile_less_to_draw() -> None:
    trace, platform, partition = (
        parse_trace(synthetic_trace(iterations=3, solves=1)),
        load_platform("zu9eg"),
        load_partition("paper"),
    )
    fixed = platform.with_value("pl.clock_mhz", 211.0)
    wide, narrow = (speedup_quantiles(trace, each, partition, draws=200) for each in (platform, fixed))
    assert narrow.high / narrow.low < wide.high / wide.low
