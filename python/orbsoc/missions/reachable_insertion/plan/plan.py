"""A plan with one burn as `guidance.mission.Plan` has it, and the functions by which the mission makes one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from orbsoc.guidance.figure_style import image_element
from orbsoc.guidance.mission import Difference, FigureFile, PaperRow, PlanStatus
from orbsoc.guidance.scenario_file import read_toml
from orbsoc.guidance.scp import Iteration, Solve
from orbsoc.guidance.verdict import Verdict
from orbsoc.orbit import elements_from_state

from ..figures.orbit import orbit_figure
from ..figures.panels import draw_figures
from ..paper import compare
from ..planner import searched
from ..record.attitude import attitude_table
from ..record.document import plan_document
from ..record.messages import messages
from ..scenario import ProblemName, Scenario, load_scenario
from ..search.ignition import LaterIgnition, later_ignition
from ..search.result import SearchResult
from ..search.setup import InsertionSetup
from ..search.strategies import NULL_BURN
from ..two_burns.instead import two_burns_instead
from ..two_burns.planner import TwoBurnPlan, plan_two_burns
from ..verification import Arcs, shape_of
from .verdict import verdict, verdict_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

TIME_REL = 1e-7
SMA_REL = 1e-7
NODE_STATE = 1e-6
"""Largest difference of a collocated state, in Earth radii and circular speeds, that counts as agreement."""


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Plan(SearchResult):
    """What the search came to, with its verdict and files."""

    @property
    def later(self) -> LaterIgnition | None:
        """A later ignition that shortens the burn or makes one possible; looked for when first asked."""
        return later_ignition(self)

    @property
    def verdict(self) -> Verdict:
        """The answer, a cheaper option where one is known, and what is claimed of the optimum."""
        return verdict_of(self)

    def to_dict(self) -> dict[str, Any]:
        return plan_document(self, verdict(self), self.later, two_burns_instead(self))

    @property
    def arcs(self) -> Arcs | None:
        """Coast and burn as flown; None where nothing was."""
        found = self.verification
        return None if found is None else Arcs.of_one(self.scenario, self.ignition_s, found.flight)

    def tables(self) -> dict[str, str]:
        arcs = self.arcs if self.status is PlanStatus.VERIFIED else None
        if arcs is None:
            return {}
        table = {"attitude.csv": attitude_table(self.scenario, arcs)}
        return table | (messages(self.scenario, arcs) if self.time_of_flight_s else {})

    def figures(self, folder: Path) -> tuple[FigureFile, ...]:
        return draw_figures(self, self.arcs, folder)

    def plot(self) -> Figure:
        """The orbit before and after with the burn, a Matplotlib figure. Raises ValueError for a plan that was not flown."""
        if (arcs := self.arcs) is None:
            raise ValueError(f"nothing to plot: the plan is {self.status.value}; {self.message}")
        start = self.scenario.launch_inertial(self.scenario.initial)
        return orbit_figure(f"{self.scenario.name}: the orbit before and after", start, arcs)

    def differences(self, other: Plan) -> tuple[Difference, ...]:
        """Burn time and semi-major axis, relative, and states at the nodes of the other, canonical; grids may differ."""
        mine, theirs = self.trajectory, other.trajectory
        at_nodes = mine.grid.interpolate_from_start(self.setup.burn.start, mine.states, theirs.grid.nodes)
        apart = [float(np.abs(at_nodes - theirs.states).max()), float(np.abs(mine.end - theirs.end).max())]
        longest = max(mine.duration, theirs.duration)  # 0 of two burns of 0 s
        time_rel = abs(mine.duration - theirs.duration) / longest if longest else 0.0
        ours_m, theirs_m = (_sma_m(plan) for plan in (self, other))
        return (
            Difference("time_of_flight_rel", "burn time", time_rel, TIME_REL),
            Difference("sma_rel", "semi-major axis", abs(ours_m - theirs_m) / abs(theirs_m), SMA_REL),
            Difference("node_state", "node states", max(apart), NODE_STATE, "canonical"),
        )

    def __repr__(self) -> str:
        found = self.verification
        lines = [
            f"Plan {self.scenario.name!r}, {self.scenario.problem}: {self.status.value}",
            f"  burn {self.time_of_flight_s:.3f} s, {self.propellant_kg:.1f} kg of propellant, ignition {self.ignition_s:.1f} s",
        ]
        if found is not None:
            inclination_deg = np.rad2deg(found.planned_orbit.inc_rad)
            lines.append(f"  orbit {shape_of(found.planned_orbit)}, inclination {inclination_deg:.3f}°")
        return "\n".join([*lines, f"  {len(self.subproblems)} subproblems; {self.message}"])

    def _repr_html_(self) -> str:
        """Of a notebook: the verdict, and the figure where there is one."""
        text = self.verdict._repr_html_()
        if self.verification is None:
            return text
        return text + image_element(self.plot(), "the orbit before and after")


def _sma_m(plan: SearchResult) -> float:
    end = plan.setup.units.state_to_si(plan.trajectory.end)
    return elements_from_state(end[:3], end[3:], plan.scenario.constants).sma_m


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
    if scenario.burn.count == 1:
        found = searched(scenario, solve, callback)
    else:
        found = searched(scenario, solve, callback, (NULL_BURN,))
        if not found.attempts:
            return plan_two_burns(InsertionSetup.of(scenario), solve, callback)
    return Plan(found.setup, found.attempts, found.proof, found.interrupted)


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
