"""Plan an approach: choose times, solve, fly it by other integrators, cut every burn; or audit a programme given."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from orbsoc.conic.solution import Status
from orbsoc.guidance.impulses import ImpulseProgramme
from orbsoc.guidance.mission import Column, Difference, FigureFile, PlanStatus
from orbsoc.guidance.scenario_file import Complaint, ScenarioError
from orbsoc.guidance.scp import ExitReason, Iteration, Solve

from .analysis import Analysis
from .figures import draw_figures
from .messages import messages
from .model.approach import Approach
from .plan import ApproachPlan
from .record import plan_document
from .scenario import Scenario
from .search.timing import Timed, plan_times
from .verification import Verification, verify

BROKEN = 0.05
"""Of the keep-out: a circular model that loses more about an eccentric target is refused."""
COLUMNS = {
    "second_s": Column("impulse 2", ".2f", "s"),
    "cost_m_s": Column("cost", ".6f", "m/s"),
}
"""Columns of the iteration table that are this mission's own."""


@dataclass(frozen=True, slots=True, eq=False)
class Plan(ApproachPlan):
    """A plan as `guidance.mission.Plan` has it."""

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
    scenario: Scenario,
    *,
    solve: Solve | None = None,
    callback: Callable[[Iteration], None] | None = None,
) -> Plan:
    """Plan the approach of `scenario` with `solve`, `orbsoc.solve` by default; `callback` sees every solved problem.

    What cannot be reached is a status with its reason. Raises `orbsoc.guidance.scenario_file.ScenarioError` where the
    circular model breaks the keep-out about an eccentric target.
    """
    found = plan_unflown(scenario, solve=solve, callback=callback)
    if found.programme is None:
        return found
    flown = verify(found.approach, found.programme)
    _refuse_a_broken_model(scenario, flown)
    analysis = Analysis(found.approach, found.programme)
    return replace(found, status=_judged(flown), verification=flown, analysis=analysis)


def plan_unflown(
    scenario: Scenario,
    *,
    solve: Solve | None = None,
    callback: Callable[[Iteration], None] | None = None,
) -> Plan:
    """The plan as it is solved, without flights and audits; its status says that nothing has verified it."""
    if solve is None:
        from orbsoc.solving.solver import solve as solve_in_rust

        solve = solve_in_rust
    approach = Approach.of(scenario)
    try:
        timed = plan_times(approach, solve, callback)
    except KeyboardInterrupt:
        return Plan(scenario, approach, PlanStatus.INTERRUPTED, ExitReason.INTERRUPTED, "interrupted")
    if timed.best is None or timed.programme is None:
        return _without_solution(approach, timed)
    return Plan(
        scenario, approach, PlanStatus.NOT_VERIFIED, ExitReason.CONVERGED, _message(timed),
        programme=timed.programme, timed=timed,
    )  # fmt: skip


def audit(scenario: Scenario, programme: ImpulseProgramme) -> Plan:
    """A programme that was made elsewhere, judged and flown as the scenario's own plan would be; nothing is solved.

    Raises ScenarioError where an impulse lies outside the scenario's time.
    """
    approach = Approach.of(scenario)
    for t in programme.times_s[[0, -1]]:
        if not 0.0 <= t <= scenario.duration_s:
            allowed = f"must lie within 0 and duration_s = {scenario.duration_s:g}"
            raise ScenarioError(scenario.name, [Complaint("impulses, time_s", f"{t:g}", allowed)])
    flown = verify(approach, programme)
    message = f"{len(programme)} impulses as given, nothing was solved"
    return Plan(
        scenario, approach, _judged(flown), ExitReason.CONVERGED, message,
        programme=programme, verification=flown, analysis=Analysis(approach, programme),
    )  # fmt: skip


def _refuse_a_broken_model(scenario: Scenario, flown: Verification) -> None:
    """Where the circular model about an eccentric target ends in the keep-out by true motion."""
    target, keep_out = scenario.target, scenario.keep_out_m
    if target.elliptic or not target.eccentricity or not keep_out:
        return
    truth = next(each for each in flown.truths if each.name == "two_body")
    depth = min(truth.least_depth_m, truth.first_range_m)
    if depth < keep_out * (1.0 - BROKEN):
        allowed = (
            f"about target.eccentricity = {target.eccentricity:g} the plan of the circular model passes at {depth:.1f} m"
            f" (keep_out_m = {keep_out:g}) and misses the capture point by {truth.capture_miss_m:.1f} m;"
            " must be 'elliptic', with safety = 'samples'"
        )
        raise ScenarioError(scenario.name, [Complaint("target.motion", "'circular'", allowed)])


def _judged(flown: Verification) -> PlanStatus:
    return PlanStatus.VERIFIED if flown.verified else PlanStatus.NOT_VERIFIED


def _message(timed: Timed) -> str:
    assert timed.best is not None
    solution = timed.best.solution
    words = f"solved in {solution.iterations} iterations"
    if solution.status is not Status.SOLVED:
        words += f", {solution.status.value}: these times leave the constraints no interior"
    if timed.scanned:
        wells = "one well" if timed.wells == 1 else f"{timed.wells} wells"
        words = (
            f"impulse 2 at {timed.best.second_s:.2f} s is the best of {len(timed.trials)} times, {timed.scanned} of them"
            f" a scan with {wells}; {words}"
        )
    return words


def _without_solution(approach: Approach, timed: Timed) -> Plan:
    """The reason is told of the last trial that proves one, or of the one that failed."""
    proofs = [trial for trial in timed.trials if trial.solution.status is Status.PRIMAL_INFEASIBLE]
    if len(proofs) == len(timed.trials):
        middle = proofs[len(proofs) // 2]
        reason = middle.impulses.builder.why(middle.solution)
        at = (
            f"with impulse 2 at {middle.second_s:.0f} s, one of {len(proofs)} times tried, "
            if len(proofs) > 1
            else ""
        )
        status, ended, message = PlanStatus.INFEASIBLE, ExitReason.SUBPROBLEM_INFEASIBLE, f"{at}{reason}"
    else:
        failed = next(trial for trial in timed.trials if trial not in proofs)
        status, ended = PlanStatus.FAILED, ExitReason.SUBPROBLEM_FAILED
        message = f"a problem ended with {failed.solution.status.name}: {failed.solution.message}"
    return Plan(approach.scenario, approach, status, ended, message, timed=timed)
