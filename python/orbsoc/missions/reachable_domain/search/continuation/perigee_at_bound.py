"""Perigee at its bound, not above it: the plans of the ≥ problem with their perigees lowered, bound by bound.

r_p = ρ is not a convex restriction where the largest orbit has a higher perigee, and the sequence need not converge there. Newton on the indirect equations does: it starts from the largest orbit, where the multiplier of the
perigee is zero, and follows the perigee down in steps.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from orbsoc.orbit.array import Array, Flags, Index

from ...model.direct.arcs import Arcs
from ...model.direct.sequence import Ending
from ...model.direct.terminal import LargestOrbit
from ...model.flight.orbits import canonical_radius
from ...model.indirect.shooting import Unknowns, from_sequences
from .attempts import Attempts, attempt, polish
from .table import Origin, PointStatus, PointTable
from .wavefront import Wavefront

LONGEST_STEP_KM = 35.0
"""Of a perigee on its way down."""
AT_BOUND_M = 1.0
"""A perigee this near its bound needs no lowering."""


def lower_perigees(front: Wavefront) -> PointTable:
    """Replace every plan of a finished sweep whose perigee lies above its bound by one whose perigee is at it."""
    table, bounds = front.table, len(front.planes.heights_km)
    above = table.reached() & (table["perigee_km"] - table["perigee_bound_km"] > AT_BOUND_M / 1e3)
    grid = above.reshape(-1, bounds)
    planes = np.flatnonzero(grid.any(axis=1))
    if not planes.size:
        return table
    top = bounds - 1 - grid[planes, ::-1].argmax(axis=1)
    # The plan of the highest such bound is the free optimum; find its multipliers by a sequence that starts at its end.
    source = planes * bounds + top
    owner = np.where(front.plans.verified[source], source, front.plan_below(source))
    target = front.target(source)
    unknowns, ready = _free_optimum(front, source, target, front.plans[owner])
    height, arcs = table["perigee_km"][source].copy(), front.plans.arcs[owner]
    for bound in range(bounds - 1, -1, -1):
        here = np.flatnonzero(grid[planes, bound])
        rows = planes[here] * bounds + bound
        bound_km = float(front.planes.heights_km[bound])
        found = _descend(front, rows, height[here], bound_km, unknowns, here, ready[here])
        ready[here] &= found.verified
        height[here] = np.where(found.verified, bound_km, height[here])
        table.write_spent(rows, found)
        if front.tools.bounded:
            _keep_altitude(front, rows, found, arcs, here)
        good = found.verified
        table.write_plans(rows[good], found[np.flatnonzero(good)], Origin.PERIGEE_AT_BOUND)
        _write_failures(table, rows[~good])
    return table


def _free_optimum(
    front: Wavefront, rows: Index, target: LargestOrbit, plans: Attempts
) -> tuple[Unknowns, Flags]:
    """Extremals of plans whose perigee condition is inactive; their cost is added to rows of the table."""
    tools = front.tools
    found = tools.sequences(tools.nodes, target, plans.arcs)
    start = from_sequences(tools.collocation(tools.nodes), target, found, np.arange(len(target)))
    extrema = tools.indirect(12).solve(target, start)
    front.table.add_cost(rows, tools.subproblems(tools.nodes, found), found.inner_iterations, extrema.steps)
    return extrema.unknowns, extrema.converged & (found.ending == Ending.CONVERGED)


def _descend(
    front: Wavefront,
    rows: Index,
    height: Array,
    bound_km: float,
    unknowns: Unknowns,
    which: Index,
    ready: Flags,
) -> Attempts:
    """Follow the perigees of `which` from their heights to the bound (km); `unknowns` moves along."""
    tools = front.tools
    out = Attempts.none(front.plans.arcs[rows], tools.nodes)
    live = np.flatnonzero(ready)
    if not live.size:
        return out
    steps = int(np.ceil((height[live] - bound_km).max() / LONGEST_STEP_KM)) or 1
    for step in range(1, steps + 1):
        at = height[live] + (bound_km - height[live]) * step / steps
        full = front.target(rows[live])
        target = replace(full, perigee=canonical_radius(at), perigee_at_bound=True)
        if step < steps:
            found = tools.indirect(12).solve(target, unknowns[which[live]])
            unknowns.put(which[live], found.unknowns)
            out.newton_steps[live] += found.steps
            live = live[found.converged]
        else:
            part = Attempts.none(out.arcs[live], tools.nodes)
            reached = polish(tools, target, part, np.arange(live.size), unknowns[which[live]])
            unknowns.put(which[live], reached)
            out.put(live, part)
    return out


def _keep_altitude(front: Wavefront, rows: Index, found: Attempts, arcs: Arcs, planes: Index) -> None:
    """By sequences along the bound on the altitude, which Newton knows nothing of, what it did not find: from the arcs
    of the bound above, which move along. In place on `found` and `arcs`."""
    if front.planes.argp is not None:
        return
    left = np.flatnonzero(~found.verified)
    if not left.size:
        return
    target = replace(front.target(rows[left]), perigee_at_bound=True)
    more = attempt(front.tools, target, arcs[planes[left]])
    front.table.write_spent(rows[left], more)
    good = np.flatnonzero(more.verified)
    found.put(left[good], more[good])
    arcs.put(planes[left[good]], more.arcs[good])


def _write_failures(table: PointTable, rows: Index) -> None:
    words = "Newton did not follow the perigee down to its bound; with the perigee free to be higher it is reached"
    unknown = np.full(rows.size, np.nan)
    table.clear_plans(rows)
    table.write_failures(
        rows, PointStatus.SOLVER_FAILED, Origin.PERIGEE_AT_BOUND, [words] * rows.size, unknown
    )
