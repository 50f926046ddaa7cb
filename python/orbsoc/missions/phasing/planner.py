"""Plan a long approach: first guess by the paper's rules, shooting, descent by cones, a flight by another integrator."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from orbsoc.guidance.impulses import ImpulseProgramme
from orbsoc.guidance.mission import Column, Difference, FigureFile, PlanStatus
from orbsoc.guidance.scenario_file import Complaint, ScenarioError
from orbsoc.guidance.scp import ExitReason, Iteration, Solve

from .figures import draw_figures
from .model.approach import Approach, Roll, approach_between
from .plan import Analysis, PhasingPlan
from .record.document import plan_document
from .record.messages import messages
from .scenario import Scenario
from .search.descent import descend, spread
from .search.first_guess import Phasing, plan_phasing, shoot
from .verification.flight import fly

Array = NDArray[np.float64]

COLUMNS: Mapping[str, Column] = {
    "instants": Column("instants", ".0f"),
    "dv_m_s": Column("Σ‖Δv‖", ".4f", "m/s"),
}
"""Columns of the iteration table that are this mission's own."""


@dataclass(frozen=True, slots=True, eq=False)
class Plan(PhasingPlan):
    """A plan as `guidance.mission.Plan` has it."""

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
    scenario: Scenario,
    *,
    solve: Solve | None = None,
    callback: Callable[[Iteration], None] | None = None,
) -> Plan:
    """Plan the approach of `scenario` with `solve`, `orbsoc.solve` by default; `callback` sees every solved problem.

    What does not converge is a status with its reason. Raises `orbsoc.guidance.scenario_file.ScenarioError` where no orbit
    within the limits meets the target, or where the burns of the paper's scheme cannot.
    """
    if solve is None:
        from orbsoc.solving.solver import solve as solve_in_rust

        solve = solve_in_rust
    try:
        return _planned(scenario, solve, callback)
    except KeyboardInterrupt:
        return Plan(scenario, PlanStatus.INTERRUPTED, ExitReason.INTERRUPTED, "interrupted")


def _planned(scenario: Scenario, solve: Solve, callback: Callable[[Iteration], None] | None) -> Plan:
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
            Plan(scenario, PlanStatus.NOT_VERIFIED, ExitReason.CONVERGED, message, phasing, scheme),
            fine,
            start,
        )
    found = descend(fine, start, solve=solve, callback=callback)
    outcome, message = found.outcome, found.outcome.message
    if outcome.reason is ExitReason.INTERRUPTED:
        raise KeyboardInterrupt
    if outcome.reason is ExitReason.SUBPROBLEM_INFEASIBLE:
        message = found.last.impulses.builder.why(found.last.solution)
        return Plan(scenario, PlanStatus.INFEASIBLE, outcome.reason, message, phasing, scheme, found)
    if outcome.reason is ExitReason.SUBPROBLEM_FAILED:
        return Plan(scenario, PlanStatus.FAILED, outcome.reason, message, phasing, scheme, found)
    return _flown(
        Plan(scenario, PlanStatus.NOT_VERIFIED, outcome.reason, message, phasing, scheme, found),
        fine,
        found.roll,
    )


def _flown(planned: Plan, approach: Approach, roll: Roll) -> Plan:
    """With its flight, which makes it verified."""
    programme = approach.programme(roll)
    flight = fly(planned.scenario, programme, approach.end_s)
    good = not flight.failures and planned.exit_reason is ExitReason.CONVERGED
    status = PlanStatus.VERIFIED if good else PlanStatus.NOT_VERIFIED
    return replace(
        planned, status=status, programme=programme, verification=flight, analysis=Analysis(approach, roll)
    )


def audit(scenario: Scenario, programme: ImpulseProgramme) -> Plan:
    """A programme made elsewhere, flown to the scenario's meeting; nothing is solved. Its times are those of the scenario, its
    velocity changes in the chaser's (R, T, N). Raises ScenarioError for an impulse outside the scenario's time."""
    phasing = plan_phasing(scenario)
    for t in programme.times_s[[0, -1]]:
        if not scenario.chaser.epoch_s <= t <= phasing.end_s:
            allowed = f"must lie within chaser.epoch_s = {scenario.chaser.epoch_s:g} and the meeting at {phasing.end_s:g}"
            raise ScenarioError(scenario.name, [Complaint("impulses, time_s", f"{t:g}", allowed)])
    flight = fly(scenario, programme, phasing.end_s)
    status = PlanStatus.NOT_VERIFIED if flight.failures else PlanStatus.VERIFIED
    message = f"{len(programme)} impulses as given; nothing was solved"
    return Plan(
        scenario, status, ExitReason.CONVERGED, message, phasing, programme=programme, verification=flight
    )


def _singular(scenario: Scenario, phasing: Phasing) -> Complaint:
    turns = (phasing.end_s - phasing.phasing_s) / phasing.period_s
    allowed = (
        f"the burns do not meet the target: the phasing leg has {turns:.0f} whole revolutions, near which the meeting hardly"
        " depends on the direction of the phasing burn; must be some minutes earlier or later"
    )
    key = "window.end_s" if scenario.window.end_s is not None else "window.phasing_s"
    value = phasing.end_s if scenario.window.end_s is not None else phasing.phasing_s
    return Complaint(key, f"{value:.3f}", allowed)
