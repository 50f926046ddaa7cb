"""The lines *Deadline* and *Computer* of a verdict: what the conic solves of a plan take on the modelled computer."""

from __future__ import annotations

from hw_model.report.bands import Band
from orbsoc.guidance.verdict import Question, VerdictLine, Word

from .cycle_budget import CycleBudget


def hardware_lines(found: CycleBudget) -> tuple[VerdictLine, ...]:
    """Deadline where one was given, and Computer."""
    return (*_deadline(found), _computer(found))


def unpriced(device: str, reason: str) -> VerdictLine:
    """Computer, of solves that the engine of the device does not hold."""
    return VerdictLine(Question.COMPUTER, Word.DOES_NOT_FIT, f"{device} is not priced", evidence=reason)


def nothing_solved() -> VerdictLine:
    """Computer, of a plan without a conic problem: an answer in closed form, or impulses that were given."""
    return VerdictLine(Question.COMPUTER, Word.NOT_NEEDED, "no conic problem was solved: nothing to time")


def _deadline(found: CycleBudget) -> tuple[VerdictLine, ...]:
    if found.deadline_ms is None:
        return ()
    judged, limit = found.report.deadline, f"{found.deadline_ms:g} ms"
    if judged is None:
        figure = "no verified plan whose time could be held against it"
        return (VerdictLine(Question.DEADLINE, Word.NOT_JUDGED, figure, limit),)
    nominal, worst = (
        judged.deadline_ms - margin for margin in (judged.margin_ms, judged.worst_case_margin_ms)
    )
    figure = f"worst {worst:.3g}, nominal {nominal:.3g} of {judged.deadline_ms:g} ms"
    evidence = "" if found.area.fits else "the engine does not fit"
    return (VerdictLine(Question.DEADLINE, Word[judged.verdict], figure, evidence=evidence),)


def _computer(found: CycleBudget) -> VerdictLine:
    report = found.report
    times = _band(report.makespan_ms)
    figure = f"{report.device}, partition {report.partition}: {times}"
    if report.modules_on_pl:
        figure += f", core alone {_band(report.baseline_ms)}"
    if not found.same_bits:
        return VerdictLine(Question.COMPUTER, Word.OTHER_BITS, figure)
    word = Word.MODELLED if found.area.fits else Word.DOES_NOT_FIT
    return VerdictLine(Question.COMPUTER, word, figure)


def _band(times: Band) -> str:
    per, unit = (1e3, "s") if times.nominal >= 1e3 else (1.0, "ms") if times.nominal >= 0.1 else (1e-3, "µs")
    return f"{times.nominal / per:.3g} {unit} ({times.low / per:.3g}–{times.high / per:.3g})"
