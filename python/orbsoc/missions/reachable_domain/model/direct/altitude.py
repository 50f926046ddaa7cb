"""The minimum altitude as bounds on the controls: r̂ᵢ·Rᵢ ≥ ρ at the nodes, which implies |Rᵢ| ≥ ρ."""

from __future__ import annotations

import numpy as np

from orbsoc.orbit.array import Array

from .arcs import Arcs, Collocation, EndMap


def altitude_rows(
    collocation: Collocation, linear: EndMap, about: Arcs, lowest: Array
) -> tuple[Array, Array]:
    """Rows (B, N, 3N) and right-hand sides (B, N) of −r̂ᵢ·Rᵢ ≤ −ρ for smallest radii (B,), canonical.

    The direction r̂ᵢ is the reference's: a half-space that the sphere of radius ρ lies behind, so what the rows allow is
    allowed by the sphere too.
    """
    count, n = about.positions.shape[:2]
    outward = about.positions / np.linalg.norm(about.positions, axis=2, keepdims=True)
    inverse = collocation.inverse(about.positions).reshape(count, n, 3, 3 * n)
    rows = -np.einsum("bni,bnij->bnj", outward, inverse)
    rhs = np.einsum("bni,ni->bn", outward, collocation.straight) - lowest[:, None]
    rhs -= np.einsum("bnj,bj->bn", rows, linear.offset.reshape(count, -1))
    return rows * np.repeat(collocation.thrust, 3), rhs
