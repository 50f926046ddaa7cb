"""Boundary points: the largest tilt at an azimuth, found by its own sequence.

A boundary point tells why a point at its azimuth was not reached. Where the largest tilt falls short of the point's tilt,
that gap is the evidence; where it does not, the trajectory to the boundary point is a better start.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orbsoc.orbit.array import Array, Flags

from ...model.batch import Batch, column
from ...model.direct.arcs import Arcs
from ...model.direct.guess import resampled, towards_planes
from ...model.direct.sequence import Ending
from ...model.direct.terminal import LargestTilt
from .tools import MOST_GRIDS, Tools

START_TILT_RAD = float(np.deg2rad(10.0))
"""Tilt of the plane that the cold start steers to."""
CLEAR_RAD = float(np.deg2rad(0.3))
"""A gap that a finer grid does not close: the coarse grid's error of the tilt stays below 0.1 degrees."""

RESOLUTION_RAD = float(np.deg2rad(0.005))
"""No largest tilt is known better than this, whatever it changed by: on 48 nodes they are within 0.004 degrees of
those of a nonlinear program on 256 points (tests/missions/reachable_domain/test_against_nonlinear_program.py)."""


@dataclass(slots=True, eq=False)
class BoundaryPoints(Batch):
    """The largest tilts (B,) found, NaN where the sequence failed, `infeasible` (B,) where it failed because no orbit at all
    meets the perigee bound, their change (B,) from the grid before, the nodes (B,) of the grid that found them, and the
    counters. `fine` are the arcs on the finest grid, NaN where there is none."""

    fine: Arcs
    nodes: NDArray[np.int16]
    tilt: Array = column()
    infeasible: Flags = column(False, dtype=bool)
    change: Array = column()
    subproblems: NDArray[np.int32] = column(0, MOST_GRIDS, dtype=np.int32)
    solver_iterations: NDArray[np.int32] = column(0, dtype=np.int32)


def largest_tilts(tools: Tools, target: LargestTilt, *, needed_tilt: Array | None = None) -> BoundaryPoints:
    """The largest tilt of every azimuth and perigee bound of `target`, on finer and finer grids, with the bound on the altitude
    at their nodes if there is one (between the finest ones the arc may dip below it by some hundred metres).

    With `needed_tilt` (B,) the grid is refined only where the gap to these tilts is not clear.
    """
    nodes, grid = tools.nodes, tools.collocation(tools.nodes)
    normal = target.frame.tilted(np.full(len(target), START_TILT_RAD), target.azimuth)
    arcs = towards_planes(grid, normal)
    fine = np.full((len(target), tools.fine_nodes, 3), np.nan)
    out = BoundaryPoints.blank(
        len(target),
        fine=Arcs(fine, fine.copy(), np.full((len(target), 6), np.nan)),
        nodes=np.full(len(target), nodes, np.int16),
    )
    todo = np.arange(len(target))
    while todo.size:
        lowest = np.full(todo.size, tools.lowest) if tools.bounded else None
        found = tools.sequences(nodes, target[todo], arcs, lowest=lowest)
        out.subproblems[todo] += tools.subproblems(nodes, found)
        out.solver_iterations[todo] += found.inner_iterations
        ok = found.ending == Ending.CONVERGED
        out.infeasible[todo] = found.ending == Ending.INFEASIBLE
        done = todo[ok]
        tilt = target[done].tilts(found.arcs.ends[ok])
        out.change[done] = np.abs(tilt - out.tilt[done])
        out.tilt[done] = tilt
        out.nodes[done] = nodes
        if nodes >= tools.fine_nodes:
            out.fine.put(done, found.arcs[ok])
            break
        # A sequence that goes to and fro on a coarse grid, as some do, is a start on a finer one all the same.
        unclear = ok | (found.ending == Ending.MAX_ITERATIONS)
        if needed_tilt is not None:
            unclear &= ~(needed_tilt[todo] - out.tilt[todo] >= CLEAR_RAD)
        todo = todo[unclear]
        finer = tools.collocation(min(2 * nodes, tools.fine_nodes))
        arcs = resampled(grid, found.arcs[np.flatnonzero(unclear)], finer)
        grid, nodes = finer, finer.grid.size
    return out
