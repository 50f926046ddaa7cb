"""Plan a long approach: first guess by the paper's rules, shooting, descent by cones, a flight by another integrator."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import sqrt

from orbsoc.guidance.claims import Claim, Kind
from orbsoc.guidance.impulses import Generated, ImpulseProgramme
from orbsoc.guidance.mission import Column, PlanStatus
from orbsoc.guidance.scenario_file import Complaint, ScenarioError
from orbsoc.guidance.scp import ExitReason, Iteration, Solve, solver
from orbsoc.orbit import PropagationError

from .dispersion.replanning import Surprised, surprise
from .model.approach import Approach, Roll, approach_between, departing
from .model.uncertain import Chance, Meeting, meeting
from .scenario import Scenario
from .search.descent import PROVED, Descended, descend, spread
from .search.drift import DriftSearch, Transfer
from .search.first_guess import Phasing, plan_phasing, shoot
from .search.refine import refine
from .verification.finite import FiniteBurns, finite_burns
from .verification.flight import Flight, fly

COLUMNS: Mapping[str, Column] = {
    "instants": Column("instants", ".0f"),
    "dv_m_s": Column("Σ‖Δv‖", ".4f", "m/s"),
}
"""Columns of the iteration table that are this mission's own."""
FAR_M = 1e3
"""By which burns may miss after two corrections and still stand for the impulses; more corrections would bring them nearer."""
MET = 1.0 + 1e-4
"""Of the standard deviation that a chance allows: up to where it counts as met."""
SHORT = 1.0 / 12.0
"""Of the period: where shorter burns cannot be corrected, that is for the flight's sensitivity, and says nothing of the engine."""


@dataclass(frozen=True, slots=True)
class FrontPoint:
    """What another number of revolutions costs: by the scheme of four burns in the true motion, and the least; None without."""

    revolutions: int
    duration_h: float | None
    scheme_m_s: float | None
    least_m_s: float | None


class Analysis:
    """What a report tells of a flight and the plan does not depend on, computed when it is first asked for, with
    `orbsoc.solve`, whatever solved the plan."""

    def __init__(self, approach: Approach, roll: Roll) -> None:
        self.approach, self.roll = approach, roll

    @cached_property
    def finite(self) -> FiniteBurns | None:
        """None without an engine, and where burns of this one are too long to stand for the impulses."""
        engine = self.approach.scenario.engine
        try:
            return None if engine is None else finite_burns(self.approach, self.roll, engine)
        except (PropagationError, ValueError):
            return None

    @property
    def too_weak(self) -> bool:
        """Whether the engine cannot stand in for the impulses: its burns overlap, or miss however they are corrected."""
        found = self.finite
        if found is None:
            return self.approach.scenario.engine is not None
        period_s = self.approach.scenario.chaser.elements.period_s()
        return found.miss_m > FAR_M and not (found.diverged and found.longest_s < SHORT * period_s)

    @property
    def missed(self) -> bool:
        """Whether the chance asked for is not met: by linear covariance, or by draws, by more than two sigmas of drawing."""
        errors, chance = self.approach.scenario.uncertainty, Chance.of(self.approach)
        if chance is not None and chance.sigma_m(self.approach, self.roll) > MET * chance.limit_m:
            return True
        if errors is None or errors.probability is None or not errors.runs:
            return False
        found = self.meeting
        assert found is not None
        sigma = sqrt(errors.probability * (1.0 - errors.probability) / errors.runs)
        return found.within < errors.probability - 2.0 * sigma

    @cached_property
    def surprised(self) -> Surprised | None:
        return None if self.approach.scenario.surprise is None else surprise(self.approach, self.roll)

    @cached_property
    def meeting(self) -> Meeting | None:
        errors = self.approach.scenario.uncertainty
        return None if errors is None else meeting(self.approach, self.roll, errors)

    @cached_property
    def front(self) -> tuple[FrontPoint, ...]:
        from orbsoc.solving.solver import solve

        return tuple(
            _front_point(self.approach.scenario, n, solve) for n in self.approach.scenario.window.front
        )


@dataclass(frozen=True, slots=True, eq=False)
class PhasingPlan:
    """How planning ended; `Plan` adds the files. `scheme` is the flight of the paper's burns, `descended` what came of it; None where there is none."""

    scenario: Scenario
    status: PlanStatus
    exit_reason: ExitReason
    message: str
    phasing: Phasing | Transfer | None = None
    scheme: Roll | None = None
    descended: Descended | None = None
    programme: ImpulseProgramme | None = None
    verification: Flight | None = None
    analysis: Analysis | None = field(default=None, repr=False)
    forbidden: Claim | None = None
    """Why no plan exists, where that is proved."""

    @property
    def hours(self) -> float:
        """From the first burn that the window allows to the meeting; NaN without a guess."""
        return float("nan") if self.phasing is None else (self.phasing.end_s - self.phasing.start_s) / 3600.0

    @property
    def bounded(self) -> Generated | None:
        """The last problem's rounds, whose bound is of this plan; None without, and where it is not about the plan: a chance
        that is missed costs more than the plan does."""
        last = self.descended and self.descended.last
        if not last or not last.rounds or self.programme is None:
            return None
        return last if last.rounds[-1].cost <= (1.0 + PROVED) * self.programme.total_m_s else None

    @property
    def subproblems(self) -> tuple[Iteration, ...]:
        return self.descended.outcome.iterations if self.descended else ()


def made(
    scenario: Scenario, solve: Solve | None, callback: Callable[[Iteration], None] | None
) -> PhasingPlan:
    """Plan the scenario; Ctrl-C is a status."""
    try:
        return _planned(scenario, solver(solve), callback)
    except KeyboardInterrupt:
        return PhasingPlan(scenario, PlanStatus.INTERRUPTED, ExitReason.INTERRUPTED, "interrupted")


def _planned(scenario: Scenario, solve: Solve, callback: Callable[[Iteration], None] | None) -> PhasingPlan:
    if scenario.window.revolutions is None:
        return _looked_for(scenario, solve, callback)
    phasing = plan_phasing(scenario)
    by_paper = scenario.scheme == "paper"
    approach, scheme = shoot(scenario, phasing, trim=not by_paper)
    if scheme is None:
        raise ScenarioError(scenario.name, [_singular(scenario, phasing)])
    fine = approach_between(scenario, phasing.start_s, phasing.end_s, approach.times_s)
    start = spread(fine, scheme, approach.times_s)
    if start is None:
        raise ScenarioError(scenario.name, [_singular(scenario, phasing)])
    if by_paper:
        message = f"{len(approach.times_s)} burns by shooting; no conic problem"
        return _flown(
            PhasingPlan(scenario, PlanStatus.NOT_VERIFIED, ExitReason.CONVERGED, message, phasing, scheme),
            fine,
            start,
        )
    forbidden = _forbidden(fine)
    if forbidden is not None:
        reason = ExitReason.SUBPROBLEM_INFEASIBLE
        return PhasingPlan(
            scenario, PlanStatus.INFEASIBLE, reason, forbidden.claim, phasing, scheme, forbidden=forbidden
        )
    return _concluded(scenario, phasing, scheme, descend(fine, start, solve=solve, callback=callback))


def _looked_for(
    scenario: Scenario, solve: Solve, callback: Callable[[Iteration], None] | None
) -> PhasingPlan:
    """By a search over revolutions and dates in mean elements, then in the true motion from the best of it."""
    transfer = None
    for transfer in DriftSearch(scenario, solve).find():
        departed = departing(scenario, transfer.start_s, transfer.end_s)
        found = refine(departed, transfer, solve=solve, callback=callback)
        if found is not None:
            return _concluded(scenario, transfer, None, found)
    what = "in mean elements" if transfer is None else "near the best in mean elements"
    message = f"no flight that meets the target was found {what}"
    return PhasingPlan(scenario, PlanStatus.NOT_FOUND, ExitReason.MAX_ITERATIONS, message, transfer)


def _concluded(
    scenario: Scenario, phasing: Phasing | Transfer | None, scheme: Roll | None, found: Descended
) -> PhasingPlan:
    """What a descent comes to."""
    outcome = found.outcome
    planned = PhasingPlan(
        scenario, PlanStatus.NOT_FOUND, outcome.reason, outcome.message, phasing, scheme, found
    )
    if outcome.reason is ExitReason.INTERRUPTED:
        raise KeyboardInterrupt
    if outcome.reason is ExitReason.SUBPROBLEM_INFEASIBLE:  # about one flight: that proves nothing of others
        why = found.last.impulses.builder.why(found.last.solution)
        return replace(planned, message=f"flights tried: {found.flights}; {why}")
    if outcome.reason is ExitReason.SUBPROBLEM_FAILED:
        return replace(planned, status=PlanStatus.FAILED)
    return _flown(planned, found.approach, found.roll)


def _forbidden(approach: Approach) -> Claim | None:
    """That the target's own errors forbid the chance that is asked for, whatever the chaser does."""
    chance = Chance.of(approach)
    if chance is None or chance.fixed_m <= chance.limit_m:
        return None
    alone, allowed = chance.fixed_m / 1e3, chance.limit_m / 1e3
    return Claim(
        Kind.PROVED,
        f"chance of the meeting: σ of the target alone is {alone:.1f} km, {allowed:.1f} km allowed",
        f"every programme of impulses that meets at {approach.end_s:.0f} s",
        "linear covariance of the target alone, which no impulse changes",
        chance.fixed_m / chance.limit_m - 1.0,
    )


def _flown(planned: PhasingPlan, approach: Approach, roll: Roll) -> PhasingPlan:
    """With its flight, which makes it verified where the engine can fly it and the chance that was asked for is met; how
    near to the optimum it is does not count."""
    programme = approach.programme(roll)
    flight, analysis = fly(approach.scenario, programme, approach.end_s), Analysis(approach, roll)
    good = not flight.failures and not analysis.too_weak and not analysis.missed
    status = PlanStatus.VERIFIED if good else PlanStatus.NOT_VERIFIED
    return replace(planned, status=status, programme=programme, verification=flight, analysis=analysis)


def judged(scenario: Scenario, programme: ImpulseProgramme) -> PhasingPlan:
    """A programme made elsewhere, flown to the scenario's meeting; nothing is solved. Its times are those of the scenario, its
    velocity changes in the chaser's (R, T, N). Raises ScenarioError for an impulse outside the scenario's time."""
    window = scenario.window
    if window.revolutions is None and window.start_s is not None and window.end_s is not None:
        departed, end_s, phasing = departing(scenario, window.start_s, window.end_s), window.end_s, None
    else:
        phasing = plan_phasing(scenario)
        departed, end_s = scenario, phasing.end_s
    for t in programme.times_s[[0, -1]]:
        if not departed.chaser.epoch_s <= t <= end_s:
            allowed = (
                f"must lie within chaser.epoch_s = {departed.chaser.epoch_s:g} and the meeting at {end_s:g}"
            )
            raise ScenarioError(scenario.name, [Complaint("impulses, time_s", f"{t:g}", allowed)])
    flight = fly(departed, programme, end_s)
    status = PlanStatus.NOT_VERIFIED if flight.failures else PlanStatus.VERIFIED
    message = f"{len(programme)} impulses as given; nothing was solved"
    return PhasingPlan(
        scenario, status, ExitReason.CONVERGED, message, phasing, programme=programme, verification=flight
    )


def _front_point(scenario: Scenario, revolutions: int, solve: Solve) -> FrontPoint:
    """From the same first burn, to the meeting that this number of revolutions has."""
    window = {"end_s": None, "phasing_s": None, "revolutions": revolutions, "front": ()}
    other = scenario.with_changes(window=window, uncertainty=None)
    try:
        phasing = plan_phasing(other)
    except ScenarioError:
        return FrontPoint(revolutions, None, None, None)
    hours = (phasing.end_s - phasing.start_s) / 3600.0
    approach, scheme = shoot(other, phasing)
    if scheme is None:
        return FrontPoint(revolutions, hours, None, None)
    fine = approach_between(other, phasing.start_s, phasing.end_s, approach.times_s)
    start = spread(fine, scheme, approach.times_s)
    found = None if start is None else descend(fine, start, solve=solve)
    good = found is not None and found.outcome.reason is ExitReason.CONVERGED
    return FrontPoint(revolutions, hours, scheme.cost_m_s, found.roll.cost_m_s if found and good else None)


def _singular(scenario: Scenario, phasing: Phasing) -> Complaint:
    turns = (phasing.end_s - phasing.phasing_s) / phasing.period_s
    allowed = (
        f"the burns do not meet the target: the phasing leg has {turns:.0f} whole revolutions, near which the meeting hardly"
        " depends on the direction of the phasing burn; must be some minutes earlier or later"
    )
    key = "window.end_s" if scenario.window.end_s is not None else "window.phasing_s"
    value = phasing.end_s if scenario.window.end_s is not None else phasing.phasing_s
    return Complaint(key, f"{value:.3f}", allowed)
