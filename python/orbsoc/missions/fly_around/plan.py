"""A plan as `guidance.mission.Plan` has it, and the functions by which the mission is one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from orbsoc.guidance.impulses import ImpulseProgramme
from orbsoc.guidance.mission import Difference, FigureFile, PaperRow
from orbsoc.guidance.samples import share_row, statistics_row
from orbsoc.guidance.scenario_file import read_toml
from orbsoc.guidance.scp import Iteration, Solve

from .paper import compare, is_papers
from .planner import FlyAround, judged, made
from .record import plan_document
from .scenario import Scenario, load_scenario
from .verification import fly_truth, messages

DRAWN = {
    "paper001_adaptive": (2.28, 2.49, 1.0),
    "paper001_equal": (2.19, 2.52, 0.96),
    "paper001_fewest": (2.72, 3.08, 1.0),
}
"""By scenario: mean and 95th percentile of the largest error (m), and the share of flights beyond the tolerance, of another
program's 100 flights with the errors of `paper001_margin`."""


@dataclass(frozen=True, slots=True, eq=False)
class Plan(FlyAround):
    """A fly-around with its files."""

    def to_dict(self) -> dict[str, Any]:
        return plan_document(self)

    def tables(self) -> dict[str, str]:
        found = self.verification
        if found is None:
            return {}
        table = {"impulses.csv": found.programme.to_csv()}
        return table | messages(self.scenario, found.flown, found.truth)

    def figures(self, folder: Path) -> tuple[FigureFile, ...]:
        from .figures import draw_figures

        return draw_figures(self, folder)

    def differences(self, other: Plan) -> tuple[Difference, ...]:
        """Pulses, Σ‖Δv‖, and every bound of the proofs, the arcs' too."""
        found: list[Difference] = []
        if self.verification is not None and other.verification is not None:
            ours, theirs = self.verification, other.verification
            found = [
                Difference(
                    "pulses", "number of pulses", abs(len(ours.programme) - len(theirs.programme)), 0.0
                ),
                Difference(
                    "delta_v_m_s",
                    "velocity change",
                    abs(ours.programme.total_m_s - theirs.programme.total_m_s),
                    1e-4,
                    "m/s",
                ),
                Difference(
                    "largest_error_m",
                    "largest error",
                    abs(ours.flown.largest_error_m - theirs.flown.largest_error_m),
                    1e-4,
                    "m",
                ),
            ]
        if self.search is not None and other.search is not None and self.search.bounds:
            apart = [
                abs(arc.bound_m - again.bound_m)
                for bound, check in zip(self.search.bounds, other.search.bounds, strict=False)
                for arc, again in zip(bound.arcs, check.arcs, strict=False)
            ]
            same = [b.pulses for b in self.search.bounds] == [b.pulses for b in other.search.bounds]
            worst = float(np.max(apart)) if same else float("inf")
            found.append(Difference("bound_m", "error bound of an arc", worst, 1e-4, "m"))
        return tuple(found)


def plan(
    scenario: Scenario,
    *,
    solve: Solve | None = None,
    callback: Callable[[Iteration], None] | None = None,
) -> Plan:
    """Plan the fly-around of `scenario`; `callback` sees every conic problem as it is solved.

    `solve` is any solver with the call shape of `orbsoc.solve`, which is the default.
    """
    return _with_files(made(scenario, solve, callback))


def audit(scenario: Scenario, programme: ImpulseProgramme) -> Plan:
    """A programme of impulses made elsewhere, judged as the scenario's own plan would be; nothing is solved.

    Raises ScenarioError where it has impulses outside the revolution.
    """
    return _with_files(judged(scenario, programme))


def _with_files(found: FlyAround) -> Plan:
    return Plan(**{field.name: getattr(found, field.name) for field in fields(FlyAround)})


def reproduce(scenarios: Path) -> tuple[PaperRow, ...]:
    """Every scenario in a folder that has the paper's data; each row's quantity names its plan."""
    rows: list[PaperRow] = []
    for path in sorted(scenarios.glob("*.toml")):
        if read_toml(path).get("mission") != "fly_around":
            continue
        scenario = load_scenario(path)
        if is_papers(scenario) and not scenario.front:
            rows += (
                replace(row, quantity=f"{scenario.name}: {row.quantity}") for row in compare(plan(scenario))
            )
    return tuple(rows)


def samples(scenarios: Path) -> dict[str, Callable[[], tuple[PaperRow, ...]]]:
    """The plans that leave no margin, flown with the errors of `paper001_margin`."""
    return {f"{name}, flown with errors": partial(_drawn, scenarios, name) for name in DRAWN}


def _drawn(scenarios: Path, name: str) -> tuple[PaperRow, ...]:
    scenario = load_scenario(scenarios / f"{name}.toml")
    errors = load_scenario(scenarios / "paper001_margin.toml").uncertainty
    found = plan(scenario).verification
    assert errors is not None
    assert found is not None
    largest = fly_truth(
        scenario, found.flown, uncertainty=errors, runs=errors.runs, samples=16
    ).largest_errors_m
    mean, p95, beyond = DRAWN[name]
    beside, count = "errors of navigation and pulses assumed", int(np.sum(largest > scenario.tolerance_m))
    return (
        statistics_row(f"{name}: largest error", largest, "m", beside, mean=mean, p95=p95),
        share_row(f"{name}: beyond the tolerance", count, errors.runs, beyond, beside),
    )
