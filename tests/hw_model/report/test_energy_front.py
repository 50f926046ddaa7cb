"""The front of time and energy holds what nothing beats, and an entry moves it as pricing the runs again does."""

from __future__ import annotations

import pytest

from hw_model.platform.partition import all_partitions
from hw_model.platform.platform import load_platform
from hw_model.report.energy_front import energy_front, sensitivities, words
from hw_model.report.study import Point, Study
from hw_model.timing.trace import parse_trace
from tests.hw_model.synthetic import synthetic_trace

PLATFORM = load_platform("zu9eg")
STUDY = Study(parse_trace(synthetic_trace(iterations=3)))
POINTS = STUDY.points(PLATFORM, all_partitions())
ROWS = sensitivities(POINTS, PLATFORM)


def places(front: list[Point]) -> set[tuple[float, str]]:
    return {(point.times_ms[0], point.partition) for point in front}


def test_the_front_holds_what_nothing_beats() -> None:
    front = energy_front(POINTS)
    fitting = [(p.times_ms[0], p.energy.nominal_mj) for p in POINTS if p.budget.fits]
    unbeaten = {
        (time, energy)
        for time, energy in fitting
        if not any(t <= time and e <= energy and (t, e) != (time, energy) for t, e in fitting)
    }
    assert {(p.times_ms[0], p.energy.nominal_mj) for p in front} == unbeaten


@pytest.mark.parametrize("row", ROWS, ids=lambda row: f"{row.entry}={row.value:g}")
def test_an_entry_moves_the_front_as_pricing_all_runs_again_does(row: object) -> None:
    entry, value = row.entry, row.value  # type: ignore[attr-defined]
    dearer = STUDY.points(PLATFORM.with_value(f"energy.{entry}", value), all_partitions())
    was, now = places(energy_front(POINTS)), places(energy_front(dearer))
    assert (row.front, row.left, row.entered) == (len(now), len(was - now), len(now - was))  # type: ignore[attr-defined]


def test_shares_are_of_the_whole_and_the_sentence_names_what_moves_it() -> None:
    by_entry = {row.entry: row.fastest_share for row in ROWS}
    assert sum(by_entry.values()) == pytest.approx(1.0)
    moving = {row.entry for row in ROWS if row.left or row.entered}
    said = words("zu9eg", energy_front(POINTS), ROWS)
    assert all(entry in said for entry in moving)
    assert "time and energy" in said
