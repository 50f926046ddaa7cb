"""Cold starts, many at once: thrust along the velocity and back towards the target plane."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from orbsoc.guidance.collocation import interpolation_matrix
from orbsoc.orbit.array import Array

from .arcs import Arcs, Collocation

Rate = Callable[[float, Array], Array]

GAIN = 2.0
"""Of the plane error in the steering law v̂ − GAIN (v·n)n."""
SUBSTEPS = 2
"""Runge–Kutta steps between neighbouring nodes: a reference needs no digits."""


def towards_planes(collocation: Collocation, normal: Array) -> Arcs:
    """Burns that steer along v̂ − 2(v·n)n, normalised, for normals (B, 3); v canonical."""
    burn = collocation.burn
    state = np.repeat(burn.start[None], len(normal), axis=0)

    def steering(velocity: Array) -> Array:
        ahead = velocity / np.linalg.norm(velocity, axis=1, keepdims=True)
        ahead -= GAIN * (velocity * normal).sum(axis=1, keepdims=True) * normal
        return np.asarray(ahead / np.linalg.norm(ahead, axis=1, keepdims=True))

    def rate(time: float, x: Array) -> Array:
        thrust = burn.thrust_acceleration(np.array(time))
        pull = -x[:, :3] / np.linalg.norm(x[:, :3], axis=1, keepdims=True) ** 3
        return np.hstack([x[:, 3:], pull + thrust * steering(x[:, 3:])])

    time, positions, controls = 0.0, [], []
    for stop in 0.5 * collocation.duration * (np.append(collocation.grid.nodes, 1.0) + 1.0):
        step = (stop - time) / SUBSTEPS
        for _ in range(SUBSTEPS):
            state, time = _runge_kutta(rate, time, state, step), time + step
        positions.append(state[:, :3])
        controls.append(steering(state[:, 3:]))
    return Arcs(np.stack(positions[:-1], axis=1), np.stack(controls[:-1], axis=1), state)


def resampled(old: Collocation, arcs: Arcs, new: Collocation) -> Arcs:
    """Arcs of one grid on another, controls normalised."""
    points, at = np.append(-1.0, old.grid.nodes), new.grid.nodes
    start = np.broadcast_to(old.burn.start[:3], (len(arcs), 1, 3))
    positions = interpolation_matrix(points, at) @ np.concatenate([start, arcs.positions], axis=1)
    controls = interpolation_matrix(old.grid.nodes, at) @ arcs.controls
    controls /= np.linalg.norm(controls, axis=2, keepdims=True)
    return Arcs(positions, controls, arcs.ends, arcs.multipliers)


def _runge_kutta(rate: Rate, time: float, x: Array, step: float) -> Array:
    """One classical step of fourth order."""
    k1 = rate(time, x)
    k2 = rate(time + 0.5 * step, x + 0.5 * step * k1)
    k3 = rate(time + 0.5 * step, x + 0.5 * step * k2)
    k4 = rate(time + step, x + step * k3)
    return np.asarray(x + step / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4))
