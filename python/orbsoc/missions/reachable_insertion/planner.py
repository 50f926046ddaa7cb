"""Plan an insertion: guess, sequential convex programming, propagation, and a finer grid where it is needed."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from orbsoc.guidance.collocation import legendre_gauss
from orbsoc.guidance.mission import Column, Difference, FigureFile, PaperRow, PlanStatus
from orbsoc.guidance.powered_flight import Burn, Trajectory, commanded
from orbsoc.guidance.scenario_file import read_toml
from orbsoc.guidance.scp import ExitReason, Iteration, Rules, Solve, Subproblem, sequential_convex
from orbsoc.orbit import EARTH, CanonicalUnits, elements_from_state
from orbsoc.orbit.propagate import Steering

from .burn_plan import BurnPlan, Stage
from .comparison import differences
from .guess import along_velocity, propagated, towards_plane
from .paper import compare
from .plots import draw_figures
from .problems import Iterate, MaxEnergyFixedPerigee, MaxEnergyFreePerigee, MinTime
from .record import attitude_csv, plan_document
from .scenario import ProblemName, Scenario, load_scenario
from .target import TargetOrbit
from .verification import Verification, verify

Array = NDArray[np.float64]
Linearise = Callable[[Iterate], Subproblem[Iterate]]

GROWTH = 1.5
"""Factor by which the grid grows when the propagation does not confirm a plan."""


COLUMNS = {
    "nodes": Column("nodes", ".0f"),
    "time_of_flight_s": Column("burn", ".6f", "s"),
    "perigee_height_km": Column("perigee", ".3f", "km"),
    "apogee_height_km": Column("apogee", ".3f", "km"),
}
"""Columns of the iteration table that are this mission's own."""


@dataclass(frozen=True, slots=True, eq=False)
class Plan(BurnPlan):
    """A plan as `guidance.mission.Plan` has it."""

    def to_dict(self) -> dict[str, Any]:
        return plan_document(self)

    def tables(self) -> dict[str, str]:
        table = attitude_csv(self)
        return {} if table is None else {"attitude.csv": table}

    def figures(self, folder: Path) -> tuple[FigureFile, ...]:
        return draw_figures(self, folder)

    def differences(self, other: Plan) -> tuple[Difference, ...]:
        return differences(self, other)


@dataclass(frozen=True, slots=True)
class _Mission:
    """A scenario made ready: canonical burn and target, and the subproblem that fits the problem."""

    scenario: Scenario
    target: TargetOrbit
    burn: Burn
    units: CanonicalUnits

    @classmethod
    def of(cls, scenario: Scenario) -> _Mission:
        units = CanonicalUnits.of(EARTH)
        vehicle = scenario.vehicle
        start_si = scenario.launch_inertial(scenario.initial)
        target = TargetOrbit.through(units.state_from_si(scenario.launch_inertial(scenario.target)))
        burn = Burn.of(start_si, vehicle.thruster(), vehicle.longest_burn_s, units)
        return cls(scenario, target, burn, units)

    @property
    def free_perigee(self) -> bool:
        scenario = self.scenario
        return scenario.problem == "max_energy" and scenario.target.perigee_direction == "free"

    def subproblem(self, *, soft: bool) -> Linearise:
        weight = self.scenario.method.slack_weight
        if self.scenario.problem == "min_time":
            return MinTime(self.burn, self.target, weight, self.figures)
        height_km = self.scenario.target.perigee_height_km
        assert height_km is not None  # the scenario checks it
        radius = (EARTH.earth_radius_m + 1e3 * height_km) / self.units.length_m
        if self.free_perigee:
            hard_or_soft = weight if soft else None
            return MaxEnergyFreePerigee(self.burn, self.target, radius, hard_or_soft, self.figures)
        return MaxEnergyFixedPerigee(self.burn, self.target, radius, weight, self.figures)

    def guess(self, steering: Steering, duration_s: float, nodes: int) -> Trajectory:
        return propagated(
            self.scenario.launch_inertial(self.scenario.initial),
            self.scenario.vehicle.thruster(),
            steering,
            duration_s,
            legendre_gauss(nodes),
        )

    def cold_start(self) -> Iterate:
        law = towards_plane(self.target.normal, self.units) if self.free_perigee else along_velocity
        return Iterate(self.guess(law, self.scenario.burn.duration_s, self.scenario.method.nodes))

    def resampled(self, iterate: Iterate, nodes: int) -> Iterate:
        """What the commanded attitude of a plan really flies, on another grid."""
        old = iterate.trajectory
        duration_s = old.duration * self.units.time_s
        steering = commanded(old.grid, old.controls, duration_s)
        trajectory = self.guess(steering, duration_s, nodes)
        return Iterate(trajectory, iterate.momentum_scale, iterate.laplace_scale)

    def figures(self, trajectory: Trajectory) -> Mapping[str, float]:
        """The columns of the iteration table that are this mission's own."""
        end = self.units.state_to_si(trajectory.end)
        orbit = elements_from_state(end[:3], end[3:])
        return {
            "nodes": trajectory.grid.size,
            "time_of_flight_s": trajectory.duration * self.units.time_s,
            "perigee_height_km": orbit.perigee_height_m() / 1e3,
            "apogee_height_km": orbit.apogee_height_m() / 1e3,
        }


def plan(
    scenario: Scenario,
    *,
    solve: Solve | None = None,
    problem: ProblemName | None = None,
    callback: Callable[[Iteration], None] | None = None,
) -> Plan:
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
    mission = _Mission.of(scenario)
    rules = Rules(max_iterations=scenario.method.max_iterations)

    def run(reference: Iterate, note: str, *, soft: bool = False) -> Stage:
        outcome = sequential_convex(
            reference, mission.subproblem(soft=soft), solve=solve, rules=rules, callback=callback
        )
        return Stage(reference.trajectory.grid.size, note, outcome)

    stages = [run(mission.cold_start(), "cold start")]
    soft = False
    if stages[-1].outcome.reason is ExitReason.SUBPROBLEM_INFEASIBLE and mission.free_perigee:
        soft = True
        stages.append(run(mission.cold_start(), "restart with slack: a subproblem was infeasible", soft=soft))
    best = stages[-1]
    verification = _verified(mission, best)
    while verification is not None and not verification.verified and best.nodes < scenario.method.max_nodes:
        nodes = min(scenario.method.max_nodes, int(np.ceil(GROWTH * best.nodes)))
        reference = mission.resampled(best.outcome.iterate, nodes)
        stages.append(run(reference, f"refined: {verification.failures[0]}", soft=soft))
        refined = _verified(mission, stages[-1])
        if refined is None:  # the coarser plan, and what is wrong with it, is the better answer
            break
        best, verification = stages[-1], refined
    return _conclude(mission, stages, best, verification)


def _verified(mission: _Mission, stage: Stage) -> Verification | None:
    """The verification of a converged stage; None when there is nothing to fly."""
    if stage.outcome.reason is not ExitReason.CONVERGED:
        return None
    return verify(mission.scenario, mission.target, stage.outcome.iterate)


def _conclude(mission: _Mission, stages: list[Stage], best: Stage, verification: Verification | None) -> Plan:
    reason = stages[-1].outcome.reason
    if reason is ExitReason.INTERRUPTED:
        status = PlanStatus.INTERRUPTED
    elif verification is not None:
        status = PlanStatus.VERIFIED if verification.verified else PlanStatus.NOT_VERIFIED
        reason = best.outcome.reason
    elif reason is ExitReason.INFEASIBLE:
        status = PlanStatus.INFEASIBLE
    else:
        status = PlanStatus.FAILED
    return Plan(
        scenario=mission.scenario,
        target=mission.target,
        status=status,
        exit_reason=reason,
        message=stages[-1].outcome.message,
        stages=tuple(stages),
        iterate=best.outcome.iterate,
        verification=verification,
    )


def reproduce(scenarios: Path) -> tuple[PaperRow, ...]:
    """Both problems of every scenario in a folder that names a case of the paper; each row's quantity names its plan."""
    rows: list[PaperRow] = []
    for path in sorted(scenarios.glob("*.toml")):
        if read_toml(path).get("mission") != "reachable_insertion":
            continue
        scenario = load_scenario(path)
        for problem in ("min_time", "max_energy") if scenario.compare_with else ():
            found = compare(plan(scenario.with_changes(problem=problem)))
            rows += (replace(row, quantity=f"{scenario.name}, {problem}: {row.quantity}") for row in found)
    return tuple(rows)
