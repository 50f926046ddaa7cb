"""The launch by Kane's equations, as the paper has them, with forces and torques on the platform."""

from __future__ import annotations

from math import cos, sin, sqrt

import numpy as np
from numpy.typing import NDArray

from .launch import LaunchError, Pair, integrated

Array = NDArray[np.float64]

LONGEST = 100.0
"""Times as long as the push alone would take, after which a server is held to stay."""


def accelerations(pair: Pair, q: Array) -> Array:
    """Second derivatives (4,) of q = (x, z, θ, s) from q and its rates (8,). The paper, eqs. (41) to (46).

    The lateral reaction of the tube does no work and does not appear. The server turns with the tube, so that its own
    inertia belongs to the row of the yaw.
    """
    body, m = pair.assembly, pair.server_mass_kg
    (cx, cz), (rx, rz) = body.centre_m, pair.place_m + np.array([0.0, q[3]])
    s, c = sin(q[2]), cos(q[2])
    turn, slide = q[6], q[7]
    mass = body.mass_kg
    ahead = mass * (c * cx - s * cz) + m * (c * rx - s * rz)  # Σ m (A r), x
    above = mass * (s * cx + c * cz) + m * (s * rx + c * rz)
    about = body.inertia_kg_m2 + pair.server_inertia_kg_m2
    about += mass * (cx**2 + cz**2) + m * (rx**2 + rz**2)
    matrix = np.array(
        [
            [mass + m, 0.0, -above, -m * s],
            [0.0, mass + m, ahead, m * c],
            [-above, ahead, about, m * rx],
            [-m * s, m * c, m * rx, m],
        ]
    )
    fx, fz = pair.thrust_n
    side = np.array(
        [
            turn**2 * ahead + 2.0 * m * c * turn * slide + c * fx - s * fz,
            turn**2 * above + 2.0 * m * s * turn * slide + s * fx + c * fz,
            -2.0 * m * rz * turn * slide + pair.torque_n_m,
            m * rz * turn**2 + pair.force_n,
        ]
    )
    return np.asarray(np.linalg.solve(matrix, side))


def integrate(pair: Pair, times_s: Array) -> Array:
    """q and its rates (K, 8) at increasing times (K,), the first of them the start, by DOP853."""
    return integrated(lambda q: np.concatenate([q[4:], accelerations(pair, q)]), pair.start, times_s)


def until(pair: Pair, slide_m: float) -> tuple[float, Array]:
    """When the server has slid so far, s, and q with its rates then (8,); Newton's method on the time of integration.

    Raises LaunchError where it does not get there.
    """
    mass = pair.assembly.mass_kg
    usual = sqrt(2.0 * slide_m / pair.force_n * pair.server_mass_kg * mass / (pair.server_mass_kg + mass))
    t, q = usual, pair.start
    for _ in range(50):
        q = integrate(pair, np.array([0.0, t]))[-1]
        step = (slide_m - q[3]) / q[7] if q[7] > 0.0 else np.inf
        if not 0.0 < t + step < LONGEST * usual:
            break
        t += step
        if abs(step) <= 4e-16 * t or abs(slide_m - q[3]) <= 1e-15:
            return t, integrate(pair, np.array([0.0, t]))[-1]
    allowed = "the platform's thrust and torque hold the server in its tube"
    raise LaunchError(f"force_n = {pair.force_n:g}: {allowed}; it must leave it")
