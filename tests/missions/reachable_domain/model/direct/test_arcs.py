"""Collocated burns: the end state as an affine function of the controls."""

from __future__ import annotations

import numpy as np

from tests.missions.reachable_domain.three_planes import COLLOCATION, GUESS


def test_the_end_map_meets_the_collocation_equations() -> None:
    """D R + d₀r₀ = hV and D V + d₀v₀ = h(ĝ + G(R − R̂) + kU), and the quadrature of the end."""
    linear = COLLOCATION.end_map(GUESS)
    controls = np.random.default_rng(1).normal(size=GUESS.controls.shape)
    found = COLLOCATION.arcs(linear, controls)
    grid, half, start = COLLOCATION.grid, 0.5 * COLLOCATION.duration, COLLOCATION.burn.start
    radius = np.linalg.norm(GUESS.positions, axis=2)[..., None]
    away = found.positions - GUESS.positions
    pull = -GUESS.positions / radius**3 - away / radius**3
    pull += 3.0 * GUESS.positions * (GUESS.positions * away).sum(axis=2)[..., None] / radius**5
    rate = pull + COLLOCATION.thrust[:, None] * controls
    v = COLLOCATION.velocities(found.positions)
    left = grid.differentiation[:, 1:] @ v + np.outer(grid.differentiation[:, 0], start[3:])
    np.testing.assert_allclose(left, half * rate, atol=1e-11)
    np.testing.assert_allclose(
        found.ends[:, 3:], start[3:] + half * np.einsum("n,bni->bi", grid.weights, rate), atol=1e-11
    )
    np.testing.assert_allclose(
        found.ends[:, :3], start[:3] + half * np.einsum("n,bni->bi", grid.weights, v), atol=1e-11
    )
