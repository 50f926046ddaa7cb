"""Landing with six degrees of freedom: the subproblems that successive convexification solves one after the other.

State (14): mass, position (z up), velocity, attitude quaternion (body to inertial, scalar first), body rates. Control
(3): thrust in body axes, the vehicle's axis being z. No aerodynamics. Free final time, first-order hold, virtual
control with an exact penalty, and a trust region at each node.
Form: Szmuk & Açıkmeşe 2018. The numbers are this repository's, in units of a lander of mass 2 under gravity 1.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse as _scipy_sparse

from orbsoc.conic.builder import ConicBuilder, Variable
from orbsoc.conic.problem import Problem
from orbsoc.interfaces import clarabel

Array = NDArray[np.float64]
sparse: Any = _scipy_sparse  # published without types

STATES, CONTROLS = 14, 3
GRAVITY = 1.0
WET_MASS, DRY_MASS, FLOW = 2.0, 1.0, 0.05
"""Masses, and mass per time and thrust."""
LEAST_THRUST, MOST_THRUST = 0.6, 5.0
GIMBAL_RAD, TILT_RAD, SLOPE_RAD = np.radians([20.0, 60.0, 70.0])
"""Largest angles of thrust to axis, axis to vertical, and line of sight from the pad to vertical."""
MOST_RATE = 1.0
INERTIA = np.array([0.04, 0.04, 0.02])
LEVER = np.array([0.0, 0.0, -0.1])
"""From the centre of mass to the gimbal, body axes."""
PENALTY, TRUST, TIME_TRUST = 1e2, 1e-2, 1e-2
"""Weights of virtual control (1-norm), of the trust regions' radii, and of the change of the final time."""
SUBSTEPS = 6


@dataclass(frozen=True, slots=True)
class Reference:
    """What is linearised about: states (nodes, 14), controls (nodes, 3), final time."""

    states: Array
    controls: Array
    duration: float


def first_reference(nodes: int, seed: int) -> Reference:
    """A straight line from a start drawn to the pad, upright, thrust against weight."""
    random = np.random.default_rng(7000 * nodes + seed)
    start = np.zeros(STATES)
    start[0], start[7] = WET_MASS, 1.0
    start[1:4] = [*random.uniform(-2.0, 2.0, 2), random.uniform(4.0, 5.0)]
    start[4:7] = [*random.uniform(-0.5, 0.5, 2), random.uniform(-1.5, -0.5)]
    end = np.zeros(STATES)
    end[0], end[6], end[7] = 0.5 * (WET_MASS + DRY_MASS), -0.1, 1.0
    share = np.linspace(0.0, 1.0, nodes)[:, None]
    states = (1.0 - share) * start + share * end
    controls = np.zeros((nodes, CONTROLS))
    controls[:, 2] = states[:, 0] * GRAVITY
    return Reference(states, controls, 5.0)


def six_dof(nodes: int, seed: int) -> Problem:
    """The first subproblem of a landing."""
    return subproblem(first_reference(nodes, seed))


def landing(nodes: int, seed: int, count: int) -> Iterator[Problem]:
    """The first `count` subproblems. Clarabel solves them, so that they are the same at every commit of orbsoc."""
    reference = first_reference(nodes, seed)
    for _ in range(count):
        problem = subproblem(reference)
        yield problem
        x = clarabel.solve(problem).x
        states, controls = np.split(x[: nodes * (STATES + CONTROLS)], [nodes * STATES])
        reference = Reference(
            states.reshape(nodes, STATES),
            controls.reshape(nodes, CONTROLS),
            float(x[nodes * (STATES + CONTROLS)]),
        )


def subproblem(reference: Reference) -> Problem:
    """The convex problem about a reference: least propellant, virtual control and departure from the reference."""
    nodes = reference.states.shape[0]
    b = ConicBuilder()
    x, u, duration = b.variable("x", (nodes, STATES)), b.variable("u", (nodes, CONTROLS)), b.variable("T", 1)
    virtual, size = b.variable("virtual", (nodes - 1, STATES)), b.variable("size", (nodes - 1, STATES))
    radius, later = b.variable("radius", nodes), b.variable("later", 1)
    b.cost(x.index[-1, :1], -1.0)
    b.cost(size, PENALTY)
    b.cost(radius, TRUST)
    b.cost(later, TIME_TRUST)
    b.equality([(x.index[0], np.eye(STATES))], reference.states[0])
    b.equality([(x.index[-1, 1:], np.eye(STATES - 1))], [0, 0, 0, 0, 0, -0.1, 1, 0, 0, 0, 0, 0, 0])
    _motion(b, reference, x, u, duration, virtual)
    pair = np.vstack([np.eye(STATES), -np.eye(STATES)])
    for k in range(nodes - 1):
        b.nonnegative(
            [(virtual.index[k], pair), (size.index[k], -np.tile(np.eye(STATES), (2, 1)))],
            np.zeros(2 * STATES),
        )
    change = np.array([[1.0], [-1.0]])
    b.nonnegative([(duration, change), (later, -np.ones((2, 1)))], [reference.duration, -reference.duration])
    b.nonnegative([(later, np.ones((1, 1)))], [0.2 * reference.duration])
    for k in range(nodes):
        _limits(b, reference, k, x, u)
        below = -np.eye(1 + STATES + CONTROLS)
        there = np.concatenate([[0.0], -reference.states[k], -reference.controls[k]])
        b.second_order([([radius.index[k], *x.index[k], *u.index[k]], below)], there)
    return b.build()


def _limits(b: ConicBuilder, reference: Reference, k: int, x: Variable, u: Variable) -> None:
    """What state and thrust must obey at node k; the thrust's lower bound is linearised."""
    direction = reference.controls[k] / np.linalg.norm(reference.controls[k])
    b.nonnegative([(x.index[k, :1], -np.ones((1, 1)))], [-DRY_MASS])
    every = sparse.coo_array(
        (-direction, (np.zeros(CONTROLS, int), np.arange(CONTROLS))), shape=(1, CONTROLS)
    )
    b.nonnegative([(u.index[k], every)], [-LEAST_THRUST])
    slope = np.array([[0.0, 0.0, np.tan(SLOPE_RAD)], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    b.second_order([(x.index[k, 1:4], -slope)], np.zeros(3))
    under = np.vstack([np.zeros((1, 2)), -np.eye(2)])
    b.second_order([(x.index[k, 8:10], under)], [np.sqrt(0.5 * (1.0 - np.cos(TILT_RAD))), 0.0, 0.0])
    under = np.vstack([np.zeros((1, 3)), -np.eye(3)])
    b.second_order([(x.index[k, 11:14], under)], [MOST_RATE, 0.0, 0.0, 0.0])
    b.second_order([(u.index[k], under)], [MOST_THRUST, 0.0, 0.0, 0.0])
    gimbal = np.vstack([[0.0, 0.0, 1.0 / np.cos(GIMBAL_RAD)], np.eye(3)])
    b.second_order([(u.index[k], -gimbal)], np.zeros(4))


def _motion(
    b: ConicBuilder, reference: Reference, x: Variable, u: Variable, duration: Variable, virtual: Variable
) -> None:
    """x' = A x + B u + C u' + D T + constant + virtual control, over each step."""
    ends, jacobians = linearised(reference)
    pattern = _pattern()
    for k, (end, J) in enumerate(zip(ends, jacobians, strict=True)):
        about = np.concatenate(
            [
                reference.states[k],
                reference.controls[k],
                reference.controls[k + 1],
                [reference.duration],
            ]
        )
        columns = [*x.index[k], *u.index[k], *u.index[k + 1], duration.index[0]]
        block = sparse.coo_array((-J[pattern], np.nonzero(pattern)), shape=J.shape)
        eye = np.eye(STATES)
        b.equality([(x.index[k + 1], eye), (columns, block), (virtual.index[k], -eye)], end - J @ about)


def linearised(reference: Reference) -> tuple[Array, Array]:
    """End of each step (nodes − 1, 14) and its derivatives (nodes − 1, 14, 21) by state, both controls and duration.

    Fourth-order Runge–Kutta, differentiated by complex steps: exact derivatives of what is integrated.
    """
    steps = reference.states.shape[0] - 1
    about = np.hstack(
        [
            reference.states[:-1],
            reference.controls[:-1],
            reference.controls[1:],
            np.full((steps, 1), reference.duration),
        ]
    )
    width = about.shape[1]
    tiny = 1e-30
    seeds: NDArray[np.complex128] = about[:, :, None] + 1j * tiny * np.eye(width)[None]
    seeds = seeds.transpose(1, 0, 2)  # (21, steps, 21): value, step, direction
    state, before, after, duration = seeds[:14], seeds[14:17], seeds[17:20], seeds[20]
    h = duration / (steps * SUBSTEPS)
    for j in range(SUBSTEPS):
        at = [(1.0 - s) * before + s * after for s in (np.array([j, j + 0.5, j + 1.0]) / SUBSTEPS)]
        k1 = _rate(state, at[0])
        k2 = _rate(state + 0.5 * h * k1, at[1])
        k3 = _rate(state + 0.5 * h * k2, at[1])
        k4 = _rate(state + h * k3, at[2])
        state = state + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
    return state[:, :, 0].real.T.copy(), (state.imag / tiny).transpose(1, 0, 2)


def _rate(x: Any, thrust: Any) -> Any:
    """dx/dt, shape (14, …), of states (14, …) and thrusts (3, …), real or complex."""
    w, i, j, k = x[7:11]
    t1, t2, t3 = thrust
    p, q, r = x[11:14]
    pushed = np.stack(
        [
            (w * w + i * i - j * j - k * k) * t1 + 2.0 * (i * j - w * k) * t2 + 2.0 * (i * k + w * j) * t3,
            2.0 * (i * j + w * k) * t1 + (w * w - i * i + j * j - k * k) * t2 + 2.0 * (j * k - w * i) * t3,
            2.0 * (i * k - w * j) * t1 + 2.0 * (j * k + w * i) * t2 + (w * w - i * i - j * j + k * k) * t3,
        ]
    )
    turn = 0.5 * np.stack(
        [
            -i * p - j * q - k * r,
            w * p + j * r - k * q,
            w * q + k * p - i * r,
            w * r + i * q - j * p,
        ]
    )
    a, b, c = INERTIA
    arm = LEVER[2]
    spin = np.stack(
        [
            (-arm * t2 - (c - b) * q * r) / a,
            (arm * t1 - (a - c) * r * p) / b,
            -(b - a) * p * q / c,
        ]
    )
    velocity = pushed / x[0]
    velocity[2] = velocity[2] - GRAVITY
    mass = -FLOW * np.sqrt(t1 * t1 + t2 * t2 + t3 * t3)
    return np.concatenate([mass[None], x[4:7], velocity, turn, spin])


def _pattern() -> NDArray[np.bool_]:
    """Which derivatives are not zero by the equations, whatever the reference: one pattern for all subproblems."""
    random = np.random.default_rng(0)
    states, controls = random.uniform(0.5, 1.5, (2, STATES)), random.uniform(0.5, 1.5, (2, CONTROLS))
    [J] = linearised(Reference(states, controls, 1.0))[1]
    pattern: NDArray[np.bool_] = J != 0.0
    return pattern
