"""Tables and sentences of the guides of the missions state what the plans of `tests/site/stated` have."""

from __future__ import annotations

import pytest

from tests.site.stated import Stated, differing, numbers_at, places_of, read, text_of

PLANS = list(read())


@pytest.mark.parametrize("stated", PLANS, ids=str)
def test_a_page_has_the_lines_and_a_place_for_each_number(stated: Stated) -> None:
    text = text_of(stated.page)
    for line in stated.lines:
        assert len(numbers_at(line, text)) == len(places_of(line))


@pytest.mark.parametrize("stated", PLANS, ids=str)
def test_a_page_states_what_the_plan_has(stated: Stated) -> None:
    text, record = text_of(stated.page), stated.record()
    assert [each for line in stated.lines for each in differing(line, text, record)] == []


def test_a_number_that_is_not_the_plans_is_found() -> None:
    record = {"cost": 0.12345, "count": 13, "front": [{"pulses": 3, "m": -0.5}, {"pulses": 4, "m": 0.25}]}
    text = "| a | 0.1234 | 13 |\n0.500 and 250 of 0.75"
    assert differing("| a | {cost} | {count} |", text, record) == []
    lines = ["{front.pulses=3.m} and {front.pulses=4.m * 1000} of {max front.*.m}"]
    assert [each for line in lines for each in differing(line, text, record)] == [
        "front.*.m: 0.75 is stated, 0.25 planned"
    ]
    assert differing("| a | … | {count} |", text, {"count": 12}) == ["count: 13 is stated, 12 planned"]


def test_the_design_is_that_of_the_reproduction() -> None:
    """Finite burns are in no plan: `orbsoc reproduce 003` writes them into a page that a test holds."""
    written = text_of("reproduce-003.md")
    [stated] = numbers_at("| the paper's design, finite burns | {} |", text_of("phasing.md"))
    assert f"| {stated} m/s |" in written
