"""Plan one point of the domain: the largest orbit in one plane above one perigee height, with every subproblem kept.

The whole domain is `orbsoc reach`; this is the same solution of one of its points, with its convex subproblems solved by
the caller's solver. Without a point it is that of the grid's only plane, or else of the current one, at the lowest perigee height
of the scenario's grid.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from orbsoc.conic.problem import Problem
from orbsoc.conic.settings import Settings
from orbsoc.conic.solution import Solution
from orbsoc.guidance.collocation import legendre_gauss
from orbsoc.guidance.mission import Column, Difference, FigureFile, PaperRow, PlanStatus
from orbsoc.guidance.powered_flight import commanded
from orbsoc.guidance.scp import Iteration, Solve
from orbsoc.orbit.planes import inclination_and_node

from .model.direct.arcs import Arcs
from .model.direct.condensed import CondensedBatch
from .model.direct.subproblems import SolvedBatch, Subproblems
from .model.flight.orbits import RADIUS_M, Orbits
from .scenario import Scenario, load_scenario
from .search.continuation.domain import Domain
from .search.continuation.table import COUNTS, FLOATS, WORDS, PointStatus, PointTable

Array = NDArray[np.float64]
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
SMA_REL = 1e-6
"""Difference of two plans' semi-major axes up to which they agree."""
SAMPLES = 201
"""Times of `attitude.csv`."""
STATUS = {
    PointStatus.REACHED: PlanStatus.VERIFIED,
    PointStatus.NOT_REACHED: PlanStatus.NOT_FOUND,
    PointStatus.SOLVER_FAILED: PlanStatus.FAILED,
}


@dataclass(frozen=True, slots=True, eq=False)
class Plan:
    """A plan as `guidance.mission.Plan` has it; `point` is its row of the domain's table, and `programme` (N, 3) are the
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

    @property
    def verdict(self) -> str:
        """The answer in a sentence."""
        found = self.point
        sign = "=" if self.scenario.perigee.condition == "equal" else "≥"
        where = (
            f"in the plane of inclination {found['inc_deg']:.3f} deg and node {found['raan_deg']:.3f} deg with perigee"
            f" {sign} {found['perigee_bound_km']:g} km"
        )
        if self.status is not PlanStatus.VERIFIED:
            return f"no orbit {where} was found: {found['status'] or self.status.value}"
        return (
            f"the largest orbit {where} has a semi-major axis of {found['a_km']:.3f} km, confirmed in flight; orbsoc reach"
            " solves all points of the scenario"
        )

    def to_dict(self) -> dict[str, Any]:
        """The content of `plan.json`; null for what is not known."""
        return {
            "mission": self.scenario.mission,
            "name": self.scenario.name,
            "status": self.status.value,
            "message": self.message,
            "details": self.verdict,
            "point": {name: _plain(value) for name, value in self.point.items()},
            "verification": self.verification,
            "scp_iterations": len(self.subproblems),
            "subproblems": [row.to_dict() for row in self.subproblems],
            "scenario": self.scenario.model_dump(mode="json"),
        }

    def tables(self) -> dict[str, str]:
        """`attitude.csv`: the flown thrust direction in ECI, uniform in time."""
        if self.programme is None:
            return {}
        times_s = np.linspace(0.0, self.scenario.burn.duration_s, SAMPLES)
        steering = commanded(legendre_gauss(len(self.programme)), self.programme, times_s[-1])
        vectors = np.array([steering(float(time_s), np.empty(6)) for time_s in times_s])
        vectors /= np.linalg.norm(vectors, axis=1, keepdims=True)
        rows = (",".join(f"{value:.12g}" for value in row) for row in np.column_stack([times_s, vectors]))
        return {"attitude.csv": "\n".join(["t_s,ux,uy,uz", *rows]) + "\n"}

    def figures(self, folder: Path) -> tuple[FigureFile, ...]:
        """None: the figures of the domain are those of `orbsoc reach`."""
        return ()

    def differences(self, other: Plan) -> tuple[Difference, ...]:
        if PlanStatus.VERIFIED not in (self.status, other.status):
            return ()
        value = abs(self.point["a_km"] - other.point["a_km"]) / abs(other.point["a_km"])
        return (Difference("sma_rel", "semi-major axis", value, SMA_REL),)


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
        return SolvedBatch(
            status=np.array([found.status], dtype=object),
            x=found.x[None],
            y=found.y[None],
            z=found.z[None],
            iterations=np.array([found.iterations]),
            residual=np.array([max(evidence.primal_residual, evidence.dual_residual, evidence.gap)]),
        )

    def watch(self, moved: Arcs, change: Array) -> None:
        """Note the subproblem that led to an arc."""
        assert self._last is not None
        tolerance, problem, solution = self._last
        ends = moved.ends
        orbit = Orbits.of(ends, np.array([[0.0, 0.0, 1.0]]))
        figures = {
            "nodes": moved.positions.shape[1],
            "a_km": float(orbit.sma[0]) * RADIUS_M / 1e3,
            "perigee_km": float(orbit.perigee[0] - 1.0) * RADIUS_M / 1e3,
        }
        number = len(self.iterations) + 1
        row = Iteration(number, tolerance, problem, solution, float(change[0]), 0.0, figures)
        self.iterations.append(row)
        if self.callback is not None:
            self.callback(row)


def plan(
    scenario: Scenario,
    *,
    solve: Solve | None = None,
    callback: Callable[[Iteration], None] | None = None,
    point: Point | None = None,
) -> Plan:
    """Plan one point of the domain; `callback` sees every subproblem.

    `solve` is any solver with the call shape of `orbsoc.solve`, which is the default. A point that is not reached is a
    status with its evidence.
    """
    if solve is None:
        from orbsoc.solving.solver import solve as solve_in_rust

        solve = solve_in_rust
    record = _Record(solve, callback)
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
    return Plan(scenario, status, row, programme, tuple(record.iterations))


def reproduce(scenarios: Path) -> tuple[PaperRow, ...]:
    """The envelope of the paper's table 2 beside that of the boundary at its lowest perigee height."""
    from .search.query.envelope import envelope, limits
    from .search.query.resolved_boundary import resolved_boundary
    from .search.query.results import ReachableDomain

    lowest = load_scenario(scenarios / "paper004_reach.toml").grid.perigee_height_km.first
    scenario = load_scenario(scenarios / "paper004_reach.toml").with_changes(
        boundary={"perigee_height_km": {"first": lowest, "last": lowest, "step": 1.0}}
    )
    domain = Domain.of(scenario)
    boundary = resolved_boundary(domain)
    found = ReachableDomain(scenario, PointTable.empty(0, domain.tools.grids).columns, boundary)
    return tuple(
        PaperRow(
            quantity=f"{row.limit} (deg)",
            source="table 2",
            paper=f"{row.paper_deg:g}",
            ours=f"{row.whole_deg:.2f}",
            verdict="not reproduced",
            reason=row.reason,
        )
        for row in envelope(found, limits(found))
    )


def _plain(value: Any) -> Any:
    """A value of the table as JSON has it."""
    if isinstance(value, (float, np.floating)):
        return float(value) if np.isfinite(value) else None
    return int(value) if isinstance(value, np.integer) else value
