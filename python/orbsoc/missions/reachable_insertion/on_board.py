"""What a computer on board needs to plan a shortest burn by itself: constants, places of the linearised dynamics, recorded plans.

It is the sequence of convex problems from thrust along the velocity on one grid, and the flight that judges it. Finer grids, other
starts and other ignitions stay with the host.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import astuple, dataclass, fields
from math import ceil, pi, tan

import numpy as np

from orbsoc.conic.problem import Problem
from orbsoc.guidance.collocation import barycentric_weights, legendre_gauss
from orbsoc.guidance.mission import NotOnBoard
from orbsoc.guidance.powered_flight import SHORTEST
from orbsoc.guidance.scenario_file import ScenarioError
from orbsoc.guidance.scp import ExitReason, Rules, Solve
from orbsoc.orbit.array import Array

from .model.problem_data import Places, fixed_data, layout, places_of
from .scenario import Scenario
from .search.run import Attempt, Search, SearchResult, verified
from .search.setup import InsertionSetup
from .search.strategies import null_burn
from .starts.directions import steps_between
from .targets.target_orbit import TargetOrbit
from .verification import SAMPLES

CHECK_STEP = 5e-3
"""Longest step of the flight that judges a plan, canonical: by the fourth order it ends within 1e-11."""
_MOVED = np.array([180.0, -120.0, 150.0, 1.2, -0.9, 1.6])
"""By how much the second recorded state is off the scenario's, SI."""


@dataclass(frozen=True, slots=True, eq=False)
class RecordedPlan:
    """What the sequence from thrust along the velocity came to: a state (6,), SI, the exit, and the nodal thrusts (N, 3)."""

    start_si: Array
    exit: str
    subproblems: int
    duration_s: float
    controls: Array
    verified: bool


@dataclass(frozen=True, slots=True, eq=False)
class OnBoard:
    """The mission by the names that its program has: counts, numbers, lists of numbers, and places in the data of A."""

    program: str
    problem: Problem
    sizes: Mapping[str, int]
    numbers: Mapping[str, float]
    lists: Mapping[str, Array]
    places: Mapping[str, Places]
    plans: tuple[RecordedPlan, ...]


def on_board(scenario: Scenario, solve: Solve) -> OnBoard:
    """The mission of a scenario, with plans that `solve` makes of it. Raises NotOnBoard with the reason where there is none."""
    for is_wrong, key, allowed in what_it_has_not(scenario):
        if is_wrong:
            raise NotOnBoard(f"{key}: the mission in C {allowed}")
    setup = InsertionSetup.of(scenario)
    rules = Rules(max_iterations=scenario.method.max_iterations)
    if any(null_burn(Search(solve, rules), SearchResult(setup))):
        raise NotOnBoard("the scenario's state is on the target orbit: there is nothing to burn")
    first = _planned(setup, solve, rules)
    if not first.verified:
        raise NotOnBoard(
            f"thrust along the velocity on {first.nodes} nodes, the one start of the mission in C, leads to no verified plan:"
            f" {first.outcome.message}"
        )
    attempts = [(setup, first)]
    if (near := _moved(scenario, setup.start_si + _MOVED)) is not None:
        moved = InsertionSetup.of(near)
        attempts.append((moved, _planned(moved, solve, rules)))
    problem = first.outcome.iterations[0].problem
    columns, rows = layout(problem, first.nodes)
    places = places_of(problem, columns, rows, first.nodes)
    problems = [each.problem for _, attempt in attempts for each in attempt.outcome.iterations]
    return OnBoard(
        "insertion",
        problem,
        sizes=_sizes(setup, problem, columns, rows, rules),
        numbers=_numbers(setup, rules),
        lists=_lists(setup, fixed_data(problems, places, rows["longest_row"])),
        places=places,
        plans=tuple(_recorded(*each) for each in attempts if each[1].verified),
    )


def what_it_has_not(scenario: Scenario) -> Iterator[tuple[bool, str, str]]:
    """Whether the one burn from now onto an orbit that is given whole is not what is asked: the key with its value, and what there is."""
    burn, bound, free = scenario.burn, scenario.limits.attitude_rate_deg_s, list(scenario.target.free)
    plane = scenario.verification.plane_rad
    rules = (
        (scenario.problem != "min_time", f"problem = {scenario.problem!r}", "plans 'min_time' alone"),
        (burn.count != 1, f"burn.count = {burn.count}", "plans one burn"),
        (burn.ignition != "now", f"burn.ignition = {burn.ignition!r}", "ignites 'now'"),
        (bound is not None, f"limits.attitude_rate_deg_s = {bound}", "bounds no attitude rate"),
        (bool(free), f"target.free = {free}", "reaches orbits that are given whole"),
        (plane >= 0.5 * pi, f"verification.plane_rad = {plane:g}", "allows less than a right angle"),
    )
    yield from rules


def _moved(scenario: Scenario, start_si: Array) -> Scenario | None:
    """The scenario from another state in the axes of plans; None where its own is given otherwise, or where that state cannot be."""
    if scenario.initial.by_elements or (
        scenario.axes != "launch_inertial" and scenario.launch_site is not None
    ):
        return None
    vectors = {"position_m": start_si[:3].tolist(), "velocity_m_s": start_si[3:].tolist()}
    try:
        return scenario.with_changes(initial=vectors)
    except ScenarioError:
        return None


def _planned(setup: InsertionSetup, solve: Solve, rules: Rules) -> Attempt:
    attempt = Search(solve, rules).sequence(setup, setup.cold_start(), "cold start")
    if attempt.outcome.reason is ExitReason.INTERRUPTED:
        raise KeyboardInterrupt
    return verified(setup, attempt)


def _recorded(setup: InsertionSetup, attempt: Attempt) -> RecordedPlan:
    arc, outcome = attempt.trajectory, attempt.outcome
    duration_s = arc.duration * setup.units.time_s
    count = len(outcome.iterations)
    return RecordedPlan(
        setup.start_si, outcome.reason.name, count, duration_s, arc.controls, attempt.verified
    )


def _sizes(
    setup: InsertionSetup, problem: Problem, columns: Mapping[str, int], rows: Mapping[str, int], rules: Rules
) -> dict[str, int]:
    guess_steps, check_steps = sizes_of_flights(setup)
    counts = {
        "nodes": setup.scenario.method.nodes, "entries_a": problem.A.nnz, "entries_g": problem.G.nnz, "variables": problem.n,
        "equality_rows": problem.p, "cone_rows": problem.m, "max_subproblems": rules.max_iterations,
        "guess_steps": guess_steps, "check_samples": SAMPLES - 1, "check_steps": check_steps,
    }  # fmt: skip
    return counts | {name: at for name, at in columns.items() if name != "states"} | dict(rows)


def sizes_of_flights(setup: InsertionSetup) -> tuple[int, int]:
    """Steps of the first guess between two nodes, and of the judging flight between two samples."""
    grid = legendre_gauss(setup.scenario.method.nodes)
    guess_steps = steps_between(grid, setup.scenario.burn.guess_s / setup.units.time_s)
    return guess_steps, ceil(setup.burn.longest / (SAMPLES - 1) / CHECK_STEP)


def _numbers(setup: InsertionSetup, rules: Rules) -> dict[str, float]:
    burn, units, scenario = setup.burn, setup.units, setup.scenario
    assert isinstance(setup.target, TargetOrbit)  # no element is free
    limits = scenario.verification
    found = {
        "length_m": units.length_m, "speed_m_s": units.speed_m_s, "time_s": units.time_s,
        "acceleration": burn.acceleration, "flow": burn.flow, "longest": burn.longest,
        "guess": scenario.burn.guess_s / units.time_s, "shortest": SHORTEST,
        "slack_weight": scenario.method.slack_weight,
        "target.momentum": setup.target.momentum, "target.eccentricity": setup.target.eccentricity,
        "limits.momentum_rel": limits.angular_momentum_rel, "limits.laplace": limits.laplace_rel,
        "limits.plane_slope": tan(limits.plane_rad), "limits.thrust_excess": limits.thrust_excess,
    }  # fmt: skip
    ruled = zip((each.name for each in fields(rules)), astuple(rules), strict=True)
    return found | {f"rules.{name}": float(value) for name, value in ruled if name != "max_iterations"}


def _lists(setup: InsertionSetup, fixed: Mapping[str, Array]) -> dict[str, Array]:
    grid = legendre_gauss(setup.scenario.method.nodes)
    assert isinstance(setup.target, TargetOrbit)
    found = {
        f"target.{name}": np.asarray(getattr(setup.target, name)) for name in ("normal", "perigee", "ahead")
    }
    found |= {
        "grid.node": grid.nodes, "grid.weight": grid.weights,
        "grid.from_start": grid.differentiation[:, 0], "grid.barycentric": barycentric_weights(grid.nodes),
    }  # fmt: skip
    return found | {f"fixed.{name}": values for name, values in fixed.items()}
