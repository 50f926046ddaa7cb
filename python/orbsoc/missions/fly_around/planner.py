"""Plan a fly-around: pulses by the way that is asked for, with room for what J2 and drag add, and their flights."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from orbsoc.guidance.impulses import ImpulseProgramme
from orbsoc.guidance.mission import Column, PlanStatus
from orbsoc.guidance.scenario_file import Complaint, ScenarioError
from orbsoc.guidance.scp import Iteration, Solve, uninterrupted

from .model.flight import Flown, fly
from .model.waypoints import adaptive_times, equal_times, through_waypoints
from .scenario import Scenario
from .search.pulses import Search, Searcher, search
from .search.tube import Tube
from .verification import Checked, TrueFlight, check, fly_truth

COLUMNS = {
    "pulses": Column("pulses", ".0f"),
    "error_m": Column("largest error", ".4f", "m"),
    "dv_m_s": Column("Σ‖Δv‖", ".4f", "m/s"),
}
"""Columns of the iteration table that are this mission's own; an arc of a proof has its own error there."""
ROUNDS = 5
"""In which the room for J2 and drag is found; two do, as a rule."""
MORE, LEAST = 1.1, 1e-5
"""Times the excess, and of the tolerance, by which the room grows in a round."""


@dataclass(frozen=True, slots=True)
class FrontPoint:
    """The price of a number of pulses: Σ‖Δv‖ of the cheapest programme found, None where there is none."""

    pulses: int
    dv_m_s: float | None


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


@dataclass(frozen=True, slots=True, eq=False)
class Attempt:
    """A programme that leaves some room to J2 and drag, or the search that found none; and its flight with them."""

    room_m: float
    flown: Flown | None
    search: Search | None = None
    truth: TrueFlight | None = None


def made(scenario: Scenario, solve: Solve | None, callback: Callable[[Iteration], None] | None) -> FlyAround:
    """Plan the scenario; Ctrl-C is a status."""
    if scenario.impulses in ("equal", "adaptive"):
        return _through_waypoints(scenario)
    subproblems: list[Iteration] = []

    def note(iteration: Iteration) -> None:
        subproblems.append(replace(iteration, number=len(subproblems) + 1))
        if callback is not None:
            callback(subproblems[-1])

    searcher = Searcher(scenario, uninterrupted(solve), note)

    def attempt(room_m: float) -> Attempt:
        searcher.room_m = room_m
        found = search(searcher, scenario.impulses if isinstance(scenario.impulses, int) else None)
        return Attempt(room_m, found.found.flown if found.found else None, found)

    try:
        best = with_room(scenario, attempt)
        assert best.search is not None
        searcher.room_m = best.room_m
        front = _front(searcher, best.search)
    except KeyboardInterrupt:
        message = f"interrupted after {len(subproblems)} conic problems"
        return FlyAround(scenario, PlanStatus.INTERRUPTED, message, tuple(subproblems), None, None)
    if best.flown is None:
        proved = best.search.impossible >= best.search.pulses or best.search.margin_m >= scenario.tolerance_m
        status = PlanStatus.INFEASIBLE if proved else PlanStatus.FAILED
        return FlyAround(
            scenario, status, _no_plan(best.search), tuple(subproblems), None, best.search, front
        )
    tubes = sum(row.problem.p > 0 for row in subproblems)
    message = f"{len(subproblems)} conic problems: {len(subproblems) - tubes} of single arcs, {tubes} of whole flights"
    return _judged(scenario, best, message, tuple(subproblems), front)


def with_room(scenario: Scenario, attempt: Callable[[float], Attempt]) -> Attempt:
    """The first attempt whose flight with J2 and drag stays within what the scenario allows: what the flight exceeds is taken
    off the tube of the next one. Where no room is enough, the last attempt that has a programme."""
    best = attempt(0.0)
    for _ in range(ROUNDS):
        if best.flown is None:
            break
        best = replace(best, truth=fly_truth(scenario, best.flown))
        assert best.truth is not None
        excess = float(best.truth.largest_errors_m[0]) - scenario.allowed_m
        room = best.room_m + MORE * excess + LEAST * scenario.tolerance_m
        if not excess > 0.0 or room >= scenario.tolerance_m:
            break
        smaller = attempt(room)
        if smaller.flown is None:
            break
        best = smaller
    return best


def _through_waypoints(scenario: Scenario) -> FlyAround:
    """The paper's flight; it needs no conic problem."""
    flight, start, end_s = scenario.flight, scenario.start_state, scenario.duration_s
    lengths = adaptive_times if scenario.impulses == "adaptive" else equal_times

    def attempt(room_m: float) -> Attempt:
        times = lengths(flight, start[:3], end_s, scenario.tolerance_m - room_m)
        return Attempt(room_m, fly(flight, start, through_waypoints(flight, start, times), end_s))

    best = with_room(scenario, attempt)
    assert best.flown is not None
    message = f"{len(best.flown.programme)} intervals by exact arc errors; no conic problem"
    return _judged(scenario, best, message)


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
    flown = fly(scenario.flight, scenario.start_state, programme, end_s)
    message = f"{len(programme)} impulses as given; nothing was solved"
    return replace(_judged(scenario, Attempt(0.0, flown), message), audited=True)


def _judged(
    scenario: Scenario,
    found: Attempt,
    message: str,
    subproblems: tuple[Iteration, ...] = (),
    front: tuple[FrontPoint, ...] = (),
) -> FlyAround:
    """An attempt with a programme, and all its flights."""
    assert found.flown is not None
    checked = check(scenario, found.flown, found.truth)
    status = PlanStatus.NOT_VERIFIED if checked.failures else PlanStatus.VERIFIED
    return FlyAround(scenario, status, message, subproblems, checked, found.search, front)


def _front(searcher: Searcher, found: Search) -> tuple[FrontPoint, ...]:
    """The programmes with other numbers of pulses, the cheapest found; no solve for what is proved not to do."""
    points = []
    for pulses in sorted({*searcher.scenario.front} - {found.pulses}):
        tube = searcher.programme(pulses) if pulses > found.impossible else None
        good = isinstance(tube, Tube) and searcher.within(pulses, tube)
        points.append(
            FrontPoint(pulses, tube.programme.total_m_s if isinstance(tube, Tube) and good else None)
        )
    return tuple(points)


def _no_plan(found: Search) -> str:
    if found.impossible >= found.pulses:
        return f"{found.pulses} pulses cannot do: proved by {found.pulses} conic problems, one for each arc"
    return found.reason or "no programme was found"
