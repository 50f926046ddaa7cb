"""The lines that a flight adds to its mission's: whether each answer came in time, and on what computer."""

from __future__ import annotations

from collections.abc import Iterable

from orbsoc.guidance.closed_loop import ClosedLoop
from orbsoc.guidance.verdict import Question, Verdict, VerdictLine, Word

from .computer import Computer, scope
from .loop import CycleRecord, Fate, Flight, Timing
from .slower import Enough


def verdict_of(
    loop: ClosedLoop, flight: Flight, computer: Computer, timing: Timing, enough: Enough
) -> Verdict:
    """All lines of one flight."""
    return Verdict.of([
        *loop.verdict(flight),
        _deadline(flight.cycles, timing, loop.period_s, enough),
        _computer(flight.cycles, computer),
    ])  # fmt: skip


def _deadline(
    cycles: Iterable[CycleRecord], timing: Timing, period_s: float, enough: Enough
) -> VerdictLine | None:
    """Which trigger was missed first, and how fast a computer is that misses none."""
    computed = [each for each in cycles if each.solves]
    if not computed:
        return None
    lost = [each for each in cycles if each.fate.is_lost]
    worst = max(computed, key=lambda each: each.price.time_s)
    window_s = timing.window_of(worst.trigger, period_s)
    allowed = "" if window_s == float("inf") else f" of {1e3 * window_s:.6g} ms"
    if not lost:
        figure = f"{len(computed)} re-plans, the longest {worst.price.time_ms:.3g}{allowed or ' ms'}"
        return VerdictLine(Question.DEADLINE, Word.PASS, figure, evidence=enough.words)
    first = lost[0]
    took = first.fate.value
    if first.fate is Fate.MISSED:
        limit_ms = 1e3 * timing.window_of(first.trigger, period_s)
        took = f"took {first.price.time_ms:.3g} of {limit_ms:.6g} ms"
    figure = (
        f"re-plan {first.trigger.number} at {first.trigger.at_s:.1f} s {took}; {len(lost)} of {len(list(cycles))} lost,"
        " the last plan flew on"
    )
    return VerdictLine(Question.DEADLINE, Word.FAIL, figure, evidence=enough.words)


def _computer(cycles: Iterable[CycleRecord], computer: Computer) -> VerdictLine:
    computed = [each for each in cycles if each.solves]
    found = [each.price for each in computed]
    if not found:
        return VerdictLine(Question.COMPUTER, Word.NOT_NEEDED, "nothing was planned in flight")
    times, cycles_ = sorted(each.time_ms for each in found), max(each.pl_cycles for each in found)
    ends = [f"{each:.3g}" for each in (times[0], times[-1])]
    spanned = "–".join(dict.fromkeys(ends))
    figure = (
        f"{computer.name}: {spanned} ms a re-plan, at most {cycles_} PL cycles, exact;"
        f" {scope(sum(each.counted for each in computed), len(computed))}"
    )
    return VerdictLine(Question.COMPUTER, Word.MODELLED, figure)
