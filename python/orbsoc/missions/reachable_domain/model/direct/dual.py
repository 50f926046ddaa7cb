"""The dual of the condensed subproblem, by Newton's method from multipliers nearby: many points side by side.

With multipliers w = (y, z) of the plane's rows and the perigee cone, d = c + Aᵀy + Gᵀz has three components a node, the
best controls are uᵢ = −dᵢ/|dᵢ|, and what is left to maximise is D(w) = −b·y − h·z − Σ|dᵢ|: five variables instead of
36, concave, and smooth where no dᵢ vanishes. Its optimum has b = Au and a complementary cone pair z, s = h − Gu of
one of three kinds: z = 0 and s inside; z = t(1, a) with |a| = 1, t > 0 and s = σ(1, −a); or, on a circular orbit, z inside
and s = 0. Newton keeps the kind it starts with, but goes from the first to the second where s leaves the cone.

A point counts as solved when its pair meets every line of docs/algorithm.md's table for
`SOLVED`; the stationarity line holds by construction. Whatever is left (no multipliers nearby, a cone to let go of, a node
without thrust, no solution at all) is for an interior-point method. Source of the dual: Boyd &
Vandenberghe, Convex Optimization, 2004, §5.1.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from orbsoc.orbit.array import Array, Flags, Index

from ..batch import Batch, column
from .condensed import CondensedBatch

INACTIVE, BOUNDARY, VERTEX = 0, 1, 2
"""Kinds of complementary cone pairs: z = 0; both on the cone's boundary; s = 0."""
NO_MULTIPLIER = 1e-6
"""A multiplier of the cone this small is none; it comes back where the cone is left."""
INSIDE = 1e-4
"""A multiplier this far inside its cone, relative to its size, means that the slack is at the vertex."""
STEPS = 12
"""Limit of Newton steps; from the subproblem before it takes two to four."""
BLOCK = 1024
"""Points in a block: what fits in a core's cache."""
LARGEST_TURN = 0.5
"""Of the cone's direction a, rad, in a step."""
LEAST_SHARE = 0.1
"""Of t that a step may leave."""
GROWTH = 4.0
"""A residual that grows by more in a step is no sign of a solution nearby."""


@dataclass(slots=True, eq=False)
class DualSolutions(Batch):
    """What Newton arrived at for B points: controls x (B, n), multipliers y (B, p) and z (B, 3) of the cone, which points are
    solved (B,), and the steps taken."""

    x: Array
    y: Array
    z: Array = column(0.0, 3)
    solved: Flags = column(False, dtype=bool)
    steps: NDArray[np.uint32] = column(0, dtype=np.uint32)


@dataclass(slots=True, eq=False)
class _Points(Batch):
    """Data and iterates of the points of a block, the first axis of each; `regime` has INACTIVE, BOUNDARY or VERTEX."""

    cost: Array
    slopes: Array
    rhs: Array
    equal: Array
    perigee: Array
    regime: NDArray[np.int8]


def solve_dual(batch: CondensedBatch, equal: Array, perigee: Array, tolerance: Array) -> DualSolutions:
    """Newton from multipliers `equal` (B, p) and `perigee` (B, 3); the batch has a perigee cone and no bounds. Tolerances (B,)."""
    p, n, count = batch.base.p, batch.base.n, len(batch)
    slopes = np.concatenate([batch.A.reshape(count, n, p), batch.G.reshape(count, n, 4)[:, :, 1:]], axis=2)
    rhs = np.concatenate([batch.b, batch.h[:, -3:]], axis=1)
    radius = np.sqrt(perigee[:, 1] ** 2 + perigee[:, 2] ** 2)
    inside = perigee[:, 0] - radius > INSIDE * perigee[:, 0]
    active = np.where(inside, VERTEX, BOUNDARY)
    regime = np.where(perigee[:, 0] <= NO_MULTIPLIER, INACTIVE, active).astype(np.int8)
    start = np.where((regime == INACTIVE)[:, None], 0.0, perigee)
    start[regime == BOUNDARY, 0] = radius[regime == BOUNDARY]
    here = _Points(batch.c, slopes, rhs, equal.copy(), start, regime)
    found = DualSolutions.blank(count, x=np.zeros((count, n)), y=np.zeros((count, p)))
    with np.errstate(all="ignore"):
        for first in range(0, count, BLOCK):
            part = np.arange(first, min(first + BLOCK, count))
            _newton(here[part], found, part, tolerance)
    return found


def _newton(here: _Points, found: DualSolutions, live: Index, tolerance: Array) -> None:
    """Step until each of the points `live` is solved or given up; `found` takes those that are solved."""
    before = np.full(live.size, np.inf)
    for step in range(STEPS + 1):
        pull, controls, length = _controls(here)
        slack = here.rhs - (here.slopes.transpose(0, 2, 1) @ controls[:, :, None])[:, :, 0]
        fresh = _enter_cone(here, slack, pull, length, tolerance[live])
        before[fresh] = np.inf
        error, axes = _errors(here, slack)
        worst = np.abs(error).max(axis=1)
        there = worst <= 0.1 * tolerance[live]
        if there.any():
            at, rows = here[there], live[there]
            _take(at, found, rows, controls[there], slack[there], length[there], tolerance[rows])
        going = np.flatnonzero(~there & (worst <= GROWTH * before))
        if not going.size or step == STEPS:
            return
        found.steps[live[going]] += 1
        if going.size < live.size:
            here, live, worst, slack = here[going], live[going], worst[going], slack[going]
            error, axes, pull, length = error[going], axes[going], pull[going], length[going]
        before = worst
        _advance(here, slack, error, axes, pull, length)


def _controls(here: _Points) -> tuple[Array, Array, Array]:
    """Unit vectors along d (B, N, 3), the controls (B, 3N) against them, and |dᵢ| (B, N)."""
    count = len(here.cost)
    w = np.concatenate([here.equal, here.perigee], axis=1)
    d = here.cost + (here.slopes @ w[:, :, None])[:, :, 0]
    length = np.sqrt((d * d) @ _per_node(d.shape[1]))
    unit = d / np.repeat(length, 3, axis=1)
    return unit.reshape(count, -1, 3), -unit, length


@cache
def _per_node(n: int) -> Array:
    """Sums the three components of every node: (n, n/3)."""
    return np.repeat(np.eye(n // 3), 3, axis=0)


def _enter_cone(here: _Points, slack: Array, pull: Array, length: Array, tolerance: Array) -> Index:
    """Give the points whose slack left the cone a multiplier on it: opposite to the slack, as long as Newton along it
    would make it. Returns these points."""
    p = here.equal.shape[1]
    radius = np.sqrt((slack[:, p + 1 :] ** 2).sum(axis=1))
    which = np.flatnonzero((here.regime == INACTIVE) & (radius - slack[:, p] > tolerance))
    if which.size:
        axis = np.hstack([np.ones((which.size, 1)), -slack[which, p + 1 :] / radius[which, None]])
        moves = (here.slopes[which, :, p:] @ axis[:, :, None]).reshape(which.size, -1, 3)
        along = np.einsum("bni,bni->bn", moves, pull[which])
        bend = ((np.einsum("bni,bni->bn", moves, moves) - along**2) / length[which]).sum(axis=1)
        here.perigee[which] = ((radius - slack[:, p])[which] / bend)[:, None] * axis
        here.regime[which] = BOUNDARY
    return which


def _errors(here: _Points, slack: Array) -> tuple[Array, Array]:
    """The equations' values (B, k), and the axes (B, p + 3, k) along which w moves, null where it does not: k = p + 3 with
    a point at the vertex, else p + 2."""
    count, p = here.equal.shape
    boundary, vertex = np.flatnonzero(here.regime == BOUNDARY), np.flatnonzero(here.regime == VERTEX)
    axes = np.zeros((count, p + 3, p + 3 if vertex.size else p + 2))
    axes[:, np.arange(p), np.arange(p)] = 1.0
    a = here.perigee[boundary, 1:] / here.perigee[boundary, :1]
    axes[boundary, p, p], axes[boundary, p + 1 :, p] = 1.0, a
    axes[boundary, p + 1, p + 1], axes[boundary, p + 2, p + 1] = -a[:, 1], a[:, 0]
    if vertex.size:
        axes[vertex[:, None], p + np.arange(3), p + np.arange(3)] = 1.0
    return (slack[:, None] @ axes)[:, 0], axes


def _advance(here: _Points, slack: Array, error: Array, axes: Array, pull: Array, length: Array) -> None:
    """Newton's step on the equations, in place; on the cone z turns by a bounded angle and stays positive."""
    (count, p), width = here.equal.shape, axes.shape[2]
    moves = axes.transpose(0, 2, 1) @ here.slopes.transpose(0, 2, 1)
    moves *= np.repeat(1.0 / np.sqrt(length), 3, axis=1)[:, None]
    along = (moves * pull.reshape(count, 1, -1)) @ _per_node(moves.shape[2])
    matrix = moves @ moves.transpose(0, 2, 1) - along @ along.transpose(0, 2, 1)
    boundary, vertex = here.regime == BOUNDARY, here.regime == VERTEX
    size = np.where(boundary, here.perigee[:, 0], 1.0)
    direction = np.where(boundary[:, None], here.perigee[:, 1:] / size[:, None], 0.0)
    matrix[:, p, p + 1] += np.where(boundary, error[:, p + 1] / size, 0.0)
    matrix[:, p + 1, p + 1] -= (slack[:, p + 1 :] * direction).sum(axis=1) / size
    matrix[:, p, p] += here.regime == INACTIVE
    matrix[:, p + 1, p + 1] += here.regime == INACTIVE
    if width == p + 3:
        matrix[:, p + 2, p + 2] += ~vertex
    matrix[~np.isfinite(matrix).all(axis=(1, 2))] = np.eye(width)
    try:
        step = -np.linalg.solve(matrix, error[:, :, None])[:, :, 0]
    except np.linalg.LinAlgError:
        step = -(np.linalg.pinv(matrix) @ error[:, :, None])[:, :, 0]
    here.equal += step[:, :p]
    turn = np.clip(step[:, p + 1] / size, -LARGEST_TURN, LARGEST_TURN)
    longer = np.maximum(size + step[:, p], LEAST_SHARE * size)
    cosine, sine = np.cos(turn), np.sin(turn)
    x, y = direction.T
    turned = np.stack([np.ones(count), cosine * x - sine * y, sine * x + cosine * y], axis=1)
    here.perigee[boundary] = (longer[:, None] * turned)[boundary]
    if width == p + 3:
        here.perigee[vertex] += step[vertex, p:]


def _take(
    at: _Points, found: DualSolutions, rows: Index, x: Array, slack: Array, length: Array, tolerance: Array
) -> None:
    """Check the pairs of some points, which are `rows` of `found`, and store those that are solutions."""
    p, z = at.equal.shape[1], at.perigee
    short, s = slack[:, :p], slack[:, p:]
    outside = np.maximum(np.sqrt((s[:, 1:] ** 2).sum(axis=1)) - s[:, 0], 0.0)
    beyond = np.maximum(np.sqrt((z[:, 1:] ** 2).sum(axis=1)) - z[:, 0], 0.0) / (1.0 + np.abs(z).max(axis=1))
    plane = np.abs(short).max(axis=1) / (1.0 + np.abs(at.rhs[:, :p]).max(axis=1))
    primal = np.maximum(plane, outside / (1.0 + np.abs(s).max(axis=1)))
    objective = (at.cost * x).sum(axis=1)
    dual = -(at.rhs[:, :p] * at.equal).sum(axis=1) - (at.rhs[:, p:] * z).sum(axis=1) - length.sum(axis=1)
    gap = np.abs(objective - dual) / (1.0 + np.minimum(np.abs(objective), np.abs(dual)))
    found.solved[rows] = np.maximum(np.maximum(primal, gap), beyond) <= tolerance
    found.x[rows], found.y[rows], found.z[rows] = x, at.equal, z
