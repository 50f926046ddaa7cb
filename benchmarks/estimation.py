"""Estimation: a vehicle's track from measurements with outliers."""

from __future__ import annotations

import numpy as np

from orbsoc.conic.builder import ConicBuilder
from orbsoc.conic.problem import Problem

WEIGHT, KNEE = 2.0, 0.5
"""Weight of the measurements against the forces, and the residual beyond which they cost linearly, m."""


def robust_kalman(steps: int, seed: int) -> Problem:
    """min Σ‖w_k‖² + 2·Σ φ(‖v_k‖), x_{k+1} = A x_k + B w_k, y_k = C x_k + v_k, a fifth of the y being wild.

    States: position (m) and velocity (m/s) in a plane, with drag; w: force, v: error of the measured position. Huber's
    φ of ‖v‖ as min ½a² + ρb, ‖v‖ ≤ a + b, b ≥ 0. Form: Boyd & Vandenberghe 2004, §6.1 and 7.1, and CVXPY's example.
    """
    random = np.random.default_rng(11_000 * steps + seed)
    dt, drag = 4.0 / steps, 0.05
    half = 1.0 - 0.5 * drag * dt
    motion = np.eye(4)
    motion[:2, 2:] = half * dt * np.eye(2)
    motion[2:, 2:] = (1.0 - drag * dt) * np.eye(2)
    pushed = np.vstack([0.5 * dt**2 * np.eye(2), dt * np.eye(2)])
    measured = np.zeros((steps, 2))
    state = np.array([0.0, 0.0, *random.uniform(-1.0, 1.0, 2)])
    for k in range(steps):
        wild = 20.0 if random.random() < 0.2 else 1.0
        measured[k] = state[:2] + 0.1 * wild * random.standard_normal(2)
        state = motion @ state + pushed @ random.standard_normal(2)

    b = ConicBuilder()
    x, w = b.variable("x", (steps + 1, 4)), b.variable("w", (steps, 2))
    v, a, excess = b.variable("v", (steps, 2)), b.variable("a", steps), b.variable("excess", steps)
    b.quadratic_cost(w.index.ravel(), 2.0 * np.eye(2 * steps))
    b.quadratic_cost(a, 2.0 * WEIGHT * np.eye(steps))
    b.cost(excess, 2.0 * WEIGHT * KNEE)
    under = np.vstack([np.zeros((1, 2)), -np.eye(2)])
    for k in range(steps):
        b.equality([(x.index[k + 1], np.eye(4)), (x.index[k], -motion), (w.index[k], -pushed)], np.zeros(4))
        b.equality([(x.index[k, :2], np.eye(2)), (v.index[k], np.eye(2))], measured[k])
        b.nonnegative([(excess.index[k : k + 1], -np.ones((1, 1)))], [0.0])
        sum_of = np.array([[-1.0, -1.0], [0.0, 0.0], [0.0, 0.0]])
        b.second_order([([a.index[k], excess.index[k]], sum_of), (v.index[k], under)], np.zeros(3))
    return b.build()
