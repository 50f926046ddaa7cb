"""Plan a fly-around: pulses by the way that is asked for, their flight by the model and by the truth, and what follows."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from orbsoc.conic.problem import Problem
from orbsoc.conic.settings import Settings
from orbsoc.conic.solution import Solution, Status
from orbsoc.guidance.impulses import ImpulseProgramme
from orbsoc.guidance.mission import Column, PlanStatus
from orbsoc.guidance.safety import CutBurn
from orbsoc.guidance.scenario_file import Complaint, ScenarioError
from orbsoc.guidance.scp import Iteration, Solve

from .audits import EngineOut, cut_burns, engine_out
from .model.flight import Flown, fly
from .model.waypoints import adaptive_times, equal_times, through_waypoints
from .scenario import Scenario
from .search.pulses import Search, Searcher, search
from .search.tube import Tube
from .verification import TrueFlight, fly_truth

Array = NDArray[np.float64]

COLUMNS = {
    "pulses": Column("pulses", ".0f"),
    "error_m": Column("largest error", ".4f", "m"),
    "dv_m_s": Column("Σ‖Δv‖", ".4f", "m/s"),
}
"""Columns of the iteration table that are this mission's own; an arc of a proof has its own error there."""


@dataclass(frozen=True, slots=True)
class FrontPoint:
    """The price of a number of pulses: Σ‖Δv‖ of the cheapest programme found, None where there is none."""

    pulses: int
    dv_m_s: float | None


@dataclass(frozen=True, slots=True, eq=False)
class Checked:
    """A programme and its flights: by the model, by the truth once, by the truth in the open loop, and dispersed."""

    flown: Flown
    truth: TrueFlight
    open_loop: TrueFlight
    dispersed: TrueFlight | None
    engine_out: tuple[EngineOut, ...]
    cut_burns: tuple[CutBurn, ...]
    failures: tuple[str, ...]

    @property
    def programme(self) -> ImpulseProgramme:
        return self.flown.programme


@dataclass(frozen=True, slots=True, eq=False)
class FlyAround:
    """What planning found; `Plan` adds the files. `search` is None for the ways of the paper."""

    scenario: Scenario
    status: PlanStatus
    message: str
    subproblems: tuple[Iteration, ...] = field(repr=False)
    verification: Checked | None
    search: Search | None
    front: tuple[FrontPoint, ...] = ()
    audited: bool = False
    """A programme made elsewhere."""


def made(scenario: Scenario, solve: Solve | None, callback: Callable[[Iteration], None] | None) -> FlyAround:
    """Plan the scenario; Ctrl-C is a status."""
    if solve is None:
        from orbsoc.solving.solver import solve as solve_in_rust

        solve = solve_in_rust
    subproblems: list[Iteration] = []

    def uninterrupted(problem: Problem, settings: Settings | None = None) -> Solution:
        solution = solve(problem, settings)
        if solution.status is Status.INTERRUPTED:
            raise KeyboardInterrupt
        return solution

    def note(iteration: Iteration) -> None:
        subproblems.append(replace(iteration, number=len(subproblems) + 1))
        if callback is not None:
            callback(subproblems[-1])

    try:
        if scenario.impulses in ("equal", "adaptive"):
            return _through_waypoints(scenario)
        pulses = scenario.impulses if isinstance(scenario.impulses, int) else None
        found = search(scenario, pulses, solve=uninterrupted, note=note)
        front = _front(scenario, found, uninterrupted, note)
    except KeyboardInterrupt:
        message = f"interrupted after {len(subproblems)} conic problems"
        return FlyAround(scenario, PlanStatus.INTERRUPTED, message, tuple(subproblems), None, None)
    if found.found is None:
        proved = found.impossible >= found.pulses or found.margin_m >= scenario.tolerance_m
        status = PlanStatus.INFEASIBLE if proved else PlanStatus.FAILED
        return FlyAround(scenario, status, _no_plan(found), tuple(subproblems), None, found, front)
    checked = check(scenario, found.found.flown)
    tubes = sum(row.problem.p > 0 for row in subproblems)
    message = f"{len(subproblems)} conic problems: {len(subproblems) - tubes} of single arcs, {tubes} of whole flights"
    return FlyAround(scenario, _status(checked), message, tuple(subproblems), checked, found, front)


def _through_waypoints(scenario: Scenario) -> FlyAround:
    """The paper's flight; it needs no conic problem."""
    flight, start, end_s = scenario.flight, scenario.start_state, scenario.duration_s
    lengths = adaptive_times if scenario.impulses == "adaptive" else equal_times
    times = lengths(flight, start[:3], end_s, scenario.tolerance_m)
    programme = through_waypoints(flight, start, times)
    checked = check(scenario, fly(flight, start, programme, end_s))
    message = f"{len(programme)} intervals by exact arc errors; no conic problem"
    return FlyAround(scenario, _status(checked), message, (), checked, None)


def judged(scenario: Scenario, programme: ImpulseProgramme) -> FlyAround:
    """A programme made elsewhere, flown and judged as a plan is. Raises ScenarioError for impulses outside the revolution."""
    end_s = scenario.duration_s
    outside = [t for t in programme.times_s.tolist() if not 0.0 <= t < end_s]
    if outside:
        allowed = f"must be from 0 to below ellipse.period_s = {end_s:g}"
        raise ScenarioError(scenario.name, [Complaint("impulses: time_s", f"{outside[0]:g}", allowed)])
    if programme.times_s[0] > 0.0:  # the coast before it
        times, dv = np.append(0.0, programme.times_s), np.vstack([np.zeros(3), programme.dv_m_s])
        programme = ImpulseProgramme(times, dv)
    checked = check(scenario, fly(scenario.flight, scenario.start_state, programme, end_s))
    message = f"{len(programme)} impulses as given; nothing was solved"
    return FlyAround(scenario, _status(checked), message, (), checked, None, audited=True)


def check(scenario: Scenario, flown: Flown) -> Checked:
    """Fly a programme by an integrator that planning does not use, and look at what may go wrong."""
    truth = fly_truth(scenario, flown)
    error, allowed = float(truth.largest_errors_m[0]), scenario.allowed_m
    failures = []
    if flown.largest_error_m > scenario.tolerance_m + 1e-3:
        failures.append(
            f"by the linear model it strays {flown.largest_error_m:.4f} m; tolerance_m = {scenario.tolerance_m:g}"
        )
    if not error <= allowed:
        failures.append(
            f"with J2 and drag it strays {error:.4f} m, and truth.excess_share allows {allowed:.4f} m; lower tolerance_m"
            " by the difference, or allow more"
        )
    dispersed = None
    if scenario.uncertainty is not None and scenario.uncertainty.runs:
        dispersed = fly_truth(
            scenario, flown, uncertainty=scenario.uncertainty, runs=scenario.uncertainty.runs, samples=16
        )
    return Checked(
        flown,
        truth,
        fly_truth(scenario, flown, aiming=False),
        dispersed,
        engine_out(scenario, flown),
        cut_burns(scenario, flown),
        tuple(failures),
    )


def _front(
    scenario: Scenario, found: Search, solve: Solve, note: Callable[[Iteration], None]
) -> tuple[FrontPoint, ...]:
    """The programmes with other numbers of pulses, the cheapest found; no solve for what is proved not to do."""
    searcher = Searcher(scenario, solve, note)
    searcher.bounds.update({bound.pulses: bound for bound in found.bounds})
    points = []
    for pulses in sorted({*scenario.front} - {found.pulses}):
        tube = searcher.programme(pulses) if pulses > found.impossible else None
        good = isinstance(tube, Tube) and searcher.within(pulses, tube)
        cost = tube.programme.total_m_s if isinstance(tube, Tube) and good else None
        points.append(FrontPoint(pulses, cost))
    return tuple(points)


def _status(checked: Checked) -> PlanStatus:
    return PlanStatus.NOT_VERIFIED if checked.failures else PlanStatus.VERIFIED


def _no_plan(found: Search) -> str:
    if found.impossible >= found.pulses:
        return f"{found.pulses} pulses cannot do: proved by {found.pulses} conic problems, one for each arc"
    return found.reason or "no programme was found"
