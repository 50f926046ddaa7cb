"""The verdict over many points: short lines, and the word of the answer is the plan's status."""

from __future__ import annotations

import numpy as np
import pytest

from orbsoc.guidance.verdict import Question, Word
from orbsoc.missions.reachable_domain import load_scenario, plan
from tests.missions.reachable_domain.cases import SCENARIOS, paper
from tests.missions.verdict_rules import assert_rules


@pytest.mark.parametrize("name", ["paper004_reach", "kick_stage_reach"])
def test_the_shipped_scenarios_are_verified_in_few_short_lines(name: str) -> None:
    found = plan(load_scenario(SCENARIOS / f"{name}.toml"))
    assert_rules(found.verdict, found.status)
    assert [line.word for line in found.verdict.lines] == [Word.VERIFIED, Word.BEST_FOUND]
    assert f"a {found.point['a_km']:.3f} km at i " in found.verdict.lines[0].figure


def test_a_plane_that_is_not_reached_says_by_how_much() -> None:
    found = plan(paper(), point=(28.3, 351.3, 100.0)).verdict
    assert [line.word for line in found.lines] == [Word.NOT_FOUND]
    assert found.lines[0].figure.endswith("the plane is 0.401° too far")


def test_random_points_are_answered_in_short_lines() -> None:
    random = np.random.default_rng(1)
    words: set[Word | None] = set()
    for _ in range(24):
        point = (
            float(random.uniform(12.0, 43.0)),
            float(random.uniform(315.0, 353.0)),
            float(random.uniform(90.0, 1500.0)),
        )
        found = plan(paper(), point=point)
        assert_rules(found.verdict, found.status)
        words.add(found.verdict.word(Question.ANSWER))
    assert words >= {Word.VERIFIED, Word.NOT_FOUND}
