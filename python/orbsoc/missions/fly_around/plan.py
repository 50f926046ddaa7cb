"""A plan as `guidance.mission.Plan` has it, its verdict, and the functions by which the mission makes one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from math import ceil
from pathlib import Path
from typing import Any

import numpy as np

from orbsoc.guidance.claims import Claim, Kind
from orbsoc.guidance.impulses import ImpulseProgramme
from orbsoc.guidance.mission import Difference, FigureFile, PlanStatus
from orbsoc.guidance.safety import nearest_claim
from orbsoc.guidance.scp import Iteration, Solve
from orbsoc.guidance.verdict import Question, Verdict, VerdictLine, Word, shortened

from .planner import FlyAround, judged, made
from .record import later_errors_m, plan_document
from .scenario import Scenario
from .search.pulses import Search
from .verification import ORBITS, Checked, messages


@dataclass(frozen=True, slots=True, eq=False)
class Plan(FlyAround):
    """A fly-around with its verdict and files."""

    @property
    def verdict(self) -> Verdict:
        """Answer, whether fewer pulses could do, engine failures, and flights with errors."""
        found = self.verification
        more = [] if found is None else [_safety(found), _flights(self, found)]
        return Verdict.of([_answer(self), _optimum(self), *more])

    def to_dict(self) -> dict[str, Any]:
        return plan_document(self)

    def tables(self) -> dict[str, str]:
        found = self.verification
        if found is None:
            return {}
        table = {"impulses.csv": found.programme.to_csv()}
        return table | messages(self.scenario, found.flown, found.truth)

    def figures(self, folder: Path) -> tuple[FigureFile, ...]:
        from .figures import draw_figures

        return draw_figures(self, folder)

    def differences(self, other: Plan) -> tuple[Difference, ...]:
        """Pulses, Σ‖Δv‖, and every bound of the proofs, the arcs' too."""
        found: list[Difference] = []
        if self.verification is not None and other.verification is not None:
            ours, theirs = self.verification, other.verification
            for name, words, one, another, tolerance, unit in (
                ("pulses", "number of pulses", len(ours.programme), len(theirs.programme), 0.0, ""),
                ("delta_v_m_s", "velocity change", ours.programme.total_m_s, theirs.programme.total_m_s, 1e-4, "m/s"),
                ("largest_error_m", "largest error", ours.flown.largest_error_m, theirs.flown.largest_error_m, 1e-4, "m"),
            ):  # fmt: skip
                found.append(Difference(name, words, abs(one - another), tolerance, unit))
        if self.search is not None and other.search is not None and self.search.bounds:
            apart = [
                abs(arc.bound_m - again.bound_m)
                for bound, check in zip(self.search.bounds, other.search.bounds, strict=False)
                for arc, again in zip(bound.arcs, check.arcs, strict=False)
            ]
            same = [b.pulses for b in self.search.bounds] == [b.pulses for b in other.search.bounds]
            worst = float(np.max(apart)) if same else float("inf")
            found.append(Difference("bound_m", "error bound of an arc", worst, 1e-4, "m"))
        return tuple(found)


def _answer(plan: Plan) -> VerdictLine:
    """Pulses, velocity change and error, or why there are none."""
    found, search, scenario = plan.verification, plan.search, plan.scenario
    word, limit = Word[plan.status.name], f"{scenario.tolerance_m:g} m"
    if found is not None:
        if scenario.truth.excess_share:
            limit = f"{scenario.tolerance_m:g} + {scenario.allowed_m - scenario.tolerance_m:.3g} m"
        if found.failures:
            advice = "" if plan.audited else "take more pulses"
            return VerdictLine(Question.ANSWER, word, found.failures[0], limit, advice)
        count = found.programme.fired
        pulses = f"{count} pulse{'s' if count > 1 else ''}, {found.programme.total_m_s:.3f} m/s"
        figure = f"{pulses}; strays {found.largest_error_m:.3f} m with J2 and drag"
        return VerdictLine(Question.ANSWER, word, figure, limit)
    if plan.status is PlanStatus.INFEASIBLE and search is not None and not search.reason:
        claim = _too_few(search)
        limit = f"{scenario.tolerance_m - search.impossible_margin_m:.4g} m"
        return VerdictLine(Question.ANSWER, word, f"{claim.claim}, proved", limit, "take more pulses", claim)
    return VerdictLine(Question.ANSWER, word, shortened(plan.message))


def _too_few(search: Search) -> Claim:
    """What is proved of `search.impossible` pulses, at any times."""
    count = search.impossible
    pulses = {0: "without a pulse it strays", 1: "1 pulse strays"}.get(count, f"{count} pulses stray")
    claim = f"{pulses} ≥ {search.impossible_any_m:.4f} m"
    class_ = f"every flight of {count} pulses at any times, by the linear model"
    arcs = f"{count} free arcs after the coast and {count} from the start, by their dual objectives"
    return Claim(Kind.PROVED, claim, class_, arcs if count else "the coast")


def _optimum(plan: Plan) -> VerdictLine | None:
    """Whether fewer pulses could do, whenever the first is; None where nothing is proved of it."""
    search = plan.search
    if search is None or search.found is None or search.impossible < (not search.certified):
        return None
    claim = _too_few(search)
    limit = f"{plan.scenario.tolerance_m - search.impossible_margin_m:.5g} m"
    if search.certified:
        return VerdictLine.of_claim(Question.OPTIMUM, claim, limit)
    if plan.scenario.impulses != "fewest":
        return VerdictLine.of_claim(Question.OPTIMUM, replace(claim, kind=Kind.BOUND), limit)
    open_ = replace(claim, kind=Kind.BEST_FOUND)
    return VerdictLine.of_claim(Question.OPTIMUM, open_, limit, "between is open")


def _safety(found: Checked) -> VerdictLine:
    """A fly-around asks for no keep-out: how near to the target an engine failure leads is told."""
    out, cut = found.nearest_out, found.nearest_cut
    figure = f"engine out: nearest {out.distance_m:.1f} m in {ORBITS:g} orbits (pulse {out.number})"
    within = f"{cut.distance_m:.1f} m if cut in pulse {cut.number}"
    claim = nearest_claim(found.cut_burns, f"for {ORBITS:g} orbits")
    return VerdictLine(Question.SAFETY, Word.NOT_ASKED, figure, evidence=within, claim=claim)


def _flights(plan: Plan, found: Checked) -> VerdictLine | None:
    """Of the Monte Carlo: how many flights leave the tolerance, against what the sigmas of the margin leave out."""
    drawn, errors = found.dispersed, plan.scenario.uncertainty
    if drawn is None or errors is None:
        return None
    tolerance, runs = plan.scenario.tolerance_m, len(drawn.largest_errors_m)
    beyond, later = (
        int(np.sum(each > tolerance)) for each in (drawn.largest_errors_m, later_errors_m(drawn))
    )
    allowed = ceil(2.0 * errors.left_out * len(found.programme) * runs)
    figure = f"{beyond} of {runs} leave {tolerance:g} m with errors, {later} after arc 2"
    if plan.search is None:
        return VerdictLine(Question.FLIGHTS, Word.SAMPLED, figure)
    word = Word.MET if beyond <= allowed else Word.PARTLY if later <= allowed else Word.MISSED
    return VerdictLine(Question.FLIGHTS, word, figure, str(allowed))


def plan(
    scenario: Scenario, *, solve: Solve | None = None, callback: Callable[[Iteration], None] | None = None
) -> Plan:
    """Plan the fly-around of `scenario`; `callback` sees every conic problem as it is solved.

    `solve` is any solver with the call shape of `orbsoc.solve`, which is the default.
    """
    return _with_files(made(scenario, solve, callback))


def audit(scenario: Scenario, programme: ImpulseProgramme) -> Plan:
    """A programme of impulses made elsewhere, judged as the scenario's own plan would be; nothing is solved.

    Raises ScenarioError where it has impulses outside the revolution.
    """
    return _with_files(judged(scenario, programme))


def _with_files(found: FlyAround) -> Plan:
    return Plan(**{field.name: getattr(found, field.name) for field in fields(FlyAround)})
