"""The verdict as lines: order, worst word, text and data say the same."""

from __future__ import annotations

import pytest

from orbsoc.guidance.mission import Agreement, Difference, PlanStatus
from orbsoc.guidance.verdict import Level, Question, Verdict, VerdictLine, Word

ANSWER = VerdictLine(Question.ANSWER, Word.VERIFIED, "burn 56.570 s", "1e-8", "flight within 7e-12")


def line(word: Word, question: Question = Question.DEADLINE) -> VerdictLine:
    return VerdictLine(question, word, "36.1 of 50 ms")


def test_lines_stand_in_the_order_of_the_questions_and_missing_ones_are_left_out() -> None:
    found = Verdict.of([line(Word.MODELLED, Question.COMPUTER), None, line(Word.PASS), ANSWER])
    assert [each.question for each in found.lines] == [Question.ANSWER, Question.DEADLINE, Question.COMPUTER]


@pytest.mark.parametrize("word", Word)
def test_the_worst_word_rules(word: Word) -> None:
    found = Verdict((ANSWER,)).with_lines([line(word)])
    assert found.level is max(Level.GOOD, word.level)
    assert found.succeeded is (word.level is not Level.BAD)


def test_a_printed_line_is_question_word_figure_limit_and_evidence() -> None:
    assert str(ANSWER) == "Answer   VERIFIED     burn 56.570 s (allowed 1e-8); flight within 7e-12"
    assert str(line(Word.PASS)) == "Deadline PASS         36.1 of 50 ms"


def test_data_and_page_hold_what_is_printed() -> None:
    found = Verdict((ANSWER, VerdictLine(Question.SAFETY, Word.NOT_SAFE, "39 m < 40 m")))
    for row, each in zip(found.to_list(), found.lines, strict=True):
        assert all(part in str(each) for key, part in row.items() if key != "claim")
    assert "39 m &lt; 40 m" in found._repr_html_()


def test_every_status_of_a_plan_has_its_word() -> None:
    assert all(Word[status.name] for status in PlanStatus)
    assert Word[PlanStatus.VERIFIED.name].level is Level.GOOD
    assert {Word[status.name].level for status in PlanStatus if status is not PlanStatus.VERIFIED} == {
        Level.BAD
    }


@pytest.mark.parametrize(("pulses", "word"), [(0.0, Word.AGREES), (1.0, Word.DISAGREES)])
def test_a_count_that_may_not_differ_is_compared(pulses: float, word: Word) -> None:
    """A limit of zero was divided by; the line names what is farthest beyond its limit."""
    found = Agreement(
        "verified", "verified",
        (Difference("pulses", "number of pulses", pulses, 0.0), Difference("delta_v_m_s", "velocity change", 1e-6, 1e-4, "m/s")),
    ).line("clarabel")  # fmt: skip
    assert found.word is word
    assert ("number of pulses" if pulses else "velocity change") in str(found)
