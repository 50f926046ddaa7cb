"""A plan as `guidance.mission.Plan` has it, its verdict, and the functions by which the mission makes one."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from math import ceil
from pathlib import Path
from typing import Any

from orbsoc.guidance.claims import Claim, Kind
from orbsoc.guidance.impulses import ImpulseProgramme
from orbsoc.guidance.mission import Difference, FigureFile, PaperRow, PlanStatus
from orbsoc.guidance.safety import nearest_claim
from orbsoc.guidance.scp import Iteration, Solve
from orbsoc.guidance.verdict import Question, Verdict, VerdictLine, Word, shortened

from .figures import draw_figures
from .planner import ApproachPlan, judged, made
from .record import abort_table, messages, plan_document, spans, thrust_table
from .scenario import Scenario
from .verification.cuts import WITHIN_M
from .verification.verify import MISS_M, Verification


@dataclass(frozen=True, slots=True, eq=False)
class Plan(ApproachPlan):
    """An approach with its verdict and files."""

    @property
    def verdict(self) -> Verdict:
        """Answer, what is known of the optimum, the engine, safety, and flights with errors."""
        return Verdict.of([_answer(self), _optimum(self), _engine(self), _safety(self), _flights(self)])

    def to_dict(self) -> dict[str, Any]:
        return plan_document(self)

    def tables(self) -> Mapping[str, str]:
        if self.programme is None or self.verification is None:
            return {}
        flown = {"impulses.csv": self.programme.to_csv()}
        if self.approach.held:
            flown = {"thrust.csv": thrust_table(self)}
        return {**flown, "aborts.csv": abort_table(self), **messages(self)}

    def figures(self, folder: Path) -> tuple[FigureFile, ...]:
        return draw_figures(self, folder)

    def differences(self, other: Plan) -> tuple[Difference, ...]:
        """Costs: two sequences end within their stop rule of each other."""
        if self.programme is None or other.programme is None:
            return ()
        return (Difference("cost_m_s", "cost", abs(self.cost - other.cost), 1e-3 * self.cost, "m/s"),)


def plan(
    scenario: Scenario, *, solve: Solve | None = None, callback: Callable[[Iteration], None] | None = None
) -> Plan:
    """Plan the approach of `scenario` with `solve`, `orbsoc.solve` by default; `callback` sees every solved problem."""
    return _with_files(made(scenario, solve, callback))


def audit(scenario: Scenario, programme: ImpulseProgramme) -> Plan:
    """A programme that was made elsewhere, judged and flown as the scenario's own plan would be; nothing is solved.

    Raises ScenarioError where an impulse lies outside the scenario's time.
    """
    return _with_files(judged(scenario, programme))


def reproduce(_: Path) -> tuple[PaperRow, ...]:
    """The mission is after no paper."""
    return ()


def _with_files(found: ApproachPlan) -> Plan:
    return Plan(**{field.name: getattr(found, field.name) for field in fields(ApproachPlan)})


def _answer(plan: Plan) -> VerdictLine:
    word, found = Word[plan.status.name], plan.verification
    if found is None or plan.programme is None:
        claim = None
        if plan.status is PlanStatus.INFEASIBLE:
            class_ = f"{_class(plan)}; points, holds, corridor and engine, at instants, by the linear model"
            claim = Claim(Kind.PROVED, "no programme", class_, "an infeasibility certificate")
        return VerdictLine(Question.ANSWER, word, shortened(plan.message), claim=claim)
    if plan.status is PlanStatus.VERIFIED:
        spent = plan.words
        if plan.scenario.engine.cost == "absolutes":
            spent = spent.replace(
                f"{plan.programme.total_m_s:.4f} m/s", f"{plan.cost:.4f} m/s along the axes"
            )
        figure = f"{spent}; with J2 and drag, corrected, {found.corrected.miss_m[0]:.3f} m off"
        return VerdictLine(Question.ANSWER, word, figure, f"{MISS_M:g} m")
    first, *others = found.failures
    more = f"{len(others)} more" if others else ""
    return VerdictLine(Question.ANSWER, word, shortened(first), evidence=more)


def _optimum(plan: Plan) -> VerdictLine | None:
    """The dual bound without the keep-out, and from how many sides the plan was sought."""
    if plan.lower_bound is None or plan.programme is None:
        return None
    gap = (plan.cost - plan.lower_bound) / max(plan.cost, 1e-12)
    class_ = f"{_class(plan)}, by the linear model; keep-out, drifts and speed limit left out"
    if gap < 1e-3:
        words = f"{_class(plan)} cost at least {plan.lower_bound:.4f} m/s"
        return VerdictLine.of_claim(Question.OPTIMUM, Claim(Kind.BOUND, words, class_, "dual objective", gap))
    count = len(plan.attempts)
    words = (
        f"best of {count} start{'s' * (count != 1)}; without the keep-out at least {plan.lower_bound:.4f} m/s"
    )
    evidence = f"{len(plan.subproblems)} conic problems, dual objective of the last"
    return VerdictLine.of_claim(Question.OPTIMUM, Claim(Kind.BEST_FOUND, words, class_, evidence, gap))


def _class(plan: Plan) -> str:
    """Of programmes."""
    return "accelerations held on these arcs" if plan.approach.held else "impulses at these instants"


def _engine(plan: Plan) -> VerdictLine | None:
    if plan.programme is None or plan.verification is None:
        return None
    engine, unit = plan.scenario.engine, plan.approach.limit_unit
    largest = float(plan.verification.corrected.largest_m_s[0])
    check = next(each for each in plan.verification.checks if each.name == "engine")
    word = Word.ENOUGH if check.kept else Word.TOO_WEAK
    most, what, digits = engine.largest_m_s, "impulse", ".3f"
    if engine.largest_m_s2 is not None:
        most, what, digits = engine.largest_m_s2, "acceleration", ".3g"
    figure = f"largest {what} {most - check.margin:{digits}} {unit}, corrected {largest:{digits}} {unit}"
    limit = f"{most:g} {unit}{' an axis' if engine.limit == 'axes' else ''}"
    return VerdictLine(Question.ENGINE, word, figure, limit)


def _safety(plan: Plan) -> VerdictLine | None:
    """Drifts before the gate, aborts at every instant: SAFE where both hold and J2 and drag lead no nearer."""
    found, safety = plan.verification, plan.scenario.safety
    if found is None:
        return None
    if not found.cuts:
        return VerdictLine(Question.SAFETY, Word.NOT_ASKED, "safety.orbits = 0")
    how_long = (
        "for all time" if safety.all_time else f"for {safety.orbits:g} orbit{'s' * (safety.orbits != 1)}"
    )
    least = found.least_cut_m if safety.cut_burns else found.least_m
    figure = f"{least:.2f} m after any {'cut' if safety.cut_burns else 'whole'} {_burn(plan)} before the gate, {how_long}"
    needed = [each for each in found.aborts if not each.safe and each.dv_m_s is not None]
    words = []
    if plan.approach.held and not found.bounded:
        words.append("drifts are not known from below to 10 mm")
    if found.unsafe_aborts:
        what = "no abort impulse, drifts not safe" if plan.approach.held else "no abort"
        words.append(f"{what} at {spans(found.unsafe_aborts, safety.abort_every_s)}")
    if needed:
        words.append(f"aborts of ≤ {max(each.size_m_s for each in needed):.3f} m/s at {len(needed)} instants")
    if found.drift_with_j2_m < 0.0:
        words.append(f"with J2 and drag {-found.drift_with_j2_m:.1f} m inside")
    words.append(_errors(plan, found))
    strong = not found.unsafe_aborts and found.drift_with_j2_m >= 0.0 and safety.cut_burns
    strong = strong and (found.bounded or not plan.approach.held)
    word = Word.SAFE if strong else Word.PARTLY
    if not found.safe:
        word = Word.NOT_SAFE
    limit = f"≥ {found.keep_out_m:g} m"
    if not plan.approach.spherical:
        figure = figure.replace(f"{least:.2f} m", f"{least / found.keep_out_m:.4f} of the ellipsoid")
        limit = "≥ 1"
    return VerdictLine(
        Question.SAFETY, word, figure, limit, "; ".join(words), _nearest(plan, found, how_long)
    )


def _burn(plan: Plan) -> str:
    return "thrust" if plan.approach.held else "burn"


def _errors(plan: Plan, found: Verification) -> str:
    """What is in the line of errors: none, or the room that they leave the flight before the gate, never its drifts."""
    errors = plan.scenario.uncertainty
    if errors is None:
        return "no errors in it"
    room = f"leave the flight {found.room_m:.1f} m outside"
    if found.room_m < 0.0:
        room = f"reach {-found.room_m:.1f} m into the keep-out"
    return f"{errors.sigmas:g} σ of errors {room}, drifts without errors"


def _nearest(plan: Plan, found: Verification, how_long: str) -> Claim:
    """What is known of drifts before the gate."""
    if plan.approach.held:
        return _nearest_held(found, how_long)
    if plan.approach.circular and plan.approach.spherical:
        return nearest_claim(found.cuts, how_long)
    kind, least = Kind.BOUND, found.least_cut_m
    if not plan.approach.circular:
        kind = Kind.SAMPLED
    words = f"none comes nearer than {(least - WITHIN_M) / found.keep_out_m:.4f} of the keep-out"
    class_ = f"drifts after any burn, cut anywhere or whole, {how_long}, by the linear model"
    checked = "the nearest fraction at every time; intervals of time cut until that is known to 2 mm"
    return Claim(kind, words, class_, checked)


def _nearest_held(found: Verification, how_long: str) -> Claim:
    """The same of drifts after thrust that is held."""
    lows = [
        low for cut in found.cuts for low in (cut.at_least_m, cut.completed_at_least_m) if low is not None
    ]
    class_ = f"drifts after any thrust, cut at any instant or not, {how_long} after it, by the linear model"
    words = f"none comes nearer than {min(lows) / found.keep_out_m:.4f} of the keep-out"
    checked = "branch and bound over the instants of the cut and of the drift, bends in closed form"
    return Claim(Kind.BOUND, words, class_, checked)


def _flights(plan: Plan) -> VerdictLine | None:
    """Of the Monte Carlo: how many flights enter the keep-out or leave the corridor."""
    found, errors = plan.flights, plan.scenario.uncertainty
    if found is None or errors is None or plan.programme is None:
        return None
    runs = len(found.miss_m)
    allowed = ceil(errors.left_out * runs)
    figure = f"{found.entered} of {runs} enter the keep-out, {found.left_corridor} leave the corridor"
    word = Word.MET if max(found.entered, found.left_corridor) <= allowed else Word.MISSED
    missed = f"last point missed by ≤ {found.miss_m.max():.2f} m"
    if plan.approach.errors_m:
        missed += f"; margin {plan.approach.errors_m:.1f} m larger for {errors.sigmas:g} σ"
    return VerdictLine(Question.FLIGHTS, word, figure, str(allowed), missed)
