"""What is said of an insertion that was flown: where it ended, and whether that orbit lasts."""

from __future__ import annotations

from collections.abc import Sequence

from orbsoc.guidance.closed_loop import ON_TARGET, FlownCycles
from orbsoc.guidance.verdict import Question, VerdictLine, Word

from ..scenario import Scenario


def verdict_lines(scenario: Scenario, flown: FlownCycles) -> Sequence[VerdictLine]:
    """Answer and Safety."""
    end, cycle = flown.outcome, scenario.flight
    orbit = f"{end['perigee_km']:.1f} × {end['apogee_km']:.1f} km"
    off = f"apsides off {end['perigee_off_km']:+.2f} and {end['apogee_off_km']:+.2f} km, plane {end['plane_off_deg']:.4f}°"
    figure = f"flown to {orbit}, cut off at {end['cutoff_s']:.2f} s; {off}"
    limit = f"{cycle.apsis_km:g} km, {cycle.plane_deg:g}°"
    word = Word.MET if end[ON_TARGET] else Word.MISSED
    answer = VerdictLine(Question.ANSWER, word, figure, limit)
    safe = Word.SAFE if end["safe"] else Word.NOT_SAFE
    height = f"perigee {end['perigee_km']:.1f} km, at least {cycle.safe_perigee_km:g} km lasts a revolution"
    return answer, VerdictLine(Question.SAFETY, safe, height)
