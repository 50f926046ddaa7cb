"""Perigee directions far from the natural one: from the plan whose perigee lies where it suits best, turned and lowered.

Towards such an orbit the convex sequence often has no feasible subproblem, since its steering must turn around. Newton on
the indirect equations follows the largest orbit there: its perigee turns from the natural direction to the requested one, one
way around and the other, while its height moves to the bound. What arrives is flown like every other plan. Where the perigee
may lie higher than its bound and a higher one gives a larger orbit, it is released; often it then rises to a circular orbit,
where no direction is left to hold on to, and the row keeps its status.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from orbsoc.orbit.array import Array, Index
from orbsoc.orbit.planes import in_plane_axes

from ...model.direct.guess import towards_planes
from ...model.direct.sequence import Ending
from ...model.direct.terminal import LargestOrbit
from ...model.flight.orbits import Orbits
from ...model.indirect.conditions import DIRECTION
from ...model.indirect.shooting import Unknowns, from_sequences
from .attempts import Attempts, polish
from .table import Origin, PointTable
from .wavefront import Wavefront

FIRST_SHARE, LEAST_SHARE = 0.05, 1e-3
"""Of the way, in a step; a point whose steps get shorter is given up."""
GROWTH, CUT = 1.6, 0.4
"""Of a step after one that arrives, and after one that does not."""
MOST_STEPS = 60
GAUSS_STEPS = 12
AT_BOUND = (
    "its perigee was turned to its direction and lowered to its bound by Newton, but no programme flew there"
)
RISING = (
    "an orbit with its perigee at the bound was found, but not the largest with its perigee there or higher: that one may be circular,"
    " its perigee without a direction"
)


def turn_perigees(front: Wavefront, *, at_bound: bool) -> PointTable:
    """Seek plans for the rows of a finished sweep that have none, though their plane has with its perigee elsewhere."""
    table, tools = front.table, front.tools
    # Written so that a row without a furthest tilt, NaN, is sought, too.
    rows = np.flatnonzero(~table.reached() & ~(table["tilt_deg"] > table["furthest_tilt_deg"]))
    rows, path = _natural_plans(front, rows)
    if not rows.size:
        return table
    target, energy = front.target(rows), np.full(rows.size, -np.inf)
    for way in (1.0, -1.0):
        there, unknowns = path.followed(front, way)
        found = Attempts.none(front.plans.arcs[rows], tools.nodes)
        found.newton_steps += path.newton_steps
        if there.size:
            part, every = Attempts.none(found.arcs[there], tools.nodes), np.arange(there.size)
            polish(tools, replace(target[there], perigee_at_bound=at_bound), part, every, unknowns)
            found.put(there, part)
            lost = there[~part.verified & (energy[there] == -np.inf)]
            table["evidence"][rows[lost]] = AT_BOUND if at_bound else RISING
        table.write_spent(rows, found)
        reached = np.where(found.verified, -1.0 / found.flown.sma, -np.inf)
        better = np.flatnonzero(reached > energy)
        energy[better] = reached[better]
        table.write_plans(rows[better], found[better], Origin.TURNED)
        table["evidence"][rows[better]] = ""
    return table


def _natural_plans(front: Wavefront, rows: Index) -> tuple[Index, _Path]:
    """The rows among `rows` that have a plan with their perigee anywhere, and the paths that begin there. Their cost is added
    to the table."""
    tools, table = front.tools, front.table
    free, collocation = front.target(rows, free=True), tools.collocation(tools.nodes)
    found = tools.sequences(tools.nodes, free, towards_planes(collocation, free.normal))
    table.add_cost(rows, tools.subproblems(tools.nodes, found), found.inner_iterations)
    good = np.flatnonzero(found.ending == Ending.CONVERGED)
    extrema = tools.indirect(GAUSS_STEPS).solve(free[good], from_sequences(collocation, free, found, good))
    table["newton_steps"][rows[good]] += extrema.steps
    kept = np.flatnonzero(extrema.converged)
    good, normal = good[kept], free.normal[good[kept]]
    unknowns = extrema.unknowns[kept]
    unknowns.active[:, DIRECTION] = True
    natural = Orbits.of(extrema.flown.ends[kept, :6], normal)
    target, steps = front.target(rows[good]), np.zeros(good.size, np.int32)
    return rows[good], _Path(target, unknowns, natural.argp, natural.perigee, steps)


@dataclass(frozen=True, slots=True, eq=False)
class _Path:
    """From extremals with natural arguments of perigee (B,) and perigee radii (B,) to those of `target`. `newton_steps` (B,)
    are those of the way followed last."""

    target: LargestOrbit
    unknowns: Unknowns
    argp: Array
    perigee: Array
    newton_steps: NDArray[np.int32]

    def followed(self, front: Wavefront, way: float) -> tuple[Index, Unknowns]:
        """Which arrive turning this way (+1 or −1), and with what. Steps grow while they arrive and are cut where not."""
        count, indirect = len(self.argp), front.tools.indirect(GAUSS_STEPS)
        wanted = front.planes.argp
        assert wanted is not None
        turn = way * np.mod(way * (wanted - self.argp), 2.0 * np.pi)
        unknowns, share = self.unknowns.copy(), np.zeros(count)
        step = np.full(count, FIRST_SHARE)
        self.newton_steps[:] = 0
        live = np.arange(count)
        for _ in range(MOST_STEPS):
            if not live.size:
                break
            at = np.minimum(share[live] + step[live], 1.0)
            between = self._between(live, self.argp[live] + at * turn[live], at)
            found = indirect.solve(between, unknowns[live])
            self.newton_steps[live] += found.steps
            good = np.flatnonzero(found.converged)
            unknowns.put(live[good], found.unknowns[good])
            share[live[good]] = at[good]
            step[live] *= np.where(found.converged, GROWTH, CUT)
            live = live[(share[live] < 1.0) & (step[live] >= LEAST_SHARE)]
        there = np.flatnonzero(share >= 1.0)
        return there, unknowns[there]

    def _between(self, which: Index, argp: Array, share: Array) -> LargestOrbit:
        """Targets at a share of the way."""
        normal, last = self.target.normal[which], self.target.perigee[which]
        node, ahead = in_plane_axes(normal)
        direction = np.cos(argp)[:, None] * node + np.sin(argp)[:, None] * ahead
        perigee = self.perigee[which] + share * (last - self.perigee[which])
        return LargestOrbit(normal, perigee, direction, perigee_at_bound=True)
