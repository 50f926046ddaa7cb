"""The verdict of a plan of two burns as lines."""

from __future__ import annotations

from orbsoc.guidance.mission import PlanStatus
from orbsoc.guidance.verdict import Question, Verdict, VerdictLine, Word

from ..record.words import answer_line, fitted
from ..verification import short_shape
from .transfer_plan import TransferPlan
from .verdicts import starts_tried, violations


def verdict_of(plan: TransferPlan) -> Verdict:
    """*Answer*, what one burn would do where it is enough, and *Optimum*."""
    return Verdict.of([_answer(plan), *(_found(plan) if plan.status is PlanStatus.VERIFIED else ())])


def _answer(plan: TransferPlan) -> VerdictLine:
    verified = closest = ""
    if plan.verification is not None:
        first, second = plan.burns
        shape = short_shape(plan.verification.planned_orbit)
        verified = f"burns {first.duration_s:.3f} + {second.duration_s:.3f} s → {shape}"
    elif plan.best is not None:
        left = violations(plan)
        worst = f"closest leaves {left[0].words}" if left else f"shortest take {plan.time_of_flight_s:.1f} s"
        closest = f"{len(starts_tried(plan))} starts; the {worst}"
    return answer_line(plan, verified, closest)


def _found(plan: TransferPlan) -> tuple[VerdictLine, ...]:
    figure = f"a local optimum, {plan.delta_v_m_s:.1f} m/s; the best of {len(starts_tried(plan))} starts"
    optimum = fitted(Question.OPTIMUM, Word.BEST_FOUND, figure)
    if not plan.one_is_enough:
        return (optimum,)
    one = {"burn.count": "1", "burn.ignition": "free"}
    return (VerdictLine(Question.OPTION, Word.POSSIBLE, "one burn is enough", settings=one), optimum)
