"""A plan as `guidance.mission.Plan` has it, its verdict, and the function by which the mission makes one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np

from orbsoc.guidance.mission import Difference, FigureFile, PlanStatus
from orbsoc.guidance.scp import Iteration, Solve
from orbsoc.guidance.verdict import Question, Verdict, VerdictLine, Word, shortened

from .planner import LaunchPlan, made
from .record import plan_document
from .scenario import Scenario
from .verification.audits import ORBITS
from .verification.checks import MISS_M
from .verification.flights import messages

WORTH_TURNING = 0.95
"""Of the plan's cost: a launch from elsewhere that costs more than that is not told."""
UNIT = {"squares": "m²/s²", "norms": "m/s"}


@dataclass(frozen=True, eq=False)
class Plan(LaunchPlan):
    """A launch and its rendezvous with their verdict and files."""

    @property
    def verdict(self) -> Verdict:
        """Answer, a cheaper place or attitude, what is known of the optimum, engine failures, and flights with errors."""
        return Verdict.of([_answer(self), _option(self), _optimum(self), _safety(self), _flights(self)])

    def to_dict(self) -> dict[str, Any]:
        return plan_document(self)

    def tables(self) -> dict[str, str]:
        if self.programme is None or self.verification is None:
            return {}
        met = self.verification.corrected
        return {
            "impulses.csv": self.programme.to_csv(),
            "impulses_two_body.csv": met.programme.to_csv(),
            **messages(self.scenario, met),
        }

    def figures(self, folder: Path) -> tuple[FigureFile, ...]:
        from .figures import draw_figures

        return draw_figures(self, folder)

    def differences(self, other: Plan) -> tuple[Difference, ...]:
        """The cost, its bound, and with two impulses, whose optimum is unique, the impulses."""
        ours, theirs = self.meeting, other.meeting
        if ours is None or theirs is None:
            return ()
        limit, bounds = 1e-5 * max(ours.value, 1e-3), abs(ours.lower_bound - theirs.lower_bound)
        found = [
            Difference("cost", "cost", abs(ours.value - theirs.value), limit),
            Difference("bound", "bound", bounds, limit),
        ]
        if ours.generated is None:
            apart = float(np.abs(ours.programme.dv_m_s - theirs.programme.dv_m_s).max())
            found.append(Difference("dv_m_s", "impulses", apart, 1e-5, "m/s"))
        return tuple(found)


def plan(
    scenario: Scenario, *, solve: Solve | None = None, callback: Callable[[Iteration], None] | None = None
) -> Plan:
    """Plan the launch and the rendezvous of `scenario`; `callback` sees every conic problem as it is solved.

    `solve` is any solver with the call shape of `orbsoc.solve`, which is the default. Raises PropagationError.
    """
    found = made(scenario, solve, callback)
    return Plan(**{field.name: getattr(found, field.name) for field in fields(LaunchPlan)})


def _answer(plan: Plan) -> VerdictLine:
    """The impulses and where they lead once corrected for two bodies, or what does not hold."""
    found, programme, word = plan.verification, plan.programme, Word[plan.status.name]
    if found is None or programme is None or plan.meeting is None:
        return VerdictLine(Question.ANSWER, word, shortened(plan.message))
    if plan.status is PlanStatus.VERIFIED:
        missed = f"misses {found.corrected.miss_m:.0e} m"
        figure = f"{programme.words} over {plan.meeting.time_s:.0f} s; {missed}"
        return VerdictLine(Question.ANSWER, word, figure, f"{MISS_M:g} m")
    more = f"{len(found.failures) - 1} more" if len(found.failures) > 1 else ""
    return VerdictLine(Question.ANSWER, word, shortened(found.failures[0]), evidence=more)


def _option(plan: Plan) -> VerdictLine | None:
    """The cheaper of the best yaw bias and the best phase, for two impulses in any time after the whole stroke."""
    scenario, met = plan.scenario, plan.meeting
    asked = scenario.rendezvous
    free = asked.duration_s == "free" and asked.impulses != "generated" and scenario.stop == "stroke"
    if met is None or not free:
        return None
    key, best = min(
        zip(("yaw_bias_deg", "phase_deg"), plan.scans, strict=True), key=lambda each: each[1].best_cost
    )
    if not best.best_cost < WORTH_TURNING * met.value:
        return None
    less = f"{best.best_cost:.4f} {UNIT[met.cost]} (−{100.0 * (1.0 - best.best_cost / met.value):.0f} %)"
    added = "whose squares add up to" if met.cost == "squares" else "of"
    figure = f"two impulses {added} {less}"
    return VerdictLine(Question.OPTION, Word.CHEAPER, figure, settings={key: f"{best.best_deg:.2f}"})


def _optimum(plan: Plan) -> VerdictLine | None:
    """By the planning's motion: the dual bound at the times of two impulses or, generated, at any; of all times the minima
    of a scan, which polynomials find, too, of a sum of squares."""
    met = plan.meeting
    if met is None:
        return None
    if met.generated is not None:
        figure = f"impulses at any times of the linear motion cost at least {met.lower_bound:.4f} m/s"
        return VerdictLine(Question.OPTIMUM, Word.BOUND, figure)
    least = f"{met.lower_bound:.6g} {UNIT[met.cost]}"
    if plan.scenario.rendezvous.duration_s != "free":
        return VerdictLine(Question.OPTIMUM, Word.PROVED, f"two impulses of this time cost at least {least}")
    count, orbits = len(met.minima), f"{plan.scenario.rendezvous.longest_orbits:.3g} orbits"
    minima = f"least of {count} minima" if count > 1 else "the one minimum"
    both = met.cost == "squares" and len(plan.stationary_s) == count
    figure = f"{minima} in {orbits}, by scan{' and polynomials' * both}; ≥ {least}"
    return VerdictLine(Question.OPTIMUM, Word.BEST_FOUND, figure)


def _safety(plan: Plan) -> VerdictLine | None:
    """A launch asks for no keep-out: how near to the target an impulse that is not fired leads is told."""
    if plan.meeting is None or plan.verification is None:
        return None
    near = [cut.missed_m for cut in plan.cuts]
    figure = f"nearest in {ORBITS:g} orbits {near[0]:.1f} m without impulse 1, {near[-1]:.1f} m without {len(near)}"
    held = max(each.nearest_m for each in plan.holds)
    return VerdictLine(Question.SAFETY, Word.NOT_ASKED, figure, evidence=f"hold point {held:.1f} m")


def _flights(plan: Plan) -> VerdictLine | None:
    """Where the draws with errors end, impulses and time as planned."""
    found = plan.dispersed
    if found is None:
        return None
    mean, p95 = found.miss_m.mean(), np.quantile(found.miss_m, 0.95)
    figure = (
        f"{found.miss_m.size} flights with errors end {mean:.1f} m off on average, 95 % within {p95:.1f} m"
    )
    return VerdictLine(Question.FLIGHTS, Word.SAMPLED, figure)
