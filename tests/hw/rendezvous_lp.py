"""A rendezvous as a linear programme: least sum of |Δv| from a Clohessy–Wiltshire drift to the origin."""

from __future__ import annotations

import numpy as np

from orbsoc import Cones, Problem

MEAN_MOTION_RAD_S = 1.1e-3


def transition(dt_s: float) -> np.ndarray:
    """In-plane Clohessy–Wiltshire transition, state [x_m, y_m, vx, vy], x radial, y along track."""
    n, s, c = MEAN_MOTION_RAD_S, np.sin(MEAN_MOTION_RAD_S * dt_s), np.cos(MEAN_MOTION_RAD_S * dt_s)
    return np.array(
        [
            [4 - 3 * c, 0, s / n, 2 * (1 - c) / n],
            [6 * (s - n * dt_s), 1, 2 * (c - 1) / n, (4 * s - 3 * n * dt_s) / n],
            [3 * n * s, 0, c, 2 * s],
            [6 * n * (c - 1), 0, -2 * s, 4 * c - 3],
        ]
    )


def rendezvous_lp(impulses: int = 12, dt_s: float = 240.0) -> Problem:
    """Variables: Δv⁺ and Δv⁻ of each axis and impulse, all ≥ 0, m/s; 1 km below and 5 km behind to the target."""
    start = np.array([-1000.0, -5000.0, 0.0, 1.5])
    columns = [transition((impulses - 1 - k) * dt_s)[:, 2:] for k in range(impulses)]
    effect = np.hstack([np.hstack([block, -block]) for block in columns])
    scale = np.array([1e-3, 1e-3, 1.0, 1.0])  # positions in km
    drift = transition((impulses - 1) * dt_s) @ start
    size = effect.shape[1]
    return Problem(
        c=np.ones(size), A=scale[:, None] * effect, b=-scale * drift, G=-np.eye(size), h=np.zeros(size),
        cones=Cones(l=size),
    )  # fmt: skip
