"""The conic problems of a workload, one a solve."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from orbsoc.conic.problem import Problem


def problems_of(workload: Path) -> list[Problem]:
    """Every problem that planning SCENARIO.toml solves, in order, or the one of PROBLEM.json. Raises what reading and planning raise."""
    if workload.suffix != ".toml":
        return [Problem.load(workload)]
    import orbsoc
    from orbsoc.missions.registry import load_scenario

    found: list[Problem] = []

    def recorded(problem: Problem, *arguments: Any, **options: Any) -> Any:
        found.append(problem)
        return orbsoc.solve(problem, *arguments, **options)

    mission, scenario = load_scenario(workload)
    mission.plan(scenario, solve=recorded)
    return found
