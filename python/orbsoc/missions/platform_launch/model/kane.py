"""The launch by Kane's equations, as the paper has them, with forces and torques on the platform."""

from __future__ import annotations

from math import cos, sin, sqrt

import numpy as np

from orbsoc.orbit.array import Array

from .launch import RTOL, LaunchError, Pair, integrated

ROUGH = 1e-6
"""Of the integrations that come near to the end of a slide."""
HELD = "the platform's thrust and torque hold the server in its tube; it must leave it"
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


def integrate(pair: Pair, times_s: Array, rtol: float = RTOL) -> Array:
    """q and its rates (K, 8) at increasing times (K,), the first of them the start, by DOP853."""

    def rate(q: Array) -> Array:
        return np.concatenate([q[4:], accelerations(pair, q)])

    return integrated(rate, pair.start, times_s, rtol)


def until(pair: Pair, slide_m: float) -> tuple[float, Array]:
    """When the server has slid so far, s, and q with its rates then (8,): Newton's method, roughly and then exactly.

    Raises LaunchError where it does not get there.
    """
    mass = pair.assembly.mass_kg
    usual = sqrt(2.0 * slide_m / pair.force_n * pair.server_mass_kg * mass / (pair.server_mass_kg + mass))
    t = usual
    for rtol in (ROUGH, RTOL):
        for _ in range(50):
            q = integrate(pair, np.array([0.0, t]), rtol)[-1]
            step = (slide_m - q[3]) / q[7] if q[7] > 0.0 else np.inf
            if not 0.0 < t + step < LONGEST * usual:
                raise LaunchError(f"force_n = {pair.force_n:g}: {HELD}")
            if abs(step) <= 10.0 * rtol * t:
                break
            t += step
    return t, q
