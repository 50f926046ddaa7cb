"""One attempt at many points: the sequence, the flight, and what follows where the flight disagrees.

A plan on N nodes is flown. Where the flight does not confirm it, Newton's method on the indirect equations starts from
its multipliers, and the primer that it finds is flown. Where that fails too, the sequence is run again on a finer grid
and both are tried once more. A plan that no flight confirms does not count as reached.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from orbsoc.orbit.array import Array, Flags, Index

from ...model.batch import Batch, Rows, column
from ...model.direct.arcs import Arcs
from ...model.direct.guess import resampled
from ...model.direct.sequence import Ending
from ...model.direct.terminal import LargestOrbit
from ...model.flight.orbits import RADIUS_M, Flown
from ...model.indirect.primer import Extremals, primer_programmes
from ...model.indirect.shooting import Unknowns, from_sequences
from .tools import MOST_GRIDS, Tools

PRIMER_NODES = (16, 32, 64)
"""Nodes of the attitude programme of a polished plan, tried in this order: one with the first of NEWTON_STEPS, two with
the second, all with the others."""
NEWTON_STEPS = (6, 16, 40, 160)
"""Gauss steps of an extremal; more where its steering swings so fast that the flight of its programme disagrees, the last
number only where fewer steps found an extremal at all."""
SPENT = ("subproblems", "solver_iterations", "newton_steps")
"""Counters that attempts at a point add up."""
POLISHED_FLIGHT_STEPS = 12
"""Steps in which the flight of a polished plan begins: near the edge its steering swings fast."""
CORRECTIONS = 6
"""Limit of corrections of the requested target, along a bound on the altitude, by the miss of the flight."""


@dataclass(slots=True, eq=False)
class Attempts(Batch):
    """What attempts at B points arrived at.

    `ending` (B,) holds `Ending` values of the last sequence, `verified` (B,) says whether the flight confirmed
    the plan, `nodes` (B,) are those of the last sequence and `polished` (B,) whether Newton found the plan. `arcs` are
    references on the coarse grid to continue from; `programmes` (B,) holds vectors (N, 3) or None; `subproblems`
    (B, MOST_GRIDS) counts those solved on each of `Tools.grids`.
    """

    arcs: Arcs
    flown: Flown
    nodes: NDArray[np.int16]
    ending: NDArray[np.int8] = column(Ending.RUNNING, dtype=np.int8)
    verified: Flags = column(False, dtype=bool)
    polished: Flags = column(False, dtype=bool)
    programmes: NDArray[np.object_] = column(None, dtype=object)
    subproblems: NDArray[np.int32] = column(0, MOST_GRIDS, dtype=np.int32)
    solver_iterations: NDArray[np.int32] = column(0, dtype=np.int32)
    newton_steps: NDArray[np.int32] = column(0, dtype=np.int32)

    @classmethod
    def none(cls, start: Arcs, nodes: int) -> Attempts:
        """Nothing found yet."""
        count = len(start)
        grid = np.full(count, nodes, np.int16)
        return cls.blank(count, arcs=start.copy(), flown=Flown.blank(count), nodes=grid)

    def put(self, which: Rows, other: Self) -> None:
        """Overwrite some points by other attempts at them, adding up the counters."""
        spent = {name: getattr(self, name)[which] + getattr(other, name) for name in SPENT}
        Batch.put(self, which, other)
        for name, counts in spent.items():
            getattr(self, name)[which] = counts

    def accept(self, which: Index, programmes: Array, flown: Flown, verified: Flags) -> None:
        """Take flown programmes for the points `which`."""
        self.flown.put(which, flown)
        self.verified[which] = verified
        for k, vectors in zip(which, programmes, strict=True):
            self.programmes[k] = vectors


def attempt(tools: Tools, target: LargestOrbit, start: Arcs) -> Attempts:
    """Try every point of `target` from its arc of `start`, both on the coarse grid."""
    out = _on_grid(tools, target, start, tools.nodes)
    coarse, nodes = tools.collocation(tools.nodes), tools.nodes
    while nodes < tools.fine_nodes:
        again = np.flatnonzero((out.ending == Ending.CONVERGED) & ~out.verified)
        if not again.size:
            break
        nodes = min(2 * nodes, tools.fine_nodes)
        grid = tools.collocation(nodes)
        finer = _on_grid(tools, target[again], resampled(coarse, out.arcs[again], grid), nodes)
        finer.arcs = resampled(grid, finer.arcs, coarse)
        better = finer.ending == Ending.CONVERGED
        out.put(again[better], finer[np.flatnonzero(better)])
        out.ending[again[~better]] = finer.ending[~better]
    return out


def attempt_on_fine_grid(tools: Tools, target: LargestOrbit, start: Arcs) -> Attempts:
    """Try every point of `target` from its arc of `start` on the finest grid; the arcs returned are on the coarse one."""
    out = _on_grid(tools, target, start, tools.fine_nodes)
    out.arcs = resampled(tools.collocation(tools.fine_nodes), out.arcs, tools.collocation(tools.nodes))
    return out


def _on_grid(tools: Tools, target: LargestOrbit, start: Arcs, nodes: int) -> Attempts:
    """Sequence, flight and polish on one grid; the arcs returned are on this grid."""
    out = Attempts.none(start, nodes)
    all_points = np.arange(len(target))
    _sequence(tools, target, out, all_points)
    if tools.bounded:
        _along_bound(tools, target, out)
    return out


def _sequence(
    tools: Tools,
    target: LargestOrbit,
    out: Attempts,
    which: Index,
    *,
    requested: LargestOrbit | None = None,
    lowest: Array | None = None,
) -> None:
    """Run the sequence for the points `which`, fly what converged, polish what the flight does not confirm.

    With `lowest` (B,) bounding the radius at the nodes there is no polish, and the `requested` target may differ from the one
    that the flight is compared with.
    """
    nodes = int(out.nodes[which[0]])
    part = (target if requested is None else requested)[which]
    found = tools.sequences(nodes, part, out.arcs[which], lowest=lowest)
    out.ending[which] = found.ending
    out.subproblems[which] += tools.subproblems(nodes, found)
    out.solver_iterations[which] += found.inner_iterations
    out.verified[which] = False
    reached = np.flatnonzero(found.ending == Ending.CONVERGED)
    if not reached.size:
        return
    here = which[reached]
    out.arcs.put(here, found.arcs[reached])
    programmes = found.arcs.controls[reached]
    flown = tools.verify(programmes, target[here], _sma(found.arcs.ends[reached]))
    if lowest is not None:
        out.accept(here, programmes, flown, tools.kept(flown, sma_rel=tools.sma_rel_along_bound(nodes)))
        return
    out.accept(here, programmes, flown, tools.kept(flown))
    if target.perigee_at_bound:
        return
    confirmed = out.verified[here] | (
        tools.bounded & tools.kept(replace(flown, altitude_short=0.0 * flown.sma))
    )
    bad = np.flatnonzero(~confirmed)
    if bad.size:
        unknowns = from_sequences(tools.collocation(nodes), target[which], found, reached[bad])
        polish(tools, target, out, here[bad], unknowns)


def polish(tools: Tools, target: LargestOrbit, out: Attempts, which: Index, start: Unknowns) -> Unknowns:
    """Newton from `start` for the points `which`, with finer steps where they are needed; take what converges and
    is confirmed by its flight. Where the solution with coarser steps lies too far off to lead to the next, `start` is tried
    again. Returns the unknowns arrived at."""
    unknowns = start.copy()
    left, moved = np.arange(len(which)), np.zeros(len(which), bool)
    for level, steps in enumerate(NEWTON_STEPS):
        if level == len(NEWTON_STEPS) - 1:
            left = left[moved[left]]
        if not left.size:
            break
        newton = tools.indirect(steps)
        found = newton.solve(target[which[left]], unknowns[left])
        misled = np.flatnonzero(moved[left] & ~found.converged)
        if misled.size:
            again = left[misled]
            found.put(misled, newton.solve(target[which[again]], start[again]))
        out.newton_steps[which[left]] += found.steps
        there = np.flatnonzero(found.converged)
        unknowns.put(left[there], found.unknowns[there])
        moved[left[there]] = True
        if there.size:
            _fly_primers(
                tools, target, out, which[left[there]], found.flown[there], PRIMER_NODES[: level + 1]
            )
        left = left[~out.polished[which[left]]]
    return unknowns


def _fly_primers(
    tools: Tools, target: LargestOrbit, out: Attempts, left: Index, flown: Extremals, choice: tuple[int, ...]
) -> None:
    """Make programmes of the primers of extremals on the fewest nodes that a flight confirms, and take those plans."""
    for nodes in choice:
        programmes, predicted_sma = primer_programmes(flown, nodes), _sma(flown.ends[:, :6])
        flights = tools.verify(programmes, target[left], predicted_sma, steps=POLISHED_FLIGHT_STEPS)
        good = tools.kept(flights)
        out.polished[left[good]] = True
        out.accept(left[good], programmes[good], flights[good], good[good])
        left, flown = left[~good], flown[np.flatnonzero(~good)]
        if not left.size:
            return


def _along_bound(tools: Tools, target: LargestOrbit, out: Attempts) -> None:
    """Bound the altitude at the nodes, where the flight passes too low, and request what makes the flight arrive.

    Between the nodes the arc dips below the bound, and the interpolant of steering with corners ends off the plane: the
    bound is raised, the plane turned and the perigee raised by what the last flight missed.
    """
    short = out.flown.altitude_short > tools.tolerances.bound_m / RADIUS_M
    short |= target.perigee_at_bound & ~out.verified
    low = np.flatnonzero((out.ending == Ending.CONVERGED) & short)
    lowest, requested = np.full(len(target), tools.lowest), target
    sma_rel = tools.sma_rel_along_bound(int(out.nodes[0]))
    for correction in range(CORRECTIONS):
        if correction > 0:
            low = low[(out.ending[low] == Ending.CONVERGED) & ~out.verified[low]]
            low = low[out.flown.sma_error[low] <= sma_rel]
            lowest[low] += 1.05 * out.flown.altitude_short[low]
            requested = _turned_by_the_miss(requested, target, out.flown, low)
        if not low.size:
            return
        out.polished[low] = False
        _sequence(tools, target, out, low, requested=requested, lowest=lowest[low])


def _turned_by_the_miss(
    requested: LargestOrbit, target: LargestOrbit, flown: Flown, which: Index
) -> LargestOrbit:
    """The next requested target, given what `requested` led to for the points `which`."""
    normal, perigee = requested.normal.copy(), requested.perigee.copy()
    low = target.perigee[which] - flown.perigee[which]
    turned = normal[which] + (target.normal[which] - flown.normal[which])
    normal[which] = turned / np.linalg.norm(turned, axis=1, keepdims=True)
    perigee[which] += low if target.perigee_at_bound else np.maximum(low, 0.0)
    return requested.moved(normal, perigee)


def _sma(ends: Array) -> Array:
    """Semi-major axes of end states (B, 6), canonical."""
    return np.asarray(1.0 / (2.0 / np.linalg.norm(ends[:, :3], axis=1) - (ends[:, 3:] ** 2).sum(axis=1)))
