"""The linearised motion by Picard iteration."""

from __future__ import annotations

import numpy as np

from orbsoc.missions.reachable_domain.model.direct.picard import GravityGradient, solve_picard
from tests.missions.reachable_domain.three_planes import COLLOCATION


def test_motion_that_the_sweeps_do_not_settle_is_factorised() -> None:
    """Deep in the well of gravity, many revolutions: Picard's iteration diverges long before it converges."""
    positions = np.full((12, 3, 2), 0.03)
    positions[:, :, 1] = 0.6
    gravity = GravityGradient.at(positions)
    constant = np.random.default_rng(1).normal(size=(12, 3, 2))
    found = solve_picard(COLLOCATION.double_integral, gravity, constant)
    left = np.tensordot(np.linalg.inv(COLLOCATION.double_integral), found, axes=1) - gravity.times(found)
    scale = np.abs(np.linalg.inv(COLLOCATION.double_integral)).max() + np.abs(gravity.dense()).max()
    np.testing.assert_allclose(left, constant, atol=1e-12 * scale * max(1.0, np.abs(found).max()))
