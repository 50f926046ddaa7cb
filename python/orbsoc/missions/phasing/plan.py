"""A plan as `guidance.mission.Plan` has it, its verdict, and the functions by which the mission makes one."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from math import isfinite
from pathlib import Path
from typing import Any

from orbsoc.guidance.claims import Claim, Kind
from orbsoc.guidance.impulses import ImpulseProgramme
from orbsoc.guidance.mission import Difference, FigureFile, PlanStatus
from orbsoc.guidance.scp import Iteration, Solve
from orbsoc.guidance.verdict import Question, Verdict, VerdictLine, Word, shortened

from .figures import draw_figures
from .planner import FAR_M, PhasingPlan, judged, made
from .record.document import plan_document
from .record.messages import messages
from .scenario import Scenario
from .search.descent import PROVED
from .verification.flight import LIMIT_M

WORTH_WAITING = 0.95
"""Of the plan's cost: another number of revolutions that costs more than that is not told."""


@dataclass(frozen=True, slots=True, eq=False)
class Plan(PhasingPlan):
    """A long approach with its verdict and files."""

    @property
    def verdict(self) -> Verdict:
        """Answer, a cheaper number of revolutions, what is known of the optimum, the engine, and draws with errors."""
        return Verdict.of([_answer(self), _option(self), _optimum(self), _engine(self), _flights(self)])

    def to_dict(self) -> dict[str, Any]:
        return plan_document(self)

    def tables(self) -> Mapping[str, str]:
        if self.programme is None or self.verification is None:
            return {}
        return {
            "impulses.csv": self.programme.to_csv(),
            **messages(self.scenario, self.programme, self.verification),
        }

    def figures(self, folder: Path) -> tuple[FigureFile, ...]:
        return draw_figures(self, folder)

    def differences(self, other: Plan) -> tuple[Difference, ...]:
        """Costs: instants beside each other may share an impulse in more than one way."""
        if self.programme is None or other.programme is None:
            return ()
        apart = abs(self.programme.total_m_s - other.programme.total_m_s)
        return (Difference("cost_m_s", "cost", apart, 1e-3, "m/s"),)


def plan(
    scenario: Scenario, *, solve: Solve | None = None, callback: Callable[[Iteration], None] | None = None
) -> Plan:
    """Plan the approach of `scenario` with `solve`, `orbsoc.solve` by default; `callback` sees every solved problem.

    What does not converge is a status with its reason. Raises `orbsoc.guidance.scenario_file.ScenarioError` where no orbit
    within the limits meets the target, or where the burns of the paper's scheme cannot.
    """
    return _with_files(made(scenario, solve, callback))


def audit(scenario: Scenario, programme: ImpulseProgramme) -> Plan:
    """A programme made elsewhere, flown to the scenario's meeting; nothing is solved.

    Raises ScenarioError for an impulse outside the scenario's time.
    """
    return _with_files(judged(scenario, programme))


def _with_files(found: PhasingPlan) -> Plan:
    return Plan(**{field.name: getattr(found, field.name) for field in fields(PhasingPlan)})


def _answer(plan: Plan) -> VerdictLine:
    """The impulses as DOP853 flies them, or what does not hold."""
    flight, programme, word = plan.verification, plan.programme, Word[plan.status.name]
    if flight is None or programme is None:
        return VerdictLine(Question.ANSWER, word, shortened(plan.message), claim=plan.forbidden)
    spent = programme.words
    if plan.status is PlanStatus.VERIFIED:
        hours = f" over {plan.hours:.2f} h" if plan.phasing else ""
        figure = f"{spent}{hours}; flown {flight.miss_m:.2f} m off"
        return VerdictLine(Question.ANSWER, word, figure, f"{LIMIT_M:g} m")
    if flight.failures:
        more = f"{len(flight.failures) - 1} more" if len(flight.failures) > 1 else ""
        return VerdictLine(Question.ANSWER, word, shortened(f"it breaks {flight.failures[0]}"), evidence=more)
    analysis = plan.analysis
    if analysis is not None and analysis.too_weak:
        figure = f"{spent} fly as impulses ({flight.miss_m:.2f} m off), not as burns"
    elif analysis is not None and analysis.missed:
        figure = f"without errors it flies ({spent}), with them not as sure as asked"
    else:
        figure = plan.message
    return VerdictLine(Question.ANSWER, word, shortened(figure))


def _option(plan: Plan) -> VerdictLine | None:
    """The cheapest of the other numbers of revolutions, where their times and impulses are not given."""
    window, programme = plan.scenario.window, plan.programme
    given = plan.scenario.scheme == "paper" or window.end_s is not None or window.phasing_s is not None
    if plan.analysis is None or programme is None or given:
        return None
    known = [each for each in plan.analysis.front if each.least_m_s is not None]
    best = min(known, key=lambda each: each.least_m_s or 0.0, default=None)
    if best is None or best.least_m_s is None or not best.least_m_s < WORTH_WAITING * programme.total_m_s:
        return None
    less = f"{best.least_m_s:.1f} m/s (−{100.0 * (1.0 - best.least_m_s / programme.total_m_s):.0f} %)"
    figure = f"{less} in {best.duration_h:.1f} h"
    other = {"window.revolutions": str(best.revolutions)}
    return VerdictLine(Question.OPTION, Word.CHEAPER, figure, settings=other)


def _optimum(plan: Plan) -> VerdictLine | None:
    """The dual bound is of the motion to first order about the plan, at its instants; None where nothing was solved."""
    last = plan.bounded
    if last is None or plan.descended is None:
        return None
    instants = len(plan.descended.approach.times_s)
    claim = Claim(
        Kind.BOUND if last.gap <= PROVED else Kind.BEST_FOUND,
        f"at its {instants} instants, in the motion about it, at least {last.lower_bound:.4f} m/s",
        f"impulses at these {instants} instants near the plan, in the motion to first order about it",
        "the dual objective of the last conic problem, divided by its largest primer at the instants",
        last.gap,
    )
    open_ = "" if claim.kind is Kind.BOUND else f"gap {last.gap:.0e}"
    return VerdictLine.of_claim(Question.OPTIMUM, claim, evidence=open_)


def _engine(plan: Plan) -> VerdictLine | None:
    """Whether burns of the scenario's engine can stand for the impulses."""
    if plan.scenario.engine is None or plan.verification is None:
        return None
    if plan.analysis is None:
        return VerdictLine(Question.ENGINE, Word.NOT_JUDGED, "impulses from elsewhere are not flown as burns")
    found, limit = plan.analysis.finite, f"{FAR_M / 1e3:g} km"
    if found is None:
        return VerdictLine(Question.ENGINE, Word.TOO_WEAK, "burns too long to stand for these impulses")
    if found.miss_m <= FAR_M:
        figure = f"burns of {found.dv_m_s:.2f} m/s, corrected twice, miss by {found.miss_m:.0f} m"
        return VerdictLine(Question.ENGINE, Word.ENOUGH, figure, limit)
    if not plan.analysis.too_weak:
        figure = f"corrections of its burns diverge ({found.miss_m / 1e3:.0f} km off); they need shooting"
        return VerdictLine(Question.ENGINE, Word.NOT_JUDGED, figure)
    figure = f"burns of {found.dv_m_s:.2f} m/s, corrected twice, miss by {found.miss_m / 1e3:.1f} km"
    return VerdictLine(Question.ENGINE, Word.TOO_WEAK, figure, limit)


def _flights(plan: Plan) -> VerdictLine | None:
    """Of the draws with errors, how many come within the distance, against the probability that was asked for."""
    errors, analysis = plan.scenario.uncertainty, plan.analysis
    if (
        errors is None
        or analysis is None
        or analysis.meeting is None
        or not isfinite(analysis.meeting.within)
    ):
        return None
    figure = f"{100.0 * analysis.meeting.within:.2f} % of {errors.runs} draws come within {errors.distance_km:g} km"
    if errors.probability is None:
        return VerdictLine(Question.FLIGHTS, Word.SAMPLED, figure)
    word = Word.MISSED if analysis.missed else Word.MET
    return VerdictLine(Question.FLIGHTS, word, figure, evidence=f"{100.0 * errors.probability:g} % asked for")
