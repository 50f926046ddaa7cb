"""All perigee bounds of a set of planes: from the lowest bound upwards, each plane from its own plan below.

A plan that is optimal for a bound and whose perigee lies above a higher bound is optimal for that one too: the higher
bound only removes orbits. So a plane's plan is reused until its perigee falls short, and is then continued from bound to
bound. Likewise what is not reached at a bound is not reached at a higher one.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from operator import call
from typing import Any

import numpy as np

from orbsoc.orbit.array import Array, Index
from orbsoc.orbit.planes import TiltFrame, in_plane_axes, normals

from ...model.direct.arcs import Arcs
from ...model.direct.guess import towards_planes
from ...model.direct.sequence import Ending
from ...model.direct.terminal import LargestOrbit, LargestTilt
from ...model.flight.orbits import canonical_radius
from .attempts import Attempts, attempt, attempt_on_fine_grid
from .largest_tilt import RESOLUTION_RAD, BoundaryPoints, largest_tilts
from .table import Origin, PointStatus, PointTable
from .tools import Tools

Part = Callable[[Callable[[], Any]], Any]
"""Does a part of the work, or knows its result: `orbsoc.sweep.journal.Journal.part`."""
ROWS_PER_PART = 256
"""Of attempts: enough for a batch, and a few per cent of a shard."""
NEAR_RAD = float(np.deg2rad(5.0))
"""Planes nearer than this are neighbours."""


@dataclass(frozen=True, slots=True, eq=False)
class PlaneSet:
    """P planes and K ascending perigee bounds; `argp` fixes the perigee direction, None leaves it free.

    Row p·K + k of the table is plane p at bound k.
    """

    inc_deg: Array
    raan_deg: Array
    heights_km: Array
    argp: float | None = None

    def __len__(self) -> int:
        return len(self.inc_deg)

    @property
    def normal(self) -> Array:
        return normals(np.deg2rad(self.inc_deg), np.deg2rad(self.raan_deg))

    def target(self, planes: Index, bound: Index, *, free: bool = False) -> LargestOrbit:
        """Planes and bounds, one a point."""
        normal = self.normal[planes]
        perigee = canonical_radius(self.heights_km[bound])
        if self.argp is None or free:
            return LargestOrbit(normal, perigee)
        node, ahead = in_plane_axes(normal)
        return LargestOrbit(normal, perigee, np.cos(self.argp) * node + np.sin(self.argp) * ahead)

    def blank(self, frame: TiltFrame, grids: tuple[int, ...]) -> PointTable:
        """The table with the points' own columns filled in."""
        bounds = len(self.heights_km)
        table = PointTable.empty(len(self) * bounds, grids)
        tilt, azimuth = frame.tilt_and_azimuth(self.normal)
        per_plane = (self.inc_deg, self.raan_deg, np.rad2deg(tilt), np.rad2deg(azimuth))
        for name, values in zip(("inc_deg", "raan_deg", "tilt_deg", "azimuth_deg"), per_plane, strict=True):
            table[name][:] = np.repeat(values, bounds)
        table["perigee_bound_km"][:] = np.tile(self.heights_km, len(self))
        return table


@dataclass(slots=True, eq=False)
class Wavefront:
    """The state of a sweep: the table, what is still to do, and the plans, one a row of the table."""

    tools: Tools
    frame: TiltFrame
    planes: PlaneSet
    continuation: bool
    table: PointTable
    plans: Attempts
    part: Part

    @classmethod
    def over(
        cls, tools: Tools, frame: TiltFrame, planes: PlaneSet, *, continuation: bool, part: Part | None = None
    ) -> Wavefront:
        """Nothing tried yet; without `continuation` every point is started cold by itself. `part` does a part of the work, or
        knows its result."""
        cold = towards_planes(tools.collocation(tools.nodes), planes.normal)
        plane = np.repeat(np.arange(len(planes)), len(planes.heights_km))
        plans = Attempts.none(cold[plane], tools.nodes)
        table = planes.blank(frame, tools.grids)
        return cls(tools, frame, planes, continuation, table, plans, part or call)

    def run(self) -> PointTable:
        """The lowest bound of every plane, then all bounds that its plan does not meet, then what is left."""
        bounds = len(self.planes.heights_km)
        first = np.arange(0, len(self.table), bounds)
        self._try(first if self.continuation else np.arange(len(self.table)), Origin.COLD)
        self._settle()
        if self.continuation:
            self._from_neighbours()
        return self.table

    def _from_neighbours(self) -> None:
        """Try rows that were not found, though they lie within the edge, once each, from plans of near planes at their bound."""
        table, tried = self.table, np.zeros(len(self.table), bool)
        while True:
            inside = ~(table["tilt_deg"] + np.rad2deg(RESOLUTION_RAD) > table["furthest_tilt_deg"])
            lost = np.flatnonzero(~table.reached() & inside & ~tried)
            near = self._nearest_plans(lost)
            lost, near = lost[near >= 0], near[near >= 0]
            if not lost.size:
                return
            tried[lost] = True
            self._try(lost, Origin.NEIGHBOUR, near)
            table["evidence"][lost[self.plans.verified[lost]]] = ""

    def _nearest_plans(self, rows: Index) -> Index:
        """For each row the row whose plan is that of the nearest plane reached at its bound; −1 where none is within
        NEAR_RAD."""
        bounds, normal = len(self.planes.heights_km), self.planes.normal
        every = np.arange(len(self.table))
        owner = np.where(self.plans.verified, every, self.plan_below(every))
        out = np.full(rows.size, -1)
        reached = self.table.reached() & (owner >= 0)
        for bound in np.unique(rows % bounds):
            here, have = np.flatnonzero(rows % bounds == bound), np.flatnonzero(reached[bound::bounds])
            if have.size:
                closeness = normal[rows[here] // bounds] @ normal[have].T
                best = closeness.argmax(axis=1)
                near = closeness[np.arange(here.size), best] >= np.cos(NEAR_RAD)
                out[here[near]] = owner[have[best[near]] * bounds + bound]
        return out

    def _settle(self) -> None:
        """Until every row has a status: reuse and continue plans, and explain the lowest failure of every plane."""
        while True:
            self._reuse_or_continue()
            lowest = self._lowest_failures()
            if not lowest.size:
                return
            self._explain(lowest)

    def _reuse_or_continue(self) -> None:
        """Give every open row above a plan that plan where its perigee is high enough, and try the others from it."""
        open_rows = np.flatnonzero((self.table["status"] == "") & (self.plans.ending == Ending.RUNNING))
        source = self.plan_below(open_rows)
        rows, source = open_rows[source >= 0], source[source >= 0]
        if not rows.size or not self.continuation:
            return
        perigee = canonical_radius(self.table["perigee_bound_km"][rows])
        high = self.plans.flown.perigee[source] >= perigee
        reused = self.plans[source[high]]
        reused.flown.perigee_short[:] = 0.0
        self.table.write_plans(rows[high], reused, Origin.REUSED)
        self.plans.arcs.put(rows[~high], self.plans.arcs[source[~high]])
        if (~high).any():
            self._try(rows[~high], Origin.CONTINUATION)

    def _try(self, rows: Index, origin: Origin, start: Index | None = None) -> None:
        """Attempt rows from the arcs that stand in `plans`, their own or those of the rows `start`; rows that fail stay open."""
        start = rows if start is None else start
        for first in range(0, rows.size, ROWS_PER_PART):
            some = slice(first, first + ROWS_PER_PART)
            target, arcs = self.target(rows[some]), self.plans.arcs[start[some]]
            found = self.part(partial(attempt, self.tools, target, arcs))
            self._take(rows[some], found, origin)

    def _take(self, rows: Index, found: Attempts, origin: Origin) -> None:
        self.table.write_spent(rows, found)
        good = np.flatnonzero(found.verified)
        self.table.write_plans(rows[good], found[good], origin)
        self.plans.put(rows[good], found[good])
        bad = np.flatnonzero(~found.verified)
        self.plans.ending[rows[bad]] = found.ending[bad]

    def plan_below(self, rows: Index) -> Index:
        """For each row the row of the highest bound below it, of the same plane, that has a plan of its own; else −1."""
        bounds = len(self.planes.heights_km)
        has = self.plans.verified.reshape(-1, bounds)
        latest = np.maximum.accumulate(np.where(has, np.arange(bounds), -1), axis=1)
        plane, bound = rows // bounds, rows % bounds
        below = np.where(bound > 0, latest[plane, bound - 1], -1)
        return np.where(below >= 0, plane * bounds + below, -1)

    def _lowest_failures(self) -> Index:
        """The lowest open row of every plane."""
        opened = (self.table["status"] == "").reshape(len(self.planes), -1)
        planes = np.flatnonzero(opened.any(axis=1))
        return np.asarray(planes * opened.shape[1] + opened[planes].argmax(axis=1))

    def target(self, rows: Index, *, free: bool = False) -> LargestOrbit:
        """Targets of rows of the table; `free` leaves the perigee direction free whatever the scenario says."""
        bounds = len(self.planes.heights_km)
        return self.planes.target(rows // bounds, rows % bounds, free=free)

    def _explain(self, rows: Index) -> None:
        """Seek the edge of the domain at the azimuths of rows without a plan; restart from it, or say how far off."""
        table = self.table
        tilt, azimuth = np.deg2rad(table["tilt_deg"][rows]), np.deg2rad(table["azimuth_deg"][rows])
        target = LargestTilt(self.frame, azimuth, self.target(rows, free=True).perigee)
        edge = self.part(partial(largest_tilts, self.tools, target, needed_tilt=tilt))
        table.add_cost(rows, edge.subproblems, edge.solver_iterations)
        gap = tilt - edge.tilt
        beyond = np.flatnonzero(gap > 0.0)
        words = [self._beyond(rows[k], gap[k], edge.nodes[k]) for k in beyond]
        table.write_failures(
            rows[beyond], PointStatus.NOT_REACHED, Origin.LARGEST_TILT, words, edge.tilt[beyond]
        )
        self._close_above(rows[beyond])
        inside = np.flatnonzero(~(gap > 0.0))
        if inside.size:
            self._restart(rows[inside], edge, inside)

    def _restart(self, rows: Index, edge: BoundaryPoints, points: Index) -> None:
        """Start again from the trajectories of the largest tilt, which lies beyond these planes, on the finest grid."""
        known = np.flatnonzero(np.isfinite(edge.fine.ends[points, 0]))
        if known.size:
            found = self.part(partial(self._from_edge, rows[known], edge.fine[points[known]]))
            self._take(rows[known], found, Origin.LARGEST_TILT)
        left = np.flatnonzero(~self.plans.verified[rows])
        tilt, uncertainty = edge.tilt[points], np.fmax(edge.change[points], RESOLUTION_RAD)
        gap = np.deg2rad(self.table["tilt_deg"][rows]) - tilt
        infeasible = self.plans.ending[rows] == Ending.INFEASIBLE
        nowhere = infeasible & edge.infeasible[points]
        # No orbit meets the bound, or the other conditions, or the plane lies at the boundary as far as that is known.
        explained = nowhere | (infeasible & self._restricted) | (-gap <= uncertainty)
        # A sequence that converged to plans none of which flies has not failed; it has not reached the point either.
        failed = ~explained & (np.isnan(gap) | (self.plans.ending[rows] != Ending.CONVERGED))
        for status, which in (
            (PointStatus.NOT_REACHED, left[~failed[left]]),
            (PointStatus.SOLVER_FAILED, left[failed[left]]),
        ):
            words = [NOWHERE if nowhere[k] else self._inside(rows[k], gap[k], uncertainty[k]) for k in which]
            self.table.write_failures(rows[which], status, Origin.LARGEST_TILT, words, tilt[which])
        self._close_above(rows[left[explained[left]]])

    def _close_above(self, rows: Index) -> None:
        """What is not reached at a bound is not reached at a higher one."""
        bounds = len(self.planes.heights_km)
        for row in rows:
            above = np.arange(row + 1, (row // bounds + 1) * bounds)
            above = above[~self.plans.verified[above]]
            self.table["status"][above] = PointStatus.NOT_REACHED.value
            self.table["origin"][above] = Origin.BELOW.value
            self.table["evidence"][above] = self.table["evidence"][row]
            self.table["furthest_tilt_deg"][above] = self.table["furthest_tilt_deg"][row]

    @property
    def _restricted(self) -> bool:
        """Whether the scenario has conditions that the largest tilt does not take into account."""
        return self.tools.bounded or self.planes.argp is not None

    def _from_edge(self, rows: Index, start: Arcs) -> Attempts:
        free = attempt_on_fine_grid(self.tools, self.target(rows, free=True), start)
        if self.planes.argp is None:
            return free
        found = attempt(self.tools, self.target(rows), free.arcs)
        free.put(slice(None), found)
        return free

    def _beyond(self, row: int, gap: float, nodes: int) -> str:
        """Evidence of a plane beyond the edge."""
        return (
            f"at perigee >= {self.table['perigee_bound_km'][row]:g} km the furthest tilt at its azimuth, found on"
            f" {nodes} nodes, falls {np.rad2deg(gap):.4f} deg short; the sequence towards the plane itself:"
            f" {_WORDS[Ending(self.plans.ending[row])]}"
        )

    def _inside(self, row: int, gap: float, uncertainty: float) -> str:
        """Evidence of a plane within the edge that no plan was found for."""
        if np.isnan(gap):
            return "neither a plan nor the furthest tilt at its azimuth was found"
        ending = Ending(self.plans.ending[row])
        where = (
            f"at perigee >= {self.table['perigee_bound_km'][row]:g} km lies {-np.rad2deg(gap):.4f} deg within the"
            f" furthest tilt at its azimuth (which is known to {np.rad2deg(uncertainty):.4f} deg)"
        )
        if self._restricted and ending == Ending.INFEASIBLE:
            return f"{where} of the less restricted domain, but no subproblem is feasible, cold or from that tilt"
        return f"{where}, but no plan flew to its promise; the sequence from there: {_WORDS[ending]}"


NOWHERE = "no subproblem is feasible: not towards the plane, and not towards any at its azimuth with this perigee bound"
_WORDS = {
    Ending.RUNNING: "did not start",
    Ending.CONVERGED: "converged",
    Ending.INFEASIBLE: "a subproblem has no feasible point",
    Ending.SOLVER_FAILED: "a subproblem could not be solved",
    Ending.MAX_ITERATIONS: "iteration limit reached",
}
