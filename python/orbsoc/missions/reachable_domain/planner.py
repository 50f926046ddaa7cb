"""Plan one point of the domain: the largest orbit in one plane above one perigee height, with every subproblem kept.

The whole domain is `orbsoc reach`; this is the same solution of one of its points, with its convex subproblems solved by
the caller's solver. Without a point it is that of the grid's only plane, or else of the current one, at the lowest perigee height
of the scenario's grid.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from orbsoc.conic.problem import Problem
from orbsoc.conic.settings import Settings
from orbsoc.conic.solution import Solution
from orbsoc.guidance.mission import Column, PlanStatus
from orbsoc.guidance.scp import Iteration, Solve, solver
from orbsoc.orbit.array import Array
from orbsoc.orbit.planes import inclination_and_node

from .model.direct.arcs import Arcs
from .model.direct.condensed import CondensedBatch
from .model.direct.subproblems import SolvedBatch, Subproblems
from .model.flight.orbits import RADIUS_M, Orbits
from .scenario import Scenario
from .search.continuation.domain import Domain
from .search.continuation.table import COUNTS, FLOATS, WORDS, PointStatus, PointTable

Point = tuple[float, float, float]
"""Inclination and right ascension of the node (degrees), perigee height (km)."""

COLUMNS = {
    "nodes": Column("nodes", ".0f"),
    "a_km": Column("a", ".3f", "km"),
    "perigee_km": Column("perigee", ".3f", "km"),
}
"""Columns of the iteration table that are this mission's own."""
CHECKED = ("sma_error_rel", "plane_error_rad", "perigee_short_m", "altitude_short_m", "raw_most_rel")
"""Columns of a point that compare its flight with its prediction and its bounds."""
STATUS = {
    PointStatus.REACHED: PlanStatus.VERIFIED,
    PointStatus.NOT_REACHED: PlanStatus.NOT_FOUND,
    PointStatus.SOLVER_FAILED: PlanStatus.FAILED,
}


@dataclass(frozen=True, slots=True, eq=False)
class PointPlan:
    """What planning found; `Plan` adds the files. `point` is its row of the domain's table, and `programme` (N, 3) are the
    vectors of its attitude programme in ECI, None where the point is not reached."""

    scenario: Scenario
    status: PlanStatus
    point: dict[str, Any]
    programme: Array | None
    subproblems: tuple[Iteration, ...]

    @property
    def message(self) -> str:
        found = self.point
        if self.status is PlanStatus.VERIFIED:
            return f"{found['origin']}, {found['level']} on {found['nodes']} nodes"
        return str(found["evidence"]) or self.status.value

    @property
    def verification(self) -> dict[str, float] | None:
        """`CHECKED` of the flown plan, by an integrator that the optimiser does not use."""
        if self.status is not PlanStatus.VERIFIED:
            return None
        return {name: float(self.point[name]) for name in CHECKED}


@dataclass(slots=True)
class _Record:
    """Solves subproblems one by one with the caller's solver, and keeps them."""

    solve: Solve
    callback: Callable[[Iteration], None] | None
    iterations: list[Iteration] = field(default_factory=list)
    _last: tuple[float, Problem, Solution] | None = None

    def interior(self, batch: CondensedBatch, settings: Settings) -> SolvedBatch:
        """The one subproblem of a batch."""
        problem = batch.problem(0)
        found = self.solve(problem, settings)
        self._last = (settings.tol, problem, found)
        evidence = found.certificate
        residual = np.array([max(evidence.primal_residual, evidence.dual_residual, evidence.gap)])
        status, iterations = np.array([found.status], dtype=object), np.array([found.iterations])
        return SolvedBatch(status, found.x[None], found.y[None], found.z[None], iterations, residual)

    def watch(self, moved: Arcs, change: Array) -> None:
        """Note the subproblem that led to an arc."""
        assert self._last is not None
        tolerance, problem, solution = self._last
        orbit = Orbits.of(moved.ends, np.array([[0.0, 0.0, 1.0]]))
        figures = {
            "nodes": moved.positions.shape[1],
            "a_km": float(orbit.sma[0]) * RADIUS_M / 1e3,
            "perigee_km": float(orbit.perigee[0] - 1.0) * RADIUS_M / 1e3,
        }
        number = len(self.iterations) + 1
        self.iterations.append(
            Iteration(number, tolerance, problem, solution, float(change[0]), 0.0, figures)
        )
        if self.callback is not None:
            self.callback(self.iterations[-1])


def made(
    scenario: Scenario, solve: Solve | None, callback: Callable[[Iteration], None] | None, point: Point | None
) -> PointPlan:
    """Plan one point of the scenario; Ctrl-C is a status."""
    record = _Record(solver(solve), callback)
    domain = Domain.of(scenario, solve=Subproblems(record.interior, dual=False), watch=record.watch)
    if point is None:
        inc, raan = np.rad2deg(inclination_and_node(domain.frame.normal))
        if scenario.grid.inclination_deg.count == scenario.grid.raan_deg.count == 1:
            inc, raan = scenario.grid.inclination_deg.first, scenario.grid.raan_deg.first
        point = float(inc), float(raan), scenario.grid.perigee_height_km.first
    try:
        table = domain.solve_planes(*(np.array([value]) for value in point))
        status = STATUS[PointStatus(table["status"][0])]
    except KeyboardInterrupt:
        table, status = PointTable.empty(1, domain.tools.grids), PlanStatus.INTERRUPTED
    row = {name: table[name][0] for name in (*FLOATS, *COUNTS, *WORDS)}
    row |= dict(zip(("inc_deg", "raan_deg", "perigee_bound_km"), point, strict=True))
    vectors = table["commands"][0]
    programme = None if vectors is None else vectors.reshape(-1, 3)
    return PointPlan(scenario, status, row, programme, tuple(record.iterations))
