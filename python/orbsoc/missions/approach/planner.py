"""Plan an approach: convex problems in sequence from every side that reaches the gate, the cheapest flown; or audit one given."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from orbsoc.conic.solution import Status
from orbsoc.guidance.impulses import ImpulseProgramme
from orbsoc.guidance.mission import Column, PlanStatus
from orbsoc.guidance.scenario_file import Complaint, ScenarioError
from orbsoc.guidance.scp import ExitReason, Iteration, Solve, uninterrupted

from .model.approach import Approach
from .model.instants import at_nodes
from .model.nearest import Search
from .model.problem import Forms
from .scenario import Scenario
from .search.draws import drawn
from .search.sequence import (
    RULES,
    Attempt,
    about,
    attempt,
    beside,
    cost_of,
    lengthened,
    sides,
    solve_convex,
    turns,
    widened,
)
from .verification.closed_loop import CorrectedFlights, fly_corrected
from .verification.errors import room_m
from .verification.linear import arcs
from .verification.verify import Verification, verify

WORTH_MORE = 1.03
"""Of what the flight without the keep-out costs: a plan that costs no more is not sought from elsewhere."""
GROWN, MORE = 4, 1.02
"""Times that the keep-out grows for errors, and by how much of what is lacking."""
TOLD = 3
"""Attempts that a message tells of, where none found anything."""
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
    def words(self) -> str:
        """Of the programme: the velocity change, in how many impulses or on how many arcs; those without any are counted apart."""
        programme = self.programme
        if programme is None:
            return self.message
        if not self.approach.held:
            return programme.words
        return f"{programme.total_m_s:.4f} m/s of thrust held on {programme.fired} of {len(programme)} arcs"

    @property
    def cost(self) -> float:
        """As the scenario asks for it, m/s; NaN without a programme."""
        return float("nan") if self.programme is None else cost_of(self.approach, self.programme)


def made(
    scenario: Scenario, solve: Solve | None = None, callback: Callable[[Iteration], None] | None = None
) -> ApproachPlan:
    """The plan, flown. Where its flights refuse one about a draw, the cheapest other one is flown."""
    found = planned(scenario, solve, callback)
    if found.programme is None:
        return found
    first, other = _flown(found), _undrawn(found)
    if first.status is PlanStatus.VERIFIED or other is None:
        return first
    second = _flown(other)
    return second if second.status is PlanStatus.VERIFIED else first


def _undrawn(found: ApproachPlan) -> ApproachPlan | None:
    """The cheapest plan of starts that were not drawn, where the plan is about a draw."""
    safe = [each for each in found.attempts if each.found]
    others = [each for each in safe if not each.drawn]
    best = _cheapest(safe)
    if not others or not best.drawn:
        return None
    return replace(found, **_told(_cheapest(others), found.attempts))


def planned(
    scenario: Scenario, solve: Solve | None = None, callback: Callable[[Iteration], None] | None = None
) -> ApproachPlan:
    """The plan as it is solved; with `[uncertainty]` again about a larger keep-out, as long as its errors reach into it.

    Where no larger one has a plan, the last that was found is told. Its status says that nothing has verified it.
    """
    found = _planned(Approach.of(scenario), solve, callback)
    for _ in range(GROWN):
        lacking = _lacking_m(found)
        if lacking <= 0.0:
            break
        larger = replace(found.approach, errors_m=found.approach.errors_m + MORE * lacking)
        next_ = _planned(larger, solve, callback, found.programme)
        if next_.programme is None and next_.status is not PlanStatus.INTERRUPTED:
            break
        found = replace(next_, subproblems=_numbered((*found.subproblems, *next_.subproblems)))
    return found


def _lacking_m(found: ApproachPlan) -> float:
    """How far errors reach into the keep-out, m; negative where they do not, or where there are none."""
    errors, programme = found.scenario.uncertainty, found.programme
    if errors is None or programme is None:
        return -np.inf
    return -room_m(found.approach, programme, arcs(found.approach, programme), errors)


def _planned(
    approach: Approach,
    solve: Solve | None = None,
    callback: Callable[[Iteration], None] | None = None,
    known: ImpulseProgramme | None = None,
) -> ApproachPlan:
    """The plan about the keep-out as the approach has it; `known` is the plan about a smaller one."""
    scenario, used = approach.scenario, uninterrupted(solve)
    forms = Forms(approach)
    try:
        first = at_nodes(approach)
        bound, row = solve_convex(approach, forms, first.without("speed"), used)
        if row.solution.status is Status.PRIMAL_INFEASIBLE:
            return ApproachPlan(
                scenario, approach, PlanStatus.INFEASIBLE, ExitReason.SUBPROBLEM_INFEASIBLE,
                bound.why(row.solution), subproblems=(row,),
            )  # fmt: skip
        attempts, free = _attempts(approach, forms, used, callback, known)
    except KeyboardInterrupt:
        return ApproachPlan(scenario, approach, PlanStatus.INTERRUPTED, ExitReason.INTERRUPTED, "interrupted")
    solved = (row, free, *(each for attempt in attempts for each in attempt.subproblems))
    rows = _numbered(solved)
    safe = [each for each in attempts if each.found]
    if not safe:
        return _nothing(approach, attempts, rows)
    best = _cheapest(safe)
    used_forms = best.forms or forms
    try:  # with all the instants that the plan asked for
        _, row = solve_convex(
            used_forms.form.approach, used_forms, best.reference.instants.without("speed"), used
        )
    except KeyboardInterrupt:
        return ApproachPlan(scenario, approach, PlanStatus.INTERRUPTED, ExitReason.INTERRUPTED, "interrupted")
    least = row.solution.dual_objective if row.solution.status is Status.SOLVED else None
    rows = (*rows, replace(row, number=len(rows) + 1))
    return ApproachPlan(
        scenario, approach, PlanStatus.NOT_VERIFIED, attempts=attempts, lower_bound=least, subproblems=rows,
        **_told(best, attempts),
    )  # fmt: skip


def _cheapest(safe: Sequence[Attempt]) -> Attempt:
    """Of attempts that found something; what a draw saves must be more than sequences settle to."""
    return min(safe, key=lambda each: each.reference.cost * (1.0 + each.drawn * RULES.step_tol))


def _told(best: Attempt, attempts: Sequence[Attempt]) -> dict[str, Any]:
    """How the plan of an attempt ended, and its programme."""
    programme, others = best.reference.safe, len(attempts) - 1
    assert programme is not None
    dv = np.where(np.abs(programme.dv_m_s) < 1e-7, 0.0, programme.dv_m_s)
    message = f"{best.message}; first {best.side}" + (f", cheaper than {others} other ways" if others else "")
    return {
        "exit_reason": best.reason, "message": message, "programme": ImpulseProgramme(programme.times_s, dv),
    }  # fmt: skip


def _numbered(rows: tuple[Iteration, ...]) -> tuple[Iteration, ...]:
    return tuple(replace(each, number=k) for k, each in enumerate(rows, 1))


def _attempts(
    approach: Approach,
    forms: Forms,
    solve: Solve,
    callback: Callable[[Iteration], None] | None,
    known: ImpulseProgramme | None,
) -> tuple[tuple[Attempt, ...], Iteration]:
    """From the flight that knows no keep-out alone, where it is safe; otherwise from each side, and where that costs far more
    also drift by drift, if all of these settle about the drifts as they come, beside the best across the orbital plane, and about draws,
    or instead of them about a plan that is known. If nothing is found from that flight, then with a keep-out that grows, as the drifts
    come and about it on ways that turn. And the solve of that flight."""
    scenario = approach.scenario
    free, row = solve_convex(approach, forms, at_nodes(approach), solve)
    solution = row.solution
    if (
        solution.status is Status.SOLVED
        and not Search(approach).broken(free.programme(solution)).instants.keep_out
    ):
        return (attempt(approach, forms, "as it comes", None, solve, callback),), row
    found = [attempt(approach, forms, name, side, solve, callback) for name, side in sides(approach).items()]
    best = min((each.reference.cost for each in found if each.found), default=np.inf)
    near_circular = approach.circular or (scenario.model.j2 and not scenario.target.elliptic)
    if near_circular and 0.0 < approach.horizon_s < np.inf and best > WORTH_MORE * solution.objective:
        found.append(lengthened(approach, forms, solve, callback))
    settled = all(each.reason is ExitReason.CONVERGED for each in found)
    if (settled and best > WORTH_MORE * solution.objective) or not any(each.found for each in found):
        found.append(attempt(approach, forms, "as it comes", None, solve, callback))
    if approach.horizon_s < np.inf and not any(each.found for each in found):
        found.append(widened(approach, forms, "as the keep-out grows", None, solve, callback))
        if not found[-1].found:
            found += [
                widened(approach, forms, name, normals, solve, callback)
                for name, normals in turns(approach).items()
            ]
    cheapest = min((each for each in found if each.found), key=lambda each: each.reference.cost, default=None)
    dear = cheapest is not None and cheapest.reference.cost > WORTH_MORE * solution.objective
    if cheapest is not None and cheapest.reference.safe is not None and dear and not approach.held:
        found.append(beside(approach, cheapest.reference.safe, solve, callback))
        if known is not None:
            again = about(approach, "about the plan before", known, solve, callback)
            found.append(replace(again, drawn=True))
        elif approach.horizon_s < np.inf:  # for all time each look at a flight takes a branch and bound
            first = min((each for each in found if each.found), key=lambda each: each.reference.cost)
            assert first.reference.safe is not None
            found += drawn(approach, [free.programme(solution), first.reference.safe], solve, callback)
    return tuple(found), row


def _nothing(approach: Approach, attempts: tuple[Attempt, ...], rows: tuple[Iteration, ...]) -> ApproachPlan:
    last = attempts[-1]
    words = "; ".join(f"{each.side}: {each.why or each.message}" for each in attempts[:TOLD])
    if len(attempts) > TOLD:
        words += f"; and nothing from {len(attempts) - TOLD} other starts"
    failed = last.reason is ExitReason.SUBPROBLEM_FAILED
    status = PlanStatus.FAILED if failed else PlanStatus.NOT_FOUND
    if last.reason is ExitReason.INTERRUPTED:
        status = PlanStatus.INTERRUPTED
    message = f"no flight keeps every condition; {words}"
    return ApproachPlan(
        approach.scenario, approach, status, last.reason, message, attempts=attempts, subproblems=rows
    )


def judged(scenario: Scenario, programme: ImpulseProgramme) -> ApproachPlan:
    """A programme that was made elsewhere. Raises ScenarioError where an impulse lies outside the scenario's time, or thrust is held."""
    approach = Approach.of(scenario)
    if approach.held:
        allowed = "a programme of impulses cannot be judged with it; must be 'impulses'"
        raise ScenarioError(scenario.name, [Complaint("engine.thrust", "'held'", allowed)])
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
