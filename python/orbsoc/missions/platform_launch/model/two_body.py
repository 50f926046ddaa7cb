"""The launch as two bodies with the forces between them: Newton and Euler, and what the tube does to the server.

It shares no equation with Kane's nor with the closed form. Unknown at every instant are the accelerations of both
bodies, their common angular acceleration, the tube's lateral force and its couple.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from orbsoc.orbit.array import Array

from .launch import TURN, Pair, axes, integrated


@dataclass(frozen=True, slots=True, eq=False)
class TwoBodies:
    """A launch at times_s (K,): q with its rates (K, 8), the tube's lateral force on the server (K,), N, along the
    platform's x, and its couple (K,), N m."""

    times_s: Array
    states: Array
    lateral_n: Array
    couple_n_m: Array


def _solved(pair: Pair, y: Array, field: Array) -> Array:
    """Accelerations of the assembly (2,) and the server (2,), angular acceleration, lateral force and couple, (7,).

    y: positions of both centres of mass (4,), yaw, and their rates, (10,); field (4,): accelerations from outside.
    """
    body, m = pair.assembly, pair.server_mass_kg
    x, z = axes(y[4]).T
    d, closing, turn = y[2:4] - y[:2], y[7:9] - y[5:7], y[9]
    push = pair.force_n * z
    thrust = axes(y[4]) @ pair.thrust_n

    def moment(arm: Array, force: Array) -> float:
        return float(arm[0] * force[1] - arm[1] * force[0])

    lever = -axes(y[4]) @ body.centre_m  # from the assembly's centre to the platform's, where the thrust acts
    rows = np.zeros((7, 7))
    side = np.empty(7)
    rows[:2, :2], rows[:2, 5] = body.mass_kg * np.eye(2), x
    side[:2] = thrust - push + body.mass_kg * field[:2]
    rows[2:4, 2:4], rows[2:4, 5] = m * np.eye(2), -x
    side[2:4] = push + m * field[2:]
    rows[4, 4], rows[4, 5], rows[4, 6] = body.inertia_kg_m2, moment(d, x), 1.0
    side[4] = pair.torque_n_m + moment(lever, thrust) - moment(d, push)
    rows[5, 4], rows[5, 6] = pair.server_inertia_kg_m2, -1.0
    side[5] = 0.0
    # The server stays on the axis of the tube: the second derivative of d · x = const.
    rows[6, :2], rows[6, 2:4], rows[6, 4] = -x, x, d @ z
    side[6] = turn**2 * (d @ x) - 2.0 * turn * (closing @ z)
    return np.asarray(np.linalg.solve(rows, side))


def integrate(
    pair: Pair, times_s: Array, *, platform: Array | None = None, rate_rad_s: float = 0.0
) -> TwoBodies:
    """Integrate from rest of the server in the tube to increasing times (K,), the first of them the start, by DOP853.

    With `rate_rad_s`, the orbital rate of the target, both bodies feel the Clohessy–Wiltshire accelerations at their
    places beside it, with the platform at `platform` (4,), x, z and rates: then q holds them too. Raises LaunchError.
    """
    times = np.asarray(times_s, np.float64)
    base = np.zeros(4) if platform is None else platform
    at = axes(pair.yaw_rad)
    offsets = np.array([at @ pair.assembly.centre_m, at @ pair.place_m])
    start = np.empty(10)
    start[:4] = (base[:2] + offsets).ravel()
    start[4] = pair.yaw_rad
    start[5:9] = (base[2:] + pair.yaw_rate_rad_s * offsets @ TURN.T).ravel()
    start[9] = pair.yaw_rate_rad_s
    n = rate_rad_s

    def field(y: Array) -> Array:
        ahead = [-2.0 * n * y[6], 3.0 * n**2 * y[1] + 2.0 * n * y[5]]
        return np.array([*ahead, -2.0 * n * y[8], 3.0 * n**2 * y[3] + 2.0 * n * y[7]])

    def rate(y: Array) -> Array:
        return np.concatenate([y[5:], _solved(pair, y, field(y))[:5]])

    rows = integrated(rate, start, times)
    states = np.empty((times.size, 8))
    forces = np.array([_solved(pair, y, field(y))[5:] for y in rows])
    for k, y in enumerate(rows):
        body_axes = axes(y[4])
        centre = body_axes @ pair.assembly.centre_m
        d, closing = y[2:4] - y[:2], y[7:9] - y[5:7]
        states[k, :2] = y[:2] - centre
        states[k, 4:6] = y[5:7] - y[9] * TURN @ centre
        states[k, 2], states[k, 6] = y[4], y[9]
        slid = pair.place_m - pair.assembly.centre_m
        states[k, 3] = d @ body_axes[:, 1] - slid[1]
        states[k, 7] = closing @ body_axes[:, 1] - y[9] * (d @ body_axes[:, 0])
    return TwoBodies(times, states, forces[:, 0], forces[:, 1])
