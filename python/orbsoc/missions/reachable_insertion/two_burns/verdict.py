"""The verdict of a plan of two burns as lines."""

from __future__ import annotations

from orbsoc.guidance.mission import PlanStatus
from orbsoc.guidance.verdict import Question, Verdict, VerdictLine, Word

from ..plan.verdict import fitted, flown_within, infeasible_line, not_verified_line, short_shape
from .transfer_plan import TransferPlan
from .verdicts import starts_tried, violations


def verdict_of(plan: TransferPlan) -> Verdict:
    """*Answer*, what one burn would do where it is enough, and *Optimum*."""
    return Verdict.of([_answer(plan), *(_found(plan) if plan.status is PlanStatus.VERIFIED else ())])


def _answer(plan: TransferPlan) -> VerdictLine:
    found, status = plan.verification, plan.status
    if status is PlanStatus.VERIFIED and found is not None:
        first, second = plan.burns
        figure = (
            f"burns {first.duration_s:.3f} + {second.duration_s:.3f} s → {short_shape(found.planned_orbit)}"
        )
        return fitted(Question.ANSWER, Word.VERIFIED, figure, flown_within(plan.scenario, found))
    if status is PlanStatus.NOT_VERIFIED and found is not None:
        return not_verified_line(plan.scenario, found)
    if status is PlanStatus.INFEASIBLE and plan.proof is not None:
        return infeasible_line(plan.proof)
    if status is PlanStatus.NOT_FOUND and plan.best is not None:
        left = violations(plan)
        worst = (
            f"the closest leaves {left[0].words}"
            if left
            else f"the shortest take {plan.time_of_flight_s:.1f} s"
        )
        return fitted(Question.ANSWER, Word.NOT_FOUND, f"{len(starts_tried(plan))} starts; {worst}")
    return fitted(Question.ANSWER, Word[status.name], plan.message)


def _found(plan: TransferPlan) -> tuple[VerdictLine, ...]:
    figure = f"a local optimum, {plan.delta_v_m_s:.1f} m/s; the best of {len(starts_tried(plan))} starts"
    optimum = fitted(Question.OPTIMUM, Word.BEST_FOUND, figure)
    if not plan.one_is_enough:
        return (optimum,)
    one = {"burn.count": "1", "burn.ignition": "free"}
    return (VerdictLine(Question.OPTION, Word.POSSIBLE, "one burn is enough", settings=one), optimum)
