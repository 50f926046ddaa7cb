"""What is said of an insertion that was flown: where it ended, why there, and whether that orbit lasts."""

from __future__ import annotations

from collections.abc import Sequence

from orbsoc.guidance.claims import Claim, Kind
from orbsoc.guidance.closed_loop import ON_TARGET, Decision, FlownCycles
from orbsoc.guidance.verdict import Question, VerdictLine, Word, shortened

from ..scenario import Scenario

OUT_OF_REACH, CHOSEN, NOT_FOUND = "OUT OF REACH", "CHOSEN", "NOT FOUND"
"""Words of decisions. Only the first is a proof."""
THE_TARGET = "the target"


def verdict_lines(scenario: Scenario, flown: FlownCycles) -> Sequence[VerdictLine]:
    """Answer and Safety."""
    end, cycle = flown.outcome, scenario.guidance
    orbit = f"{end['perigee_km']:.1f} × {end['apogee_km']:.1f} km"
    safe = Word.SAFE if end["safe"] else Word.NOT_SAFE
    height = f"perigee {end['perigee_km']:.1f} km, at least {cycle.safe_perigee_km:g} km lasts a revolution"
    safety = VerdictLine(Question.SAFETY, safe, height)
    off = f"apsides off {end['perigee_off_km']:+.2f} and {end['apogee_off_km']:+.2f} km, plane {end['plane_off_deg']:.4f}°"
    if not end[ON_TARGET] and (decisions := last_decisions(flown)):
        return _instead(decisions, orbit), safety
    figure = f"flown to {orbit}, cut off at {end['cutoff_s']:.2f} s; {off}"
    limit = f"{cycle.apsis_km:g} km, {cycle.plane_deg:g}°"
    word = Word.MET if end[ON_TARGET] else Word.MISSED
    return VerdictLine(Question.ANSWER, word, figure, limit), safety


def last_decisions(flown: FlownCycles) -> tuple[Decision, ...]:
    """Of the last answer that had to choose and was flown, or of the last that found nothing to fly."""
    made = [
        a.decisions for _, a, was_flown in flown.answers if a.decisions and (was_flown or a.programme is None)
    ]
    return made[-1] if made else ()


def _instead(decisions: Sequence[Decision], orbit: str) -> VerdictLine:
    """The target was given up, or was chosen and missed all the same."""
    first, last = decisions[0], decisions[-1]
    chosen = last if last.word == CHOSEN else None
    if chosen is not None and chosen.sought == THE_TARGET:
        return VerdictLine(Question.ANSWER, Word.MISSED, f"the target was planned to, and missed: {orbit}")
    word = Word.MISSED if chosen is None else Word.INSTEAD
    ended = f"left on {orbit}" if chosen is None else f"flown to {chosen.sought}, {orbit}"
    if first.word == OUT_OF_REACH:
        claim = Claim(
            Kind.PROVED,
            "the target is out of reach",
            "burns from the fault on, above the ground, about a point mass",
            first.found,
        )
        return VerdictLine(
            Question.ANSWER,
            word,
            f"{ended}; the target is out of reach, proved",
            evidence=shortened(first.found, 90),
            claim=claim,
        )
    why = "no burn to the target was found, without a proof that there is none"
    return VerdictLine(Question.ANSWER, word, f"{ended}; {why}")
