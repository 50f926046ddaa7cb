"""A mission as small as one can be: the smallest velocity change with a given part along an axis, one cone.

In `missions/` it would be a folder with this in its `__init__.py`, and one line in `missions/registry.py`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import Field

import orbsoc
from orbsoc.guidance.mission import Difference, FigureFile, PaperRow, PlanStatus
from orbsoc.guidance.monte_carlo import Dispersion, Spread
from orbsoc.guidance.scenario_file import BaseScenario
from orbsoc.guidance.scp import Iteration, Solve
from orbsoc.guidance.vehicle import Vector
from orbsoc.guidance.verdict import Question, Verdict, VerdictLine, Word

PAPER = ""
COLUMNS: dict[str, Any] = {}
DISPERSION = Dispersion((Spread("axis", "axis", 0.01), Spread("part", "part_m_s", 0.1)), source="assumed")
TOLERANCE = 1e-8


class Scenario(BaseScenario):
    """A velocity change dv with axis · dv = part."""

    axis: Vector
    part_m_s: float = Field(gt=0.0)


@dataclass(frozen=True, slots=True)
class Plan:
    """The velocity change, and how far its part along the axis is from what was asked."""

    scenario: Scenario
    subproblems: tuple[Iteration, ...]
    dv_m_s: np.ndarray
    verification: float

    @property
    def status(self) -> PlanStatus:
        solved = self.subproblems[0].solution.status
        if solved is orbsoc.Status.INTERRUPTED:
            return PlanStatus.INTERRUPTED
        return PlanStatus.VERIFIED if self.verification < 1e-6 else PlanStatus.FAILED

    @property
    def message(self) -> str:
        return self.subproblems[0].solution.message

    @property
    def verdict(self) -> Verdict:
        figure = f"{np.linalg.norm(self.dv_m_s):.6f} m/s"
        return Verdict((VerdictLine(Question.ANSWER, Word[self.status.name], figure),))

    def to_dict(self) -> dict[str, Any]:
        return {
            "mission": self.scenario.mission,
            "name": self.scenario.name,
            "status": self.status.value,
            "message": self.message,
            "details": "one cone, one row",
            "subproblems": [row.to_dict() for row in self.subproblems],
            "scenario": self.scenario.model_dump(mode="json"),
        }

    def tables(self) -> dict[str, str]:
        return {"impulses.csv": "dv_x_m_s,dv_y_m_s,dv_z_m_s\n" + ",".join(map(str, self.dv_m_s)) + "\n"}

    def figures(self, folder: Path) -> tuple[FigureFile, ...]:
        return ()

    def differences(self, other: Plan) -> tuple[Difference, ...]:
        apart = float(np.linalg.norm(self.dv_m_s - other.dv_m_s))
        return (Difference("dv_m_s", "velocity change", apart, 1e-4, "m/s"),)


def plan(
    scenario: Scenario, *, solve: Solve | None = None, callback: Callable[[Iteration], None] | None = None
) -> Plan:
    """One conic problem: min t, (t, dv) in the cone, axis · dv = part."""
    builder = orbsoc.ConicBuilder()
    size, dv = builder.variable("size", 1), builder.variable("dv", 3)
    builder.cost(size, [1.0])
    builder.equality([(dv, [list(scenario.axis)])], [scenario.part_m_s])
    builder.second_order([(size, -np.eye(4)[:, :1]), (dv, -np.eye(4)[:, 1:])], np.zeros(4))
    problem = builder.build()
    solution = (solve or orbsoc.solve)(problem, orbsoc.Settings(tol=TOLERANCE))
    row = Iteration(1, TOLERANCE, problem, solution)
    if callback is not None:
        callback(row)
    found = builder.value(solution, "dv")
    return Plan(scenario, (row,), found, abs(float(np.dot(scenario.axis, found)) - scenario.part_m_s))


def reproduce(scenarios: Path) -> tuple[PaperRow, ...]:
    return ()


def samples(scenarios: Path) -> dict[str, Callable[[], tuple[PaperRow, ...]]]:
    return {name: lambda name=name: drawn(name) for name in ("pushes", "pulls")}  # type: ignore[misc]


def drawn(name: str) -> tuple[PaperRow, ...]:
    """Replaced by tests."""
    return (PaperRow(name, "", "", "", "inferred", ""),)


def disperse(scenario: Scenario, number: int, seed: int = 0) -> Scenario:
    return DISPERSION.case(scenario, number, seed)
