"""A plan as `guidance.mission.Plan` has it, and the functions by which the mission is one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

import numpy as np

from orbsoc.guidance.mission import Difference, FigureFile, PaperRow
from orbsoc.guidance.samples import statistics_row
from orbsoc.guidance.scenario_file import read_toml
from orbsoc.guidance.scp import Iteration, Solve

from .paper import compare, is_papers
from .plan import LaunchPlan, made
from .record import plan_document
from .scenario import Scenario, load_scenario
from .verification.flights import messages


@dataclass(frozen=True, eq=False)
class Plan(LaunchPlan):
    """A launch and its rendezvous with their files."""

    def to_dict(self) -> dict[str, Any]:
        return plan_document(self)

    def tables(self) -> dict[str, str]:
        if self.programme is None or self.verification is None:
            return {}
        met = self.verification.corrected
        return {
            "impulses.csv": self.programme.to_csv(),
            "impulses_two_body.csv": met.programme.to_csv(),
            **messages(self.scenario, met),
        }

    def figures(self, folder: Path) -> tuple[FigureFile, ...]:
        from .figures import draw_figures

        return draw_figures(self, folder)

    def differences(self, other: Plan) -> tuple[Difference, ...]:
        """The cost, its bound, and with two impulses, whose optimum is unique, the impulses."""
        ours, theirs = self.meeting, other.meeting
        if ours is None or theirs is None:
            return ()
        found = [
            Difference("cost", "cost", abs(ours.value - theirs.value), 1e-5 * max(ours.value, 1e-3)),
            Difference(
                "bound", "bound", abs(ours.lower_bound - theirs.lower_bound), 1e-5 * max(ours.value, 1e-3)
            ),
        ]
        if ours.generated is None:
            apart = float(np.abs(ours.programme.dv_m_s - theirs.programme.dv_m_s).max())
            found.append(Difference("dv_m_s", "impulses", apart, 1e-5, "m/s"))
        return tuple(found)


def plan(
    scenario: Scenario,
    *,
    solve: Solve | None = None,
    callback: Callable[[Iteration], None] | None = None,
) -> Plan:
    """Plan the launch and the rendezvous of `scenario`; `callback` sees every conic problem as it is solved.

    `solve` is any solver with the call shape of `orbsoc.solve`, which is the default. Raises PropagationError.
    """
    found = made(scenario, solve, callback)
    return Plan(**{field.name: getattr(found, field.name) for field in fields(LaunchPlan)})


def reproduce(scenarios: Path) -> tuple[PaperRow, ...]:
    """Every scenario of a folder that has the paper's data; each row's quantity names its plan."""
    rows: list[PaperRow] = []
    for path in sorted(scenarios.glob("*.toml")):
        if read_toml(path).get("mission") != "platform_launch":
            continue
        scenario = load_scenario(path)
        if is_papers(scenario):
            rows += (
                replace(row, quantity=f"{scenario.name}: {row.quantity}") for row in compare(plan(scenario))
            )
    return tuple(rows)


def samples(scenarios: Path) -> dict[str, Callable[[], tuple[PaperRow, ...]]]:
    """The paper's plan with errors of push, pointing and impulses."""
    return {"dispersed launches": lambda: _dispersed(load_scenario(scenarios / "paper002_dispersed.toml"))}


def _dispersed(scenario: Scenario) -> tuple[PaperRow, ...]:
    found = plan(scenario).dispersed
    assert found is not None
    name, errors = scenario.name, "errors of push, pointing and impulses assumed"
    return (
        statistics_row(f"{name}: miss as planned", found.miss_m, "m", errors, mean=20.2, p95=40.6),
        statistics_row(f"{name}: cost re-planned", found.costs, "m²/s²", errors, p95=0.6423),
    )
