"""The motion next to an extremal: δÿ = K(t) δy with y = (r, p), and the matrices K."""

from __future__ import annotations

import numpy as np

from orbsoc.orbit.array import Array


def variational_matrices(thrust: Array, nodes: Array) -> Array:
    """K = [[G, k(I − p̂p̂ᵀ)/|p|], [∂(Gp)/∂r, G]] at nodes of B extremals, (nodes, B, 6, 6).

    `nodes` (nodes, 6, B) are [r, p] and `thrust` (nodes,) the accelerations k. G = 3rrᵀ/|r|⁵ − I/|r|³ and
    ∂(Gp)/∂r = 3(rpᵀ + prᵀ + (r·p)I)/|r|⁵ − 15(r·p)rrᵀ/|r|⁷.
    """
    r, p = nodes[:, :3].transpose(1, 0, 2), nodes[:, 3:].transpose(1, 0, 2)
    square = r[0] * r[0] + r[1] * r[1] + r[2] * r[2]
    along = (r[0] * p[0] + r[1] * p[1] + r[2] * p[2]) / square
    size = np.sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2])
    kappa = 1.0 / (square * np.sqrt(square))
    steer, five = thrust[:, None] / size, 3.0 * kappa / square
    unit, scaled, leant = p / size, five * r, p - (5.0 * along) * r
    out = np.empty((6, 6, *square.shape))
    for i in range(3):
        for j in range(i, 3):
            gravity = scaled[i] * r[j]
            turn = -steer * unit[i] * unit[j]
            bend = scaled[i] * leant[j] + five * p[i] * r[j]
            if i == j:
                gravity -= kappa
                turn += steer
                bend += 3.0 * kappa * along
            out[i, j] = out[j, i] = out[3 + i, 3 + j] = out[3 + j, 3 + i] = gravity
            out[i, 3 + j] = out[j, 3 + i] = turn
            out[3 + i, j] = out[3 + j, i] = bend
    return np.ascontiguousarray(out.transpose(2, 3, 0, 1))
