"""Rows of the conditions at instants, as matrices on what an arc begins with, the state just after an impulse: M · state + c in a cone.

With thrust that is held it begins with a state and the velocity change of the arc.

Outside the keep-out is not convex: at each instant the flight stays beyond a plane that touches it, with a given normal. The
speed limit by range uses the range along a given direction, which is no longer than the range.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import cos, radians, tan

import numpy as np

from orbsoc.guidance.impulses import ImpulseProgramme
from orbsoc.orbit.array import Array, Index

from .approach import Approach
from .instants import AWAY, CORRIDOR, HALF_SPACE, HOLD, KEEP_OUT, SPEED, Instant, arrays

ROOM_M = 2e-3
"""By which every condition is kept better at its instants, for the time between them."""
WORTH_M = {SPEED: 100.0, **dict.fromkeys((KEEP_OUT, CORRIDOR, HALF_SPACE, HOLD, AWAY), 1.0)}
"""Of a unit of a row, m: a speed by the time that a metre takes."""


def heights(approach: Approach) -> dict[str, int]:
    """Rows of each condition at an instant. A flight in the plane has none across it."""
    across = 0 if approach.planar else 1
    cones = {CORRIDOR: 2 + across, SPEED: 3 + across, HOLD: 3 + across}
    return {KEEP_OUT: 1, HALF_SPACE: 1, AWAY: 1} | cones


def rows_of(
    approach: Approach, kind: str, instants: Sequence[Instant], about: Reference, normals: Array | None
) -> tuple[Array, Array]:
    """Matrices (S, rows, 6), or (S, rows, 9) of thrust that is held, and constants (S, rows); `normals` (K, 3) are those of the
    planes of each arc."""
    arcs, times, fractions = arrays(instants)
    to = approach.responses(times, arcs, fractions)
    if kind == KEEP_OUT:
        axes = approach.outer_m
        sight = about.sight(arcs, to, fractions, axes) if normals is None else normals[arcs]
        matrix = (axes.min() * sight / axes)[:, None] @ to[:, :3]
        return matrix, np.full((len(arcs), 1), -axes.min() - ROOM_M)
    if kind == CORRIDOR:
        return _corridor(approach, arcs, to)
    if kind == HALF_SPACE:
        half_space = approach.scenario.half_space
        assert half_space is not None
        matrix = half_space.direction()[None, None] @ to[:, :3]
        return matrix, np.full((len(arcs), 1), -half_space.at_least_m - ROOM_M)
    if kind == SPEED:
        return _speed(approach, to, about.direction(arcs, times, to))
    if kind == HOLD:
        return _hold(approach, arcs, to)
    assert normals is not None
    row = np.array([4.0, 0.0, 0.0, 0.0, 2.0 / approach.mean_motion_rad_s, 0.0])
    return -(normals[arcs, 1:2, None] * row), np.zeros((len(arcs), 1))


class Reference:
    """A flight that planes and directions are seen from: what its arcs begin with, as `problem.flown` tells it, and the impulses;
    without one directions are those of straight lines between the points."""

    def __init__(self, approach: Approach, programme: ImpulseProgramme | None, states: Array | None) -> None:
        self.approach, self.programme, self.states = approach, programme, states

    def sight(self, arcs: Index, to: Array, fractions: Array, axes: Array) -> Array:
        """The directions, in semi-axes, in which the flight is then, (S, 3)."""
        assert self.states is not None
        assert self.programme is not None
        states = self.states[arcs]
        if not self.approach.held:
            states[:, 3:] -= (1.0 - fractions[:, None]) * self.programme.dv_m_s[arcs]
        return _unit(np.einsum("sij,sj->si", to[:, :3], states) / axes)

    def direction(self, arcs: Index, times: Array, to: Array) -> Array:
        """The directions of the places then, (S, 3)."""
        if self.states is None:
            return _unit(straight(self.approach, times))
        return _unit(np.einsum("sij,sj->si", to[:, :3], self.states[arcs]))


def _unit(places: Array) -> Array:
    return np.asarray(places / np.maximum(np.linalg.norm(places, axis=1, keepdims=True), 1e-9))


def straight(approach: Approach, times_s: Array) -> Array:
    """Positions (S, 3) on straight lines between the points."""
    times, places = [0.0], [approach.start[:3]]
    for point in approach.scenario.points.values():
        times += [point.arrive_s, point.leave_s]
        places += 2 * [point.position()]
    return np.array([np.interp(times_s, times, column) for column in np.array(places).T]).T


def _corridor(approach: Approach, arcs: Index, to: Array) -> tuple[Array, Array]:
    corridor = approach.scenario.corridor
    assert corridor is not None
    axis, angle = corridor.direction(), radians(corridor.half_angle_deg)
    across = np.linalg.svd(axis[None])[2][1:]
    if approach.planar:
        across = np.array([[-axis[1], axis[0], 0.0]])
    steps = tan(angle)
    matrix = np.vstack([steps * axis, across]) @ to[:, :3]
    margins = approach.corridor_margins(arcs)
    less = (margins + np.minimum(ROOM_M, 0.1 * margins)) / cos(angle)
    constant = np.zeros((len(to), 1 + len(across)))
    constant[:, 0] = -steps * corridor.apex_m - less
    return matrix, constant


def _speed(approach: Approach, to: Array, sight: Array) -> tuple[Array, Array]:
    speed = approach.scenario.speed
    assert speed is not None
    along = speed.by_range_per_s * sight[:, None] @ to[:, :3]
    matrix = np.concatenate([along, to[:, 3 : 5 if approach.planar else 6]], axis=1)
    constant = np.zeros(matrix.shape[:2])
    constant[:, 0] = speed.at_target_m_s
    return matrix, constant


def _hold(approach: Approach, arcs: Index, to: Array) -> tuple[Array, Array]:
    many = 2 if approach.planar else 3
    matrix = np.concatenate([np.zeros((len(to), 1, to.shape[2])), to[:, :many]], axis=1)
    constant = np.empty((len(to), 1 + many))
    for s, t in enumerate(approach.times_s[arcs].tolist()):
        point = next(point for _, point in approach.holds() if point.arrive_s <= t < point.leave_s)
        constant[s, 0] = point.hold_within_m - min(ROOM_M, 0.1 * point.hold_within_m)
        constant[s, 1:] = -point.position()[:many]
    return matrix, constant
