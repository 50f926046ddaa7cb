"""The lines of a verdict: one word a question, no line too long, and the command beside each option."""

from __future__ import annotations

from pathlib import Path

import pytest

from orbsoc.guidance.verdict import WIDTH, Question, Word
from orbsoc.missions.reachable_insertion import load_scenario, plan

SCENARIOS = Path(__file__).resolve().parents[3] / "scenarios"


@pytest.mark.parametrize("name", ["rec1", "deorbit", "escape", "raise_two_burns", "paper004_insertion"])
def test_a_verified_plan_answers_in_at_most_three_lines_that_fit(name: str) -> None:
    found = plan(load_scenario(SCENARIOS / f"{name}.toml", {"problem": "min_time"})).verdict
    assert found.word(Question.ANSWER) is Word.VERIFIED
    assert found.word(Question.OPTIMUM) is Word.BEST_FOUND
    assert found.succeeded
    assert len(found.lines) <= 3
    assert max(map(len, str(found).splitlines())) <= WIDTH
    assert "flown to" in found.lines[0].evidence


def test_a_cheaper_ignition_is_the_second_line_with_its_command() -> None:
    lines = plan(load_scenario(SCENARIOS / "deorbit.toml")).verdict.lines
    assert lines[1].word is Word.CHEAPER
    assert str(lines[1]).endswith("\n         --set burn.ignition=free")


def test_an_orbit_that_was_not_found_fails_in_one_word() -> None:
    found = plan(load_scenario(SCENARIOS / "paper004_insertion.toml", {"problem": "max_energy"})).verdict
    assert [line.word for line in found.lines] == [Word.NOT_FOUND]
    assert not found.succeeded
