"""What holds of every mission's verdict."""

from __future__ import annotations

from orbsoc.guidance.mission import PlanStatus
from orbsoc.guidance.verdict import WIDTH, Question, Verdict

MOST_LINES = 5
"""Of a mission: with check, deadline and computer there are eight."""


def assert_rules(verdict: Verdict, status: PlanStatus) -> None:
    """Few short lines, an answer first; a verified plan has no bad word, any other plan has one."""
    assert len(verdict.lines) <= MOST_LINES
    assert max(map(len, str(verdict).splitlines())) <= WIDTH, str(verdict)
    assert verdict.lines[0].question is Question.ANSWER
    assert verdict.lines[0].word.name == status.name
    assert verdict.succeeded == (status is PlanStatus.VERIFIED), str(verdict)
