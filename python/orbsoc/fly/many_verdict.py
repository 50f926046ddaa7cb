"""The verdict on many flights: how many ended as asked, and whether the computer was in time."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from orbsoc.guidance.verdict import Question, Verdict, VerdictLine, Word

from .computer import scope
from .many import Study


def verdict_of_many(study: Study, document: Mapping[str, Any]) -> Verdict:
    """Flights, Safety where it is told, Deadline, Computer; MET only where every flight is."""
    runs, good = document["runs"], document["on_target"]
    word = Word.MET if good == runs else Word.MISSED
    figure = (
        f"{good} of {runs} flights on target, without re-planning {document['on_target_without_replanning']};"
        f" {document['replans']['total']} re-plans, at least {document['replans']['fewest']} each"
    )
    return Verdict.of([
        VerdictLine(Question.FLIGHTS, word, figure),
        _safety(document, runs),
        _deadline(study, document),
        _computer(study, document),
    ])  # fmt: skip


def _safety(document: Mapping[str, Any], runs: int) -> VerdictLine | None:
    safe = document["ends"].get("safe")
    if safe is None:
        return None
    count, without = (round(safe[side]["mean"] * runs) for side in ("with", "without"))
    figure = f"{count} of {runs} flights end safely, without re-planning {without}"
    return VerdictLine(Question.SAFETY, Word.SAFE if count == runs else Word.NOT_SAFE, figure)


def _deadline(study: Study, document: Mapping[str, Any]) -> VerdictLine | None:
    times, lost = document["computed_ms"], document["lost"]
    if not times:
        return None
    window = "the guidance period" if document["window_ms"] is None else f"{document['window_ms']:g} ms"
    figure = f"p50 {times['p50']:.3g}, p99 {times['p99']:.3g}, worst {times['worst']:.3g} ms; {lost} re-plan{'s' * (lost != 1)} lost"
    word = Word.PASS if lost == 0 else Word.FAIL
    return VerdictLine(Question.DEADLINE, word, figure, window)


def _computer(study: Study, document: Mapping[str, Any]) -> VerdictLine:
    slow = f", {study.slower:g} times as slow" if study.slower != 1.0 else ""
    words = scope(document["outer_loop_counted"], document["computed"])
    figure = f"{study.device}, partition {study.partition}{slow}: exact PL cycles; {words}"
    word = Word.MODELLED if document["computed_ms"] else Word.NOT_NEEDED
    return VerdictLine(Question.COMPUTER, word, figure)
