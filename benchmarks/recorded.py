"""Mission 004's own subproblems, recorded while the mission is planned."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import orbsoc
from orbsoc.conic.problem import Problem
from orbsoc.conic.settings import Settings
from orbsoc.conic.solution import Solution
from orbsoc.missions.reachable_insertion import load_scenario, plan
from orbsoc.missions.reachable_insertion.scenario import ProblemName, Scenario

SCENARIOS = Path(__file__).resolve().parents[1] / "scenarios"
NAMES = ("rec1", "rec2", "paper004_insertion", "paper004_insertion_zf196")
PROBLEMS: tuple[tuple[ProblemName, str], ...] = (("min_time", "A"), ("max_energy", "B"))


def mission004() -> Iterator[tuple[str, str, Problem]]:
    """Name, group and problem of every subproblem of problems A and B on all four scenarios, in order.

    The sequence is planned by `orbsoc.solve`; whatever solver one plans with, its subproblems differ by no more
    than the tolerance of the subproblems before.
    """
    for scenario_name in NAMES:
        scenario = load_scenario(SCENARIOS / f"{scenario_name}.toml")
        for problem_name, letter in PROBLEMS:
            recorder = _Recorder()
            plan(scenario, solve=recorder, problem=problem_name)
            for k, problem in enumerate(recorder.problems):
                nodes = len(problem.cones.q)  # one cone ‖u‖ ≤ 1 at each
                yield f"{scenario_name}-{letter}-{k}", f"{letter}, N = {nodes}", problem


def insertion(nodes: int, count: int) -> Iterator[tuple[str, str, Problem]]:
    """Name, group and problem of the first `count` subproblems on `nodes` nodes, of problems A and B of rec1."""
    scenario = _rec1(nodes)
    for problem_name, letter in PROBLEMS:
        recorder = _Recorder()
        plan(scenario, solve=recorder, problem=problem_name)
        same = [problem for problem in recorder.problems if len(problem.cones.q) == nodes]
        for k, problem in enumerate(same[:count]):
            yield f"insertion {letter}-{nodes}-{k}", f"insertion {letter}, {nodes} nodes", problem


def first_insertions(nodes: int, count: int) -> list[Problem]:
    """The first subproblem of problem A of rec1 from `count` places: up to 500 m and 5 m/s off, axis by axis."""
    random = np.random.default_rng(nodes)
    scenario = _rec1(nodes)
    return [_first_problem(scenario, random.uniform(-1.0, 1.0, (2, 3))) for _ in range(count)]


def _rec1(nodes: int) -> Scenario:
    """Rec1 on this many nodes or more."""
    scenario = load_scenario(SCENARIOS / "rec1.toml")
    most = max(nodes, scenario.method.max_nodes)
    return scenario.with_changes(method={"nodes": nodes, "max_nodes": most})


def _first_problem(scenario: Scenario, shift: NDArray[np.float64]) -> Problem:
    place, motion = shift * np.array([[500.0], [5.0]])
    initial = scenario.initial
    moved = initial.model_copy(
        update={
            "position_m": tuple(np.asarray(initial.position_m) + place),
            "velocity_m_s": tuple(np.asarray(initial.velocity_m_s) + motion),
        }
    )
    asked = _FirstAsked()
    with contextlib.suppress(_Enough):
        plan(scenario.model_copy(update={"initial": moved}), solve=asked, problem="min_time")
    return asked.problem


class _Enough(Exception):
    """The problem wanted has been asked for."""


class _FirstAsked:
    """Takes the place of a solver, keeps the first problem and ends the plan."""

    problem: Problem

    def __call__(self, problem: Problem, settings: Settings | None = None, /, **overrides: Any) -> Solution:
        self.problem = problem
        raise _Enough


class _Recorder:
    """`orbsoc.solve`, remembering what it was asked."""

    def __init__(self) -> None:
        self.problems: list[Problem] = []

    def __call__(self, problem: Problem, settings: Settings | None = None, /, **overrides: Any) -> Solution:
        self.problems.append(problem)
        return orbsoc.solve(problem, settings, **overrides)
