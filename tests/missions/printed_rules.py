"""What holds of every printed verdict."""

from __future__ import annotations

import re
from typing import Any

from orbsoc.guidance.claims import refused_words
from orbsoc.guidance.verdict import MOST_LINES, WIDTH, Level, Question, Word

LEVELS = {word.text: word.level for word in Word}
BEGINS = {"NO ANSWER": ("failed", "no answer"), "VERIFIED": ("verified",)}


def printed_lines(output: str) -> list[str]:
    """The printed verdict: from the line *Answer* to the last before *written to*."""
    lines = output.splitlines()
    first = next(k for k, line in enumerate(lines) if line.startswith("Answer "))
    return [line for line in lines[first:] if not line.startswith("written to")]


def assert_printed(output: str, document: dict[str, Any], exit_code: int) -> None:
    """Few short lines that end, in the words and figures of `plan.json`; the worst word is the exit code, no claim without
    what stands behind it, no flight without what it is held against, no option without its command."""
    lines = printed_lines(output)
    assert len(lines) <= MOST_LINES, output
    assert max(map(len, lines)) <= WIDTH, output
    assert "…" not in output, output
    rows = document["verdict"]
    assert [row["question"] for row in rows] == [line[:9].rstrip() for line in lines if line[0] != " "]
    assert rows[0]["question"] == Question.ANSWER.value
    assert rows[0]["word"] == Word[document["status"].upper()].text
    worst = max(LEVELS[row["word"]] for row in rows)
    assert exit_code == (1 if worst is Level.BAD else 0), output
    said = " ".join(" ".join(lines).split())
    for row in rows:
        assert row["figure"] in said, output
        assert bool(row["command"]) == (row["question"] == Question.OPTION.value)
        if row["command"]:  # whole, or where that is too long what is to be set
            shown = re.findall(r"--set (\S+)", said)
            assert shown
            assert set(shown) <= set(re.findall(r"--set (\S+)", row["command"])), output
        text = f"{row['figure']} {row['evidence']}"
        if re.search(r"\bflown\b.*\d", text):
            assert row["limit"] or "≤" in text, output
        if row["question"] != Question.OPTIMUM.value and refused_words(row["figure"]):
            assert row["claim"] or row["word"] in ("INFEASIBLE", "PROVED"), output
    assert_no_contradiction(document["details"], rows)


def assert_no_contradiction(details: str, rows: list[dict[str, Any]]) -> None:
    """The sentences do not say another word than the lines."""
    words = sorted((word.text for word in Word), key=lambda text: -len(text))
    answer = rows[0]["word"]
    first = next((text for text in words if details.startswith(text)), None)
    assert first in (None, answer), details
    if answer != Word.VERIFIED.text:
        assert not re.search(r"(?<!NOT )\bVERIFIED\b", details), details
    for row in rows:
        if row["question"] == Question.SAFETY.value and row["word"] == Word.NOT_SAFE.text:
            assert "safe for all time" not in details, details
