"""What `orbsoc plan` prints of shipped scenarios of each quick mission: few short lines, and the exit code they mean."""

from __future__ import annotations

from pathlib import Path

import pytest
from typer.testing import CliRunner

from orbsoc.commands.app import app
from orbsoc.guidance.verdict import WIDTH, Level, Question, Word

SCENARIOS = Path(__file__).parents[2] / "scenarios"
MOST_LINES = 8
QUICK = (
    "deorbit",
    "kick_stage_reach",
    "paper000_1",
    "paper000_1_printed",
    "paper001_equal",
    "paper003_socp",
    "rec1",
    "rec2",
)
"""Scenarios that are planned within a few seconds."""


def words(output: str) -> list[Word]:
    """The word of each printed line that answers a question; the longest that fits, as words may begin alike."""
    longest_first = sorted(Word, key=lambda word: -len(word.text))
    return [
        next(word for word in longest_first if line[9:].startswith(word.text)) for line in answers(output)
    ]


def answers(output: str) -> list[str]:
    """The printed lines that begin with a question's name."""
    names = {question.value for question in Question}
    return [line for line in output.splitlines() if line[:9].rstrip() in names]


@pytest.mark.parametrize("name", QUICK)
def test_printed_verdict_is_short_and_its_worst_word_is_the_exit_code(name: str, tmp_path: Path) -> None:
    scenario = str(SCENARIOS / f"{name}.toml")
    options = ["--no-report", "--device", "zu9eg", "--out", str(tmp_path / "out")]
    result = CliRunner().invoke(app, ["plan", scenario, *options])
    lines = answers(result.output)
    assert lines[0].startswith("Answer"), result.output
    assert len(lines) <= MOST_LINES
    assert max(map(len, lines)) <= WIDTH
    worst = max(word.level for word in words(result.output))
    assert result.exit_code == (1 if worst is Level.BAD else 0), result.output
