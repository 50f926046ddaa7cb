"""A plan as `guidance.mission.Plan` has it, its verdict, and the functions by which the mission makes one."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from math import ceil
from pathlib import Path
from typing import Any

from orbsoc.conic.solution import Status
from orbsoc.guidance.claims import Claim, Kind
from orbsoc.guidance.impulses import INSTANTS, ImpulseProgramme
from orbsoc.guidance.mission import Difference, FigureFile, PlanStatus
from orbsoc.guidance.safety import nearest_claim
from orbsoc.guidance.scp import Iteration, Solve
from orbsoc.guidance.verdict import Question, Verdict, VerdictLine, Word, shortened

from .figures import draw_figures
from .model.problem import CAPTURE
from .planner import ApproachPlan, judged, made
from .record import messages, plan_document
from .scenario import Scenario
from .search.impossible import APART_S, LARGEST_M_S
from .verification import LIMIT_M

WORTH_WAITING = 0.95
"""Of the plan's cost: a longer approach that costs more than that is not told."""


@dataclass(frozen=True, slots=True, eq=False)
class Plan(ApproachPlan):
    """An approach with its verdict and files."""

    @property
    def verdict(self) -> Verdict:
        """Answer, a cheaper duration, what is known of the optimum, safety, and flights with errors."""
        return Verdict.of([_answer(self), _option(self), _optimum(self), _safety(self), _flights(self)])

    def to_dict(self) -> dict[str, Any]:
        return plan_document(self)

    def tables(self) -> Mapping[str, str]:
        if self.programme is None or self.verification is None:
            return {}
        return {"impulses.csv": self.programme.to_csv(), **messages(self)}

    def figures(self, folder: Path) -> tuple[FigureFile, ...]:
        return draw_figures(self, folder)

    def differences(self, other: Plan) -> tuple[Difference, ...]:
        """Costs, and with given times the impulses, whose optimum is unique."""
        if self.programme is None or other.programme is None:
            return ()
        found = [Difference("cost_m_s", "cost", abs(self.cost - other.cost), 1e-6, "m/s")]
        if self.scenario.impulses.timing == "equal":
            apart = float(abs(self.programme.dv_m_s - other.programme.dv_m_s).max())
            found.append(Difference("dv_m_s", "impulses", apart, 1e-4, "m/s"))
        return tuple(found)


def plan(
    scenario: Scenario, *, solve: Solve | None = None, callback: Callable[[Iteration], None] | None = None
) -> Plan:
    """Plan the approach of `scenario` with `solve`, `orbsoc.solve` by default; `callback` sees every solved problem.

    What cannot be reached is a status with its reason. Raises `orbsoc.guidance.scenario_file.ScenarioError` where the
    circular model breaks the keep-out about an eccentric target.
    """
    return _with_files(made(scenario, solve, callback))


def audit(scenario: Scenario, programme: ImpulseProgramme) -> Plan:
    """A programme that was made elsewhere, judged and flown as the scenario's own plan would be; nothing is solved.

    Raises ScenarioError where an impulse lies outside the scenario's time.
    """
    return _with_files(judged(scenario, programme))


def _with_files(found: ApproachPlan) -> Plan:
    return Plan(**{field.name: getattr(found, field.name) for field in fields(ApproachPlan)})


def _answer(plan: Plan) -> VerdictLine:
    word, found = Word[plan.status.name], plan.verification
    if found is None or plan.programme is None:
        claim = None
        if plan.status is PlanStatus.INFEASIBLE:
            claim = Claim(Kind.PROVED, "no programme", _class(plan), _proof(plan))
        return VerdictLine(Question.ANSWER, word, shortened(plan.message), claim=claim)
    if plan.status is PlanStatus.VERIFIED:
        spent = plan.programme.words
        if plan.scenario.cost == "absolutes":
            spent = spent.replace(
                f"{plan.programme.total_m_s:.4f} m/s", f"{plan.cost:.4f} m/s along the axes"
            )
        figure = f"{spent}; flown {found.terminal_position_m:.0e} m off"
        return VerdictLine(Question.ANSWER, word, figure, f"{LIMIT_M:g} m")
    first, *others = (*found.failures, "it is not as safe as was asked for")
    more = f"{len(others) - 1} more" if len(others) > 1 else ""
    return VerdictLine(Question.ANSWER, word, shortened(first), evidence=more)


def _option(plan: Plan) -> VerdictLine | None:
    """A longer approach that is as safe and cheaper, of the front."""
    same = [
        point
        for point in plan.front
        if point.orbits == plan.scenario.interruption_orbits and point.duration_s > plan.scenario.duration_s
    ]
    best = min(same, key=lambda point: point.cost, default=None)
    if best is None or not best.cost < WORTH_WAITING * plan.cost:
        return None
    less = f"{best.cost:.4f} m/s (−{100.0 * (1.0 - best.cost / plan.cost):.0f} %)"
    figure = f"an approach of {best.duration_s:.0f} s takes {less}"
    return VerdictLine(
        Question.OPTION, Word.CHEAPER, figure, settings={"duration_s": f"{best.duration_s:.0f}"}
    )


def _optimum(plan: Plan) -> VerdictLine | None:
    """The dual bound for the times of the plan, and how these were found; None where nothing was solved for them."""
    timed = plan.timed
    if timed is None or timed.best is None:
        return None
    solution, tried = timed.best.solution, len(timed.trials)
    bound = f"{solution.dual_objective:.6f} m/s"
    if timed.lower_bound is not None and timed.primer is not None:
        gap = (timed.best.cost - timed.lower_bound) / max(timed.best.cost, 1e-12)
        words = f"impulses at any times cost at least {timed.lower_bound:.6f} m/s"
        checked = f"primer ≤ {timed.primer[0]:.7f} at {INSTANTS} instants, {timed.primer[1]:.7f} between them"
        return VerdictLine.of_claim(
            Question.OPTIMUM, Claim(Kind.BOUND, words, _class(plan), checked, gap), evidence=f"gap {gap:.0e}"
        )
    if timed.densest is not None:
        later = "all candidate times" if timed.later is None else "any times after impulse 2"
        least = timed.later or timed.densest.solution.dual_objective
        words = f"{tried} problems; with impulses at {later} at least {least:.6f} m/s"
        gap = (timed.best.cost - least) / max(least, 1e-12)
        class_ = f"impulses at {later}; impulse 2 where the scan left it"
        return VerdictLine.of_claim(
            Question.OPTIMUM, Claim(Kind.BEST_FOUND, words, class_, "dual bound", gap)
        )
    if timed.scanned:
        words = f"impulse 2 at {timed.best.second_s:.2f} s is the best of {tried} times"
        claim = Claim(Kind.BEST_FOUND, words, "impulse 2 at the times tried", f"{tried} conic problems")
        return VerdictLine.of_claim(Question.OPTIMUM, claim, evidence=f"with it at least {bound}")
    if solution.status is not Status.SOLVED:
        claim = Claim(Kind.BEST_FOUND, f"the solver ended {solution.status.value}", _class(plan), "none")
        return VerdictLine.of_claim(Question.OPTIMUM, claim)
    gap = (solution.objective - solution.dual_objective) / max(abs(solution.objective), 1e-12)
    words = f"impulses at these times cost at least {bound}"
    return VerdictLine.of_claim(
        Question.OPTIMUM, Claim(Kind.PROVED, words, _class(plan), "dual objective", gap)
    )


def _class(plan: Plan) -> str:
    """Of which programmes a bound of the plan's problem speaks."""
    timed = plan.timed
    times = "any times" if timed is not None and timed.primer is not None else "these times"
    if timed is not None and timed.nowhere is not None:
        generated = plan.scenario.impulses.timing == "generated"
        others = "others at any times" if generated else "others equally spaced after it"
        times = (
            f"0 s and, the second, any time more than {APART_S:g} s from the first and from the end, {others},"
            f" no component above {LARGEST_M_S:g} m/s"
        )
    return f"impulses at {times}, by the linear model with every condition of the scenario"


def _proof(plan: Plan) -> str:
    """Of what is infeasible."""
    found = None if plan.timed is None else plan.timed.nowhere
    if found is None:
        return "an infeasibility certificate"
    return f"certificates for all of {found.pieces} pieces of the interval, {found.solves} conic problems"


def _safety(plan: Plan) -> VerdictLine | None:
    """How near the drift after any burn comes: SAFE where also a burn that stops inside and J2 lead no nearer."""
    found, orbits = plan.verification, plan.scenario.interruption_orbits
    if found is None or not found.cuts:
        return None
    if not plan.approach.guarded:
        return VerdictLine(Question.SAFETY, Word.NOT_ASKED, "keep_out_m = 0")
    whole = min(found.cuts, key=lambda each: each.completed_m)
    cut = min(found.cuts, key=lambda each: each.distance_m)
    figure, limit = (
        f"{whole.completed_m:.2f} m after burn {whole.number}",
        f"≥ {plan.scenario.keep_out_m:g} m",
    )
    if not plan.approach.circular:
        figure += " in an orbit"
    if found.cuts_within_orbits:
        nearest = min(whole.completed_m, *(each.distance_m for each in found.cuts_within_orbits))
        figure = f"{nearest:.2f} m for {orbits} orbit{'s' * (orbits > 1)} after any cut"
    if plan.scenario.safety == "samples" and not plan.safe:
        limit += " at samples"
    broken = [each for each in found.checks if not each.kept and not each.name.startswith(CAPTURE)]
    if broken and plan.safe:  # by the side on which it passes, not by its distance
        return VerdictLine(Question.SAFETY, Word.NOT_SAFE, str(broken[0]))
    stronger = []
    if not plan.safe_when_cut:
        stronger.append(f"{'later' if orbits else f'burn {cut.number} cut short'} {cut.distance_m:.1f} m")
    if plan.nearest_with_j2_m < plan.scenario.keep_out_m - LIMIT_M:
        stronger.append(f"with J2 {plan.nearest_with_j2_m:.1f} m")
    word = Word.NOT_SAFE if not plan.safety_kept else Word.PARTLY if stronger or not plan.safe else Word.SAFE
    claim = nearest_claim(found.cuts, "for all time" if plan.approach.circular else "for an orbit")
    return VerdictLine(Question.SAFETY, word, figure, limit, ", ".join(stronger), claim)


def _flights(plan: Plan) -> VerdictLine | None:
    """Of the Monte Carlo: how many flights enter the keep-out, against what the sigmas of the margin leave out."""
    found, errors = plan.flights.get("re_planned"), plan.scenario.uncertainty
    if found is None or errors is None or plan.programme is None:
        return None
    allowed = ceil(errors.left_out * len(plan.programme) * found.runs)
    figure = f"{found.unsafe} of {found.runs} enter the keep-out"
    given = f"{found.fallbacks + found.failed} of {found.replans} re-plans gave margins up"
    word = Word.MET if found.unsafe <= allowed else Word.MISSED
    return VerdictLine(Question.FLIGHTS, word, figure, str(allowed), given)
