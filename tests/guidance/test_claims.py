"""No verdict says fewest, optimum, infeasible or proved without a claim that says of what and by what check."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import pytest

from orbsoc.guidance.claims import Claim, Kind, refused_words
from orbsoc.guidance.scenario_file import read_toml
from orbsoc.guidance.verdict import Question, Verdict, VerdictLine, Word
from orbsoc.missions.registry import MISSIONS

SCENARIOS = Path(__file__).resolve().parents[2] / "scenarios"
CLAIMING = ("approach", "fly_around", "passive_safety", "phasing", "reachable_insertion")
"""Missions whose verdicts carry claims."""
SHIPPED = sorted(
    path for path in SCENARIOS.glob("*.toml") if read_toml(path).get("mission") in CLAIMING
)  # fmt: skip


@cache
def verdict(path: Path) -> Verdict:
    mission = MISSIONS[read_toml(path)["mission"]]
    return mission.plan(mission.load_scenario(path)).verdict


def unfounded(found: Verdict) -> list[str]:
    """Lines that say a refused word and carry no claim."""
    return [str(line) for line in found.lines if line.claim is None and refused_words(str(line))]


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_a_shipped_scenario_says_no_refused_word_without_a_claim(path: Path) -> None:
    found = verdict(path)
    assert unfounded(found) == []
    for line in found.lines:
        if line.claim is not None:
            assert line.claim.class_
            assert line.claim.evidence
            assert line.to_dict()["claim"]["kind"] == line.claim.kind.value


def test_a_line_without_a_claim_is_caught() -> None:
    bare = VerdictLine(Question.ANSWER, Word.INFEASIBLE, "5 pulses, the fewest, for all time")
    assert refused_words(str(bare)) == ("fewest", "infeasible", "all time")
    assert unfounded(Verdict((bare,))) == [str(bare)]
    assert refused_words("infeasibly unproved") == ()


def test_a_claim_makes_its_line() -> None:
    claim = Claim(Kind.BEST_FOUND, "the best of 48 times", "times of a grid", "48 conic problems", 0.01)
    line = VerdictLine.of_claim(Question.OPTIMUM, claim)
    assert (line.word, line.figure) == (Word.BEST_FOUND, claim.claim)
    assert line.to_dict()["claim"] == {
        "kind": "best found",
        "claim": "the best of 48 times",
        "class": "times of a grid",
        "evidence": "48 conic problems",
        "gap": 0.01,
    }
