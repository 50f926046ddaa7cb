"""Plan an approach: choose times, solve, fly it by other integrators, cut every burn; or audit a programme given."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from math import inf

from orbsoc.conic.solution import Status
from orbsoc.guidance.impulses import ImpulseProgramme
from orbsoc.guidance.mission import Column, PlanStatus
from orbsoc.guidance.scenario_file import Complaint, ScenarioError
from orbsoc.guidance.scp import ExitReason, Iteration, Solve, uninterrupted

from .dispersion import MonteCarlo, fly_many
from .model.approach import Approach
from .model.problem import CAPTURE
from .scenario import Scenario
from .search.front import FrontPoint, interruption_front
from .search.timing import Timed, plan_times
from .verification import LIMIT_M, Verification, verify

BROKEN = 0.05
"""Of the keep-out: a circular model that loses more about an eccentric target is refused."""
COLUMNS = {"second_s": Column("impulse 2", ".2f", "s"), "cost_m_s": Column("cost", ".6f", "m/s")}
"""Columns of the iteration table that are this mission's own."""


class Analysis:
    """What a report tells of a programme and the plan does not depend on, computed when it is first asked for; solved with `orbsoc.solve`, whatever solved the plan. KeyboardInterrupt goes to the caller."""

    def __init__(self, approach: Approach, programme: ImpulseProgramme) -> None:
        self.approach, self.programme = approach, programme

    @cached_property
    def flights(self) -> Mapping[str, MonteCarlo]:
        """With the errors of the scenario: "as_planned", without re-planning, and "re_planned" before every burn."""
        errors = self.approach.scenario.uncertainty
        if errors is None or not errors.runs:
            return {}
        solve = uninterrupted()
        return {
            "as_planned": fly_many(self.approach, self.programme, solve, replan=False),
            "re_planned": fly_many(self.approach, self.programme, solve),
        }

    @cached_property
    def front(self) -> tuple[FrontPoint, ...]:
        """With `interruption_orbits`: what other durations cost, by the orbits that an interrupted burn stays safe."""
        orbits = self.approach.scenario.interruption_orbits
        return interruption_front(self.approach, uninterrupted()) if orbits else ()


@dataclass(frozen=True, slots=True, eq=False)
class ApproachPlan:
    """How planning ended, the programme, what was solved for it, and what its flights found; None where there is none."""

    scenario: Scenario
    approach: Approach
    status: PlanStatus
    exit_reason: ExitReason
    message: str
    programme: ImpulseProgramme | None = None
    timed: Timed | None = None
    verification: Verification | None = None
    analysis: Analysis | None = None

    @property
    def flights(self) -> Mapping[str, MonteCarlo]:
        """`Analysis.flights`; empty without a programme that was flown."""
        return self.analysis.flights if self.analysis else {}

    @property
    def front(self) -> tuple[FrontPoint, ...]:
        """`Analysis.front`; empty without a programme that was flown."""
        return self.analysis.front if self.analysis else ()

    @property
    def subproblems(self) -> tuple[Iteration, ...]:
        return self.timed.subproblems if self.timed else ()

    @property
    def cost(self) -> float:
        """As the scenario asks for it, m/s; NaN without a programme."""
        if self.programme is None:
            return float("nan")
        norms = self.scenario.cost == "norms"
        return self.programme.total_m_s if norms else self.programme.total_absolutes_m_s

    @property
    def nearest_m(self) -> float:
        """How near to the target the drift after any completed impulse comes, over all later time; infinite without."""
        cuts = self.verification.cuts if self.verification else ()
        return min((cut.completed_m for cut in cuts), default=float("inf"))

    @property
    def safe(self) -> bool:
        """For all time after every completed impulse."""
        return self.nearest_m >= self.scenario.keep_out_m - LIMIT_M

    @property
    def safe_when_cut(self) -> bool:
        """For all time after every impulse, wherever in it the engine stops."""
        cuts = self.verification.cuts if self.verification else ()
        return all(cut.distance_m >= self.scenario.keep_out_m - LIMIT_M for cut in cuts)

    @property
    def nearest_with_j2_m(self) -> float:
        """The same with J2, for one orbit; of the drifts after the second burn and later, their depth in the half-space."""
        truths = self.verification.truths if self.verification else ()
        return min(
            (min(each.first_range_m, each.least_depth_m) for each in truths if each.name == "j2"), default=inf
        )

    @property
    def safety_kept(self) -> bool:
        """Whether the chaser stays as safe as the scenario asks: at samples or for all time, and where a burn is cut."""
        found, least = self.verification, self.scenario.keep_out_m - LIMIT_M
        if found is None or not self.approach.guarded:
            return found is not None
        conditions = all(check.kept for check in found.checks if not check.name.startswith(CAPTURE))
        if self.scenario.safety == "samples":
            return conditions
        return conditions and self.safe and all(cut.distance_m >= least for cut in found.cuts_within_orbits)


def made(
    scenario: Scenario, solve: Solve | None = None, callback: Callable[[Iteration], None] | None = None
) -> ApproachPlan:
    """The plan, flown. Raises ScenarioError where the circular model breaks the keep-out about an eccentric target."""
    found = plan_unflown(scenario, solve=solve, callback=callback)
    if found.programme is None:
        return found
    found = _flown(found)
    assert found.verification is not None
    _refuse_a_broken_model(scenario, found.verification)
    return found


def plan_unflown(
    scenario: Scenario, *, solve: Solve | None = None, callback: Callable[[Iteration], None] | None = None
) -> ApproachPlan:
    """The plan as it is solved, without flights and audits; its status says that nothing has verified it."""
    approach = Approach.of(scenario)
    try:
        timed = plan_times(approach, uninterrupted(solve), callback)
    except KeyboardInterrupt:
        return ApproachPlan(scenario, approach, PlanStatus.INTERRUPTED, ExitReason.INTERRUPTED, "interrupted")
    if timed.best is None or timed.programme is None:
        return _without_solution(approach, timed)
    return ApproachPlan(
        scenario, approach, PlanStatus.NOT_VERIFIED, ExitReason.CONVERGED, _message(timed),
        programme=timed.programme, timed=timed,
    )  # fmt: skip


def judged(scenario: Scenario, programme: ImpulseProgramme) -> ApproachPlan:
    """A programme that was made elsewhere. Raises ScenarioError where an impulse lies outside the scenario's time."""
    for t in programme.times_s[[0, -1]]:
        if not 0.0 <= t <= scenario.duration_s:
            allowed = f"must lie within 0 and duration_s = {scenario.duration_s:g}"
            raise ScenarioError(scenario.name, [Complaint("impulses, time_s", f"{t:g}", allowed)])
    message = f"{len(programme)} impulses as given, nothing was solved"
    approach = Approach.of(scenario)
    found = ApproachPlan(
        scenario, approach, PlanStatus.NOT_VERIFIED, ExitReason.CONVERGED, message, programme
    )
    return _flown(found)


def _flown(found: ApproachPlan) -> ApproachPlan:
    """A programme with its flights, and whether every condition holds, safety as it was asked for too."""
    assert found.programme is not None
    flown = verify(found.approach, found.programme)
    found = replace(found, verification=flown, analysis=Analysis(found.approach, found.programme))
    verified = flown.verified and found.safety_kept
    return replace(found, status=PlanStatus.VERIFIED if verified else PlanStatus.NOT_VERIFIED)


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


def _without_solution(approach: Approach, timed: Timed) -> ApproachPlan:
    """The reason is told of the trial in the middle, or of the one that failed.

    Given times are a proof; scanned ones prove nothing of those between them, which `Timed.nowhere` does.
    """
    proofs = [trial for trial in timed.trials if trial.solution.status is Status.PRIMAL_INFEASIBLE]
    if len(proofs) == len(timed.trials):
        middle = proofs[len(proofs) // 2]
        message = middle.impulses.builder.why(middle.solution)
        status, ended = PlanStatus.INFEASIBLE, ExitReason.SUBPROBLEM_INFEASIBLE
        if timed.scanned:
            at = f"; at {middle.second_s:.0f} s {message}"
            message = f"no time of impulse 2 will do{at}"
            if timed.nowhere is None:
                status = PlanStatus.NOT_FOUND
                message = f"none of {len(proofs)} times of impulse 2 will do, {timed.relaxed} searched{at}"
    else:
        failed = next(trial for trial in timed.trials if trial not in proofs)
        status, ended = PlanStatus.FAILED, ExitReason.SUBPROBLEM_FAILED
        message = f"a problem ended with {failed.solution.status.name}: {failed.solution.message}"
    return ApproachPlan(approach.scenario, approach, status, ended, message, timed=timed)
