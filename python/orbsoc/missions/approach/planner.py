"""Plan an approach: convex problems in sequence from every side that reaches the gate, the cheapest flown; or audit one given."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from orbsoc.conic.solution import Status
from orbsoc.guidance.impulses import ImpulseProgramme
from orbsoc.guidance.mission import Column, PlanStatus
from orbsoc.guidance.scenario_file import Complaint, ScenarioError
from orbsoc.guidance.scp import ExitReason, Iteration, Solve, uninterrupted

from .model.approach import Approach
from .model.nearest import Search
from .model.problem import assemble, at_nodes
from .scenario import Scenario
from .search.sequence import Attempt, attempt, cost_of, lower_bound, sides
from .verification.closed_loop import CorrectedFlights, fly_corrected
from .verification.verify import Verification, verify

COLUMNS = {"cost_m_s": Column("cost", ".6f", "m/s"), "broken_m": Column("broken by", ".1e", "m")}
"""Columns of the iteration table that are this mission's own."""


class Analysis:
    """Flights with errors, computed when they are first asked for."""

    def __init__(self, approach: Approach, programme: ImpulseProgramme, found: Verification) -> None:
        self.approach, self.programme, self.verification = approach, programme, found

    @cached_property
    def flights(self) -> CorrectedFlights | None:
        """With the errors of the scenario, about the Earth, corrected before every impulse; None where none are asked for."""
        errors = self.approach.scenario.uncertainty
        if errors is None or not errors.runs:
            return None
        flown = self.verification.arcs
        return fly_corrected(self.approach, self.programme, flown, errors=errors, runs=errors.runs)


@dataclass(frozen=True, slots=True, eq=False)
class ApproachPlan:
    """How planning ended, the programme, what was solved for it, and what its flights found; None where there is none."""

    scenario: Scenario
    approach: Approach
    status: PlanStatus
    exit_reason: ExitReason
    message: str
    programme: ImpulseProgramme | None = None
    attempts: tuple[Attempt, ...] = ()
    lower_bound: float | None = None
    subproblems: tuple[Iteration, ...] = ()
    verification: Verification | None = None
    analysis: Analysis | None = None

    @property
    def flights(self) -> CorrectedFlights | None:
        return self.analysis.flights if self.analysis else None

    @property
    def cost(self) -> float:
        """As the scenario asks for it, m/s; NaN without a programme."""
        return float("nan") if self.programme is None else cost_of(self.approach, self.programme)


def made(
    scenario: Scenario, solve: Solve | None = None, callback: Callable[[Iteration], None] | None = None
) -> ApproachPlan:
    """The plan, flown."""
    found = plan_unflown(scenario, solve, callback)
    return found if found.programme is None else _flown(found)


def plan_unflown(
    scenario: Scenario, solve: Solve | None = None, callback: Callable[[Iteration], None] | None = None
) -> ApproachPlan:
    """The plan as it is solved; its status says that nothing has verified it."""
    approach, used = Approach.of(scenario), uninterrupted(solve)
    try:
        _, row = lower_bound(approach, at_nodes(approach), used)
        if row.solution.status is Status.PRIMAL_INFEASIBLE:
            why = _why(approach, row)
            return ApproachPlan(
                scenario,
                approach,
                PlanStatus.INFEASIBLE,
                ExitReason.SUBPROBLEM_INFEASIBLE,
                why,
                subproblems=(row,),
            )
        attempts = _attempts(approach, used, callback)
    except KeyboardInterrupt:
        return ApproachPlan(scenario, approach, PlanStatus.INTERRUPTED, ExitReason.INTERRUPTED, "interrupted")
    solved = (row, *(each for attempt in attempts for each in attempt.subproblems))
    rows = tuple(replace(each, number=k) for k, each in enumerate(solved, 1))
    safe = [each for each in attempts if each.found]
    if not safe:
        return _nothing(approach, attempts, rows)
    best = min(safe, key=lambda each: each.reference.cost)
    try:  # with all the instants that the plan asked for
        least, row = lower_bound(approach, best.reference.instants, used)
    except KeyboardInterrupt:
        return ApproachPlan(scenario, approach, PlanStatus.INTERRUPTED, ExitReason.INTERRUPTED, "interrupted")
    rows = (*rows, replace(row, number=len(rows) + 1))
    programme, others = best.reference.safe, len(attempts) - 1
    assert programme is not None
    programme = ImpulseProgramme(
        programme.times_s, np.where(np.abs(programme.dv_m_s) < 1e-7, 0.0, programme.dv_m_s)
    )
    message = f"{best.message}; first {best.side}" + (f", cheaper than {others} other ways" if others else "")
    return ApproachPlan(
        scenario, approach, PlanStatus.NOT_VERIFIED, best.reason, message, programme, attempts, least, rows
    )


def _attempts(
    approach: Approach, solve: Solve, callback: Callable[[Iteration], None] | None
) -> tuple[Attempt, ...]:
    """The flight that knows no keep-out alone, where it is safe; otherwise one from each side, and then from that flight."""
    ways = sides(approach)
    free = assemble(approach, at_nodes(approach), None)
    solution = solve(free.builder.build())
    if solution.status is Status.SOLVED:
        broken = Search(approach).broken(free.programme(solution))
        if not broken.instants.keep_out and broken.worst_m < np.inf:
            return (attempt(approach, "as it comes", None, solve, callback),)
    found = [
        attempt(approach, name, side, solve, callback) for name, side in ways.items() if side is not None
    ]
    if not any(each.found for each in found):
        found.append(attempt(approach, "as it comes", None, solve, callback))
    return tuple(found)


def _why(approach: Approach, row: Iteration) -> str:
    return assemble(approach, replace(at_nodes(approach), speed=()), None).builder.why(row.solution)


def _nothing(approach: Approach, attempts: tuple[Attempt, ...], rows: tuple[Iteration, ...]) -> ApproachPlan:
    last = attempts[-1]
    words = "; ".join(f"{each.side}: {each.why or each.message}" for each in attempts)
    failed = last.reason is ExitReason.SUBPROBLEM_FAILED
    status = PlanStatus.FAILED if failed else PlanStatus.NOT_FOUND
    if last.reason is ExitReason.INTERRUPTED:
        status = PlanStatus.INTERRUPTED
    message = f"no flight keeps every condition; {words}"
    return ApproachPlan(
        approach.scenario, approach, status, last.reason, message, attempts=attempts, subproblems=rows
    )


def judged(scenario: Scenario, programme: ImpulseProgramme) -> ApproachPlan:
    """A programme that was made elsewhere. Raises ScenarioError where an impulse lies outside the scenario's time."""
    approach = Approach.of(scenario)
    for t in programme.times_s[[0, -1]]:
        if not 0.0 <= t < scenario.duration_s:
            allowed = f"must lie within 0 and the arrival at the last point, {scenario.duration_s:g}"
            raise ScenarioError(scenario.name, [Complaint("impulses, time_s", f"{t:g}", allowed)])
    times = np.union1d(programme.times_s, approach.times_s[[0]])
    edges = [each for point in scenario.points.values() for each in (point.arrive_s, point.leave_s)]
    times = np.union1d(times, [each for each in edges if each < scenario.duration_s])
    dv = np.zeros((times.size, 3))
    dv[np.searchsorted(times, programme.times_s)] = programme.dv_m_s
    message = f"{len(programme)} impulses as given, nothing was solved"
    return _flown(
        ApproachPlan(
            scenario, replace(approach, times_s=times), PlanStatus.NOT_VERIFIED, ExitReason.CONVERGED, message,
            ImpulseProgramme(times, dv),
        )
    )  # fmt: skip


def _flown(found: ApproachPlan) -> ApproachPlan:
    assert found.programme is not None
    flown = verify(found.approach, found.programme)
    analysis = Analysis(found.approach, found.programme, flown)
    status = PlanStatus.VERIFIED if flown.verified else PlanStatus.NOT_VERIFIED
    return replace(found, verification=flown, analysis=analysis, status=status)
