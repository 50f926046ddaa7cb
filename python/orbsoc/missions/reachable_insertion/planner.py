"""Plan an insertion: when to ignite, the search for the burn, and what its result is worth."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from orbsoc.guidance.figure_style import image_element
from orbsoc.guidance.mission import Column, Difference, FigureFile, PaperRow
from orbsoc.guidance.scenario_file import read_toml
from orbsoc.guidance.scp import Iteration, Rules, Solve
from orbsoc.guidance.verdict import Verdict

from .figures.orbit import orbit_figure
from .figures.panels import draw_figures
from .paper import compare
from .plan.burn_plan import BurnPlan
from .plan.comparison import differences
from .plan.verdict import verdict_of
from .plan.verdicts import shape_of
from .record.document import attitude_csv, plan_document
from .record.messages import FlownBurn, first_coast, messages
from .scenario import ProblemName, Scenario, load_scenario
from .search.bounded import BoundedSearch
from .search.found import Found
from .search.ignition import LaterIgnition, best_ignition, later_ignition
from .search.quick_turn import quickened
from .search.setup import InsertionSetup
from .search.start_search import Search, null_burn
from .two_burns.planner import TwoBurnPlan, plan_two_burns

if TYPE_CHECKING:
    from matplotlib.figure import Figure

COLUMNS = {
    "nodes": Column("nodes", ".0f"),
    "time_of_flight_s": Column("burn", ".6f", "s"),
    "perigee_height_km": Column("perigee", ".3f", "km"),
    "apogee_height_km": Column("apogee", ".3f", "km"),
}
"""Columns of the iteration table that are this mission's own."""


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Plan(BurnPlan):
    """A plan as `guidance.mission.Plan` has it."""

    @property
    def later(self) -> LaterIgnition | None:
        """A later ignition that shortens the burn or makes one possible; looked for when first asked."""
        return later_ignition(self)

    def plot(self) -> Figure:
        """The orbit before and after with the burn, a Matplotlib figure. Raises ValueError for a plan that was not flown."""
        if self.verification is None:
            raise ValueError(f"nothing to plot: the plan is {self.status.value}; {self.message}")
        return orbit_figure(self, self.verification)

    def __repr__(self) -> str:
        found = self.verification
        lines = [
            f"Plan {self.scenario.name!r}, {self.scenario.problem}: {self.status.value}",
            f"  burn {self.time_of_flight_s:.3f} s, {self.propellant_kg:.1f} kg of propellant, ignition {self.ignition_s:.1f} s",
        ]
        if found is not None:
            lines.append(
                f"  orbit {shape_of(found.planned_orbit)}, inclination {np.rad2deg(found.planned_orbit.inc_rad):.3f}°"
            )
        return "\n".join([*lines, f"  {len(self.subproblems)} subproblems; {self.message}"])

    def _repr_html_(self) -> str:
        """Of a notebook: the verdict, and the figure where there is one."""
        text = self.verdict._repr_html_()
        if self.verification is None:
            return text
        return text + image_element(self.plot(), "the orbit before and after")

    @property
    def verdict(self) -> Verdict:
        """The answer, a cheaper option where one is known, and what is claimed of the optimum."""
        return verdict_of(self)

    def to_dict(self) -> dict[str, Any]:
        return plan_document(self)

    def tables(self) -> dict[str, str]:
        table, found = attitude_csv(self), self.verification
        if table is None or found is None:
            return {}
        coast = first_coast(self.scenario, self.ignition_s)
        burns = [FlownBurn(self.ignition_s, found.flight)] if self.time_of_flight_s else []
        return {"attitude.csv": table} | (messages(self.scenario, [coast], burns) if burns else {})

    def figures(self, folder: Path) -> tuple[FigureFile, ...]:
        return draw_figures(self, folder)

    def differences(self, other: Plan) -> tuple[Difference, ...]:
        return differences(self, other)


def plan(
    scenario: Scenario,
    *,
    solve: Solve | None = None,
    problem: ProblemName | None = None,
    callback: Callable[[Iteration], None] | None = None,
) -> Plan | TwoBurnPlan:
    """Plan the insertion of `scenario`; `problem` overrides the scenario's, `callback` sees every iteration.

    `solve` is any solver with the call shape of `orbsoc.solve`, which is the default. A target that cannot be
    reached, or a sequence that does not converge, is a status with its reason. Raises
    `orbsoc.guidance.scenario_file.ScenarioError` when `problem` contradicts the scenario.
    """
    if solve is None:
        from orbsoc.solving.solver import solve as solve_in_rust

        solve = solve_in_rust
    if problem is not None and problem != scenario.problem:
        scenario = scenario.with_changes(problem=problem)
    ready = InsertionSetup.of(scenario)
    if scenario.burn.count == 2:
        nothing = Found(ready)
        there = null_burn(ready, nothing)
        return _conclude(nothing) if there else plan_two_burns(ready, solve, callback)
    searches = Search if ready.rate_bound is None else BoundedSearch
    search = searches(solve, Rules(max_iterations=scenario.method.max_iterations), callback)
    free = scenario.burn.ignition == "free"
    found = best_ignition(ready, search) if free else search.run(ready)
    if ready.rate_bound is None:
        quickened(search, found)
    return _conclude(found)


def _conclude(found: Found) -> Plan:
    ready = found.ready
    return Plan(
        scenario=ready.scenario,
        target=ready.target,
        status=found.status,
        exit_reason=found.reason,
        message=found.message,
        stages=tuple(found.stages),
        iterate=found.iterate,
        verification=found.verification,
        proof=found.proof,
        ignition_s=ready.ignition_s,
    )


def reproduce(scenarios: Path) -> tuple[PaperRow, ...]:
    """Both problems of every scenario in a folder that names a case of the paper; each row's quantity names its plan."""
    rows: list[PaperRow] = []
    for path in sorted(scenarios.glob("*.toml")):
        if read_toml(path).get("mission") != "reachable_insertion":
            continue
        scenario = load_scenario(path)
        for problem in ("min_time", "max_energy") if scenario.compare_with else ():
            planned = plan(scenario.with_changes(problem=problem))
            assert isinstance(planned, Plan)  # the paper has one burn
            found = compare(planned)
            rows += (replace(row, quantity=f"{scenario.name}, {problem}: {row.quantity}") for row in found)
    return tuple(rows)
