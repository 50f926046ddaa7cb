"""What the sweep would cost on the emulated computer: for each point its subproblems, times what one of them takes.

A point's cycles are the sum over its grids of subproblems × interior-point iterations × cycles per iteration. The first is
the point's own, from the table. The others are the price of a solve of the grid's sparsity pattern, which the caller finds
from the representative subproblems given here. Whatever this machine did (most of them it solves by Newton on the dual),
the emulated one is priced by its interior-point method. Data generation, flights and Newton's polish are the PS's own and
not priced; a subproblem of the edge counts as one of the plane, which has one equality row more.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import product
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from orbsoc.conic.problem import Problem
from orbsoc.conic.solution import Status
from orbsoc.orbit.array import Array
from orbsoc.solving.solver import solve

from ..model.direct.condensed import condense
from ..model.direct.guess import towards_planes
from ..model.direct.terminal import LargestOrbit
from ..model.flight.orbits import canonical_radius
from ..search.continuation.domain import Domain
from ..search.continuation.table import subproblems_on
from ..search.query.results import ReachableDomain

CYCLES = "modelled_pl_cycles"
"""The column of a point's cycles."""
PRICED_EACH = 3
"""Subproblems of a sequence that are priced, each at both tolerances of the sequence."""
TILTS_DEG = (3.0, 1.0, 0.3, 0.1, 0.0)
"""Tilts of the plane that the priced sequence steers to, the first within reach."""


PRICED = ("iterations", "cycles_per_iteration", "most_cycles", "speedup")
"""Numbers of a price that `summary.json` tells."""


class Price(Protocol):
    """Modelled price of a solve of one pattern, as `orbsoc.hw.representative_solves.SolvePrice`."""

    @property
    def iterations(self) -> float: ...
    @property
    def cycles_per_iteration(self) -> float: ...
    @property
    def most_cycles(self) -> float: ...
    @property
    def pl_clock_mhz(self) -> float: ...
    @property
    def speedup(self) -> float: ...


def mean_cycles(price: Price) -> float:
    """PL cycles of a subproblem, in the mean: a solve's start is shared out among its interior-point iterations."""
    return price.iterations * price.cycles_per_iteration


@dataclass(frozen=True, slots=True, eq=False)
class DomainCost:
    """Modelled cost on one device under one partition, by grid: the price of a subproblem, and how many of them every point
    has, in the table's order. `points_per_s` counts every point of the table, those with a reused plan included."""

    device: str
    partition: str
    prices: Mapping[int, Price]
    subproblems: Mapping[int, NDArray[np.int32]]
    deadline_ms: float | None

    @classmethod
    def of(
        cls,
        found: ReachableDomain,
        device: str,
        partition: str,
        prices: Mapping[int, Price],
        deadline_ms: float | None = None,
    ) -> DomainCost:
        """Price the subproblems that the table counts; `prices` has one for the nodes of every grid in use."""
        own = {nodes: found.points[subproblems_on(nodes)] for nodes in prices}
        return cls(device, partition, prices, own, deadline_ms)

    @property
    def pl_clock_mhz(self) -> float:
        return next((price.pl_clock_mhz for price in self.prices.values()), float("nan"))

    @property
    def cycles(self) -> Array:
        """PL clock cycles of every point."""
        rows = [self.subproblems[nodes] * mean_cycles(price) for nodes, price in self.prices.items()]
        return np.asarray(np.sum(rows, axis=0))

    @property
    def domain_s(self) -> float:
        return float(self.cycles.sum()) / self.pl_clock_mhz / 1e6

    @property
    def points_per_s(self) -> float:
        return len(self.cycles) / self.domain_s

    @property
    def speedup(self) -> float:
        """All subproblems on the PS alone, over this partition; below 1 the PL makes them slower."""
        counted = [
            (self.subproblems[nodes].sum() * mean_cycles(each), each) for nodes, each in self.prices.items()
        ]
        total = sum(cycles for cycles, _ in counted)
        return float(sum(cycles * each.speedup for cycles, each in counted) / total) if total > 0.0 else 1.0

    @property
    def points_within_deadline(self) -> int | None:
        return None if self.deadline_ms is None else int(self.points_per_s * self.deadline_ms / 1e3)

    def to_dict(self) -> dict[str, Any]:
        """Plain data, marked as what it is."""
        point_cycles = float(self.cycles.mean())
        return {
            "provenance": "modelled",
            "device": self.device,
            "partition": self.partition,
            "pl_clock_mhz": self.pl_clock_mhz,
            "patterns": [
                {
                    "nodes": nodes,
                    "subproblems": int(self.subproblems[nodes].sum()),
                    **{name: getattr(price, name) for name in PRICED},
                    "cycles": mean_cycles(price),
                }
                for nodes, price in self.prices.items()
            ],
            "domain_s": self.domain_s,
            "point_us": point_cycles / self.pl_clock_mhz,
            "point_pl_cycles": point_cycles,
            "points_per_s": self.points_per_s,
            "speedup": self.speedup,
            "deadline_ms": self.deadline_ms,
            "points_within_deadline": self.points_within_deadline,
        }

    @property
    def words(self) -> str:
        """The cost in a sentence, and whether the PL is worth it."""
        ratio, low = self.speedup, self.speedup < 1.0
        against = (
            f"{1.0 / ratio if low else ratio:.2f} times {'SLOWER' if low else 'faster'} than the PS alone"
        )
        text = (
            f"modelled: {self.partition} on {self.device} solves the subproblems of {self.points_per_s:.0f} points per"
            f" second, the whole domain in {self.domain_s:.1f} s ({1e6 / self.points_per_s:.0f} us a point)"
        )
        if ratio != 1.0:
            text += f", {against}"
        if self.deadline_ms is not None:
            text += f"; {self.points_within_deadline} points within {self.deadline_ms:g} ms"
        return text

    @property
    def unit(self) -> str:
        """Of a point's cycles, in words for the tables that hold them."""
        return f"cycles of the PL clock at {self.pl_clock_mhz:g} MHz"

    @property
    def source(self) -> str:
        """Where a point's cycles come from, for the tables that hold them."""
        return (
            f"modelled, not measured: {self.partition} on {self.device}, exact schedules of the grids' sparsity patterns;"
            " subproblems of the point x interior-point iterations x cycles per iteration; 0 for a plan that was held"
        )


def representative_subproblems(found: ReachableDomain) -> dict[int, list[tuple[Problem, float]]]:
    """Subproblems of cold sequences and the tolerances to solve them to, by the nodes of every grid that the table counts
    subproblems on. Raises KeyboardInterrupt when interrupted."""
    domain, rules = found.domain, found.domain.tools.rules
    grids = [n for n in domain.tools.grids if found.points[subproblems_on(n)].any()]
    tolerances = (rules.loose_tol, rules.tight_tol)
    return {nodes: list(product(_representatives(domain, nodes), tolerances)) for nodes in grids}


def _representatives(domain: Domain, nodes: int) -> list[Problem]:
    """The first subproblems of cold sequences to a plane tilted a few degrees, less where that is out of reach: at the
    lowest perigee bound of the grid, which is inactive there, and on the coarsest grid also at the highest, which is active.
    Where nothing is within reach, the first subproblem, which says so."""
    for tilt_deg in TILTS_DEG:
        problems = _solvable(domain, nodes, tilt_deg)
        if problems:
            return problems
    return _solvable(domain, nodes, TILTS_DEG[-1], feasible=False)


def _solvable(domain: Domain, nodes: int, tilt_deg: float, *, feasible: bool = True) -> list[Problem]:
    normal = domain.frame.tilted(np.deg2rad([tilt_deg]), np.array([0.5]))
    collocation = domain.tools.collocation(nodes)
    heights = domain.scenario.grid.perigee_height_km.values()[[0, -1]]
    problems: list[Problem] = []
    for height_km in heights if nodes == domain.tools.nodes else heights[:1]:
        target = LargestOrbit(normal, np.array([canonical_radius(height_km)]))
        arcs = towards_planes(collocation, normal)
        for _ in range(PRICED_EACH if nodes == domain.tools.nodes else 1):
            linear = collocation.end_map(arcs)
            problem = condense(linear, target.rows(arcs.ends)).problem(0)
            if not feasible:
                return [problem]
            solution = solve(problem)
            if solution.status is Status.INTERRUPTED:
                raise KeyboardInterrupt
            if solution.status is not Status.SOLVED:
                break
            problems.append(problem)
            arcs = collocation.arcs(linear, solution.x.reshape(arcs.controls.shape))
    return problems
