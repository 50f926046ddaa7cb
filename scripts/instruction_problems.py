"""The problems whose executed instructions are counted: missions' subproblems and generated families, in several sizes."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import orbsoc
from benchmarks.estimation import robust_kalman
from benchmarks.guidance import powered_descent, quadrotor, rendezvous
from benchmarks.large_cones import sum_of_norms
from benchmarks.recorded import first_insertions
from benchmarks.regression import group_lasso, huber, svm
from benchmarks.six_dof import six_dof
from benchmarks.statistics import lasso, portfolio, small_lp
from orbsoc.conic.problem import Problem
from orbsoc.missions.registry import load_scenario

SCENARIOS = Path(__file__).resolve().parent.parent / "scenarios"

Make = Callable[[int], Problem]


def _seeded(make: Callable[[int, int], Problem]) -> Make:
    return lambda size: make(size, 0)


# Family: its maker, the sizes that the law is fitted to, and those that it has not seen.
FAMILIES: dict[str, tuple[Make, tuple[int, ...], tuple[int, ...]]] = {
    "insertion": (lambda nodes: first_insertions(nodes, 1)[0], (12, 15, 24, 35, 45), (18, 30)),
    "powered_descent": (_seeded(powered_descent), (8, 15, 30, 60), (10, 20, 50)),
    "six_dof": (_seeded(six_dof), (6, 10, 25), (8, 20)),
    "rendezvous": (_seeded(rendezvous), (10, 20, 40), (15, 30, 60)),
    "rendezvous_without_cone": (
        _seeded(partial(rendezvous, approach_cone=False)),
        (10, 20, 60),
        (15, 40),
    ),
    "quadrotor": (_seeded(quadrotor), (5, 10, 30, 60), (20, 50)),
    "portfolio": (_seeded(portfolio), (30, 50, 150, 200), (40, 100)),
    "lasso": (_seeded(lasso), (10, 20, 35, 70, 100), (15, 50)),
    "huber": (_seeded(huber), (5, 15, 30), (10, 20)),
    "svm": (_seeded(svm), (5, 15, 30), (10, 20)),
    "group_lasso": (_seeded(group_lasso), (2, 3, 6, 10), (4, 8)),
    "robust_kalman": (_seeded(robust_kalman), (15, 25, 75, 100), (20, 50)),
    "one_cone": (_seeded(sum_of_norms), (61, 151, 400, 800), (100, 531)),
    "three_cones": (_seeded(partial(sum_of_norms, cones=3)), (100, 300), (151,)),
    "small_lp": (lambda rows: small_lp(16, 0, rows=rows), (100, 112, 150), (104, 128)),
}

MISSIONS = {
    "rec1": False, "paper000_1": False, "paper000_robust": False, "paper000_elliptic": False, "paper000_free": True,
    "paper001_fewest": False, "paper001_equal": True, "paper002": False, "paper003_socp": True,
    "paper003_chance": False, "paper003_timing": False,
}  # fmt: skip
"""Scenarios of which the first problem of each pattern is counted, and whether the law has not seen them."""
PATTERNS = 2


def problems() -> Iterator[tuple[str, bool, Problem]]:
    """Name, whether it is held out, and the problem."""
    for family, (make, fitted, held_out) in FAMILIES.items():
        for size in sorted(fitted + held_out):
            yield f"{family}-{size}", size in held_out, make(size)
    for scenario, held_out in MISSIONS.items():
        for k, problem in enumerate(first_patterns(SCENARIOS / f"{scenario}.toml")):
            yield f"{scenario}-{k}", held_out, problem


class _Enough(Exception):
    """The patterns wanted have been asked for."""


def first_patterns(path: Path) -> list[Problem]:
    """The first problems of a plan that differ in their sizes."""
    found: dict[tuple[int, int, int], Problem] = {}

    def solve(problem: Problem, *arguments: Any, **overrides: Any) -> Any:
        found.setdefault((problem.n, problem.p, problem.m), problem)
        if len(found) == PATTERNS:
            raise _Enough
        return orbsoc.solve(problem, *arguments, **overrides)

    mission, scenario = load_scenario(path)
    with contextlib.suppress(_Enough):
        mission.plan(scenario, solve=solve)
    return list(found.values())
