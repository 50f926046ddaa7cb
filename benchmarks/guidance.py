"""Guidance and control problems: powered descent, rendezvous, predictive control of a quadrotor."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import linalg as _linalg

from orbsoc.conic.builder import ConicBuilder, Variable
from orbsoc.conic.problem import Problem

Array = NDArray[np.float64]

linalg: Any = _linalg  # published without types


def powered_descent(nodes: int, seed: int) -> Problem:
    """Land with least propellant: thrust between two bounds, a glide slope and a tilt limit; n = 11 · nodes + 7.

    States at nodes + 1 points: position (km, z up), velocity (100 m/s), ln(mass/initial mass); controls held over
    each step: acceleration u and its bound σ (10 m/s²). Lossless relaxation ‖u‖ ≤ σ of the thrust annulus, whose
    bounds, in ln mass, are linearised about burning at full thrust: the lower one from below, so a little loose.
    Form: Açıkmeşe & Ploen 2007; the numbers are this repository's, of a small lander on Mars.
    """
    random = np.random.default_rng(1000 * nodes + seed)
    flight_s = 70.0
    dt = flight_s / nodes
    gravity = np.array([0.0, 0.0, -0.371])
    most, least, burn_per_s = 1.3, 0.4, 0.0048  # 10 m/s², 10 m/s², share of mass per second at σ = 1
    start = np.array([*random.uniform(-0.5, 0.5, 2), 2.0 + random.uniform(0.0, 0.4)])
    velocity = np.array([*random.uniform(-0.3, 0.3, 2), -0.6 + random.uniform(-0.1, 0.1)])

    b = ConicBuilder()
    r, v, z = b.variable("r", (nodes + 1, 3)), b.variable("v", (nodes + 1, 3)), b.variable("z", nodes + 1)
    u, sigma = b.variable("u", (nodes, 3)), b.variable("sigma", nodes)
    b.cost(z.index[-1:], [-1.0])
    eye = np.eye(3)
    _fix(b, r, 0, start)
    _fix(b, v, 0, velocity)
    _fix(b, r, nodes, np.zeros(3))
    _fix(b, v, nodes, np.zeros(3))
    b.equality([(z.index[:1], np.ones((1, 1)))], [0.0])
    along, pushed = 0.1 * dt, 0.005 * dt**2  # km per 100 m/s; km per 10 m/s² held for dt
    faster = 0.1 * dt  # 100 m/s per 10 m/s²
    for k in range(nodes):
        b.equality(
            [
                (r.index[k + 1], eye),
                (r.index[k], -eye),
                (v.index[k], -along * eye),
                (u.index[k], -pushed * eye),
            ],
            pushed * gravity,
        )
        b.equality([(v.index[k + 1], eye), (v.index[k], -eye), (u.index[k], -faster * eye)], faster * gravity)
        step = np.array([[1.0, -1.0, burn_per_s * dt]])
        b.equality([([*z.index[k : k + 2][::-1], sigma.index[k]], step)], [0.0])
        reference = np.log(1.0 - burn_per_s * most * dt * k)
        for bound, sign in ((most, 1.0), (least, -1.0)):
            scale = bound * np.exp(-reference)
            row = sign * np.array([[1.0, scale]])
            b.nonnegative([([sigma.index[k], z.index[k]], row)], [sign * scale * (1.0 + reference)])
        b.second_order([([sigma.index[k], *u.index[k]], -np.eye(4))], np.zeros(4))
        b.nonnegative(
            [([sigma.index[k], u.index[k, 2]], np.array([[np.cos(np.radians(70.0)), -1.0]]))], [0.0]
        )
    slope = np.diag([np.tan(np.radians(75.0)), 1.0, 1.0])[:, [1, 2, 0]]
    for k in range(1, nodes):
        b.second_order([(r.index[k], -slope)], np.zeros(3))
    return b.build()


def rendezvous(nodes: int, seed: int, *, approach_cone: bool = True) -> Problem:
    """Reach a point below the target with least Σ‖Δv‖: impulses bounded, an approach cone over the last third or none.

    Clohessy–Wiltshire motion over one revolution, z to the centre of attraction, x along the target's velocity;
    lengths in km, time in radians of the target's orbit, so that speeds are in km · mean motion.
    """
    random = np.random.default_rng(2000 * nodes + seed)
    transition: Array = linalg.expm(_clohessy_wiltshire() * (2.0 * np.pi / nodes))
    start = np.array([-8.0, 1.0, 2.0, 0.0, 0.0, 0.0]) + 0.3 * random.standard_normal(6)
    b = ConicBuilder()
    x = b.variable("x", (nodes + 1, 6))
    impulse, size = b.variable("impulse", (nodes, 3)), b.variable("size", nodes)
    b.cost(size, 1.0)
    _fix(b, x, 0, start)
    _fix(b, x, nodes, np.array([0.0, 0.0, 0.2, 0.0, 0.0, 0.0]))
    pushed = transition[:, 3:]
    for k in range(nodes):
        b.equality(
            [(x.index[k + 1], np.eye(6)), (x.index[k], -transition), (impulse.index[k], -pushed)], np.zeros(6)
        )
        b.second_order([([size.index[k], *impulse.index[k]], -np.eye(4))], np.zeros(4))
        b.nonnegative([(size.index[k : k + 1], np.ones((1, 1)))], [3.0])
    if not approach_cone:
        return b.build()
    opening = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    for k in range(nodes - nodes // 3, nodes):
        b.second_order([(x.index[k, :3], -opening)], np.zeros(3))  # ‖(x, y)‖ ≤ z
    return b.build()


def quadrotor(nodes: int, seed: int) -> Problem:
    """Fly to the origin: least ½Σ(xᵀQx + uᵀRu), bounded motors, tilt (cone of 3) and speed (cone of 4).

    Linear about hovering; states position (m), velocity (m/s), tilt and heading (rad), rates (rad/s); controls
    specific thrust above hovering (m/s²) and three angular accelerations (rad/s²), held for 0.1 s.
    """
    random = np.random.default_rng(3000 * nodes + seed)
    motion, control = _hovering()
    stacked = np.zeros((16, 16))
    stacked[:12, :12], stacked[:12, 12:] = motion, control
    discrete: Array = linalg.expm(0.1 * stacked)[:12]
    b = ConicBuilder()
    x, u = b.variable("x", (nodes + 1, 12)), b.variable("u", (nodes, 4))
    start = np.concatenate([random.uniform(-3.0, 3.0, 3), random.uniform(-0.5, 0.5, 3), np.zeros(6)])
    _fix(b, x, 0, start)
    weights = np.diag([10.0] * 3 + [1.0] * 3 + [0.5] * 3 + [0.1] * 3)
    effort = np.diag([0.1, 0.02, 0.02, 0.02])
    limits = np.array([6.0, 20.0, 20.0, 8.0])
    for k in range(nodes):
        b.equality(
            [(x.index[k + 1], np.eye(12)), (x.index[k], -discrete[:, :12]), (u.index[k], -discrete[:, 12:])],
            np.zeros(12),
        )
        b.quadratic_cost(u.index[k], effort)
        b.quadratic_cost(x.index[k + 1], 10.0 * weights if k == nodes - 1 else weights)
        b.nonnegative([(u.index[k], np.vstack([np.eye(4), -np.eye(4)]))], np.tile(limits, 2))
        below = np.vstack([np.zeros((1, 2)), -np.eye(2)])
        b.second_order([(x.index[k + 1, 6:8], below)], [0.35, 0.0, 0.0])
        below = np.vstack([np.zeros((1, 3)), -np.eye(3)])
        b.second_order([(x.index[k + 1, 3:6], below)], [2.0, 0.0, 0.0, 0.0])
    return b.build()


def _fix(b: ConicBuilder, variable: Variable, k: int, value: Array) -> None:
    b.equality([(variable.index[k], np.eye(value.size))], value)


def _clohessy_wiltshire() -> Array:
    """d[r, v]/dt about a circular orbit of mean motion 1, x along velocity, y −normal, z to the centre."""
    a = np.zeros((6, 6))
    a[:3, 3:] = np.eye(3)
    a[3, 5] = 2.0
    a[4, 1] = -1.0
    a[5, 2], a[5, 3] = 3.0, -2.0
    return a


def _hovering() -> tuple[Array, Array]:
    """dx/dt = A x + B u of a rigid body that hovers, angles roll, pitch, yaw."""
    a, b = np.zeros((12, 12)), np.zeros((12, 4))
    a[:3, 3:6] = np.eye(3)
    a[6:9, 9:12] = np.eye(3)
    a[3, 7], a[4, 6] = 9.81, -9.81
    b[5, 0] = 1.0
    b[9:, 1:] = np.eye(3)
    return a, b
