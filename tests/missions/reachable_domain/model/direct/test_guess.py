"""Cold starts, and arcs on another grid."""

from __future__ import annotations

import numpy as np

from orbsoc.missions.reachable_domain.model.direct.guess import resampled
from orbsoc.orbit.planes import plane_error
from tests.missions.reachable_domain.cases import domain
from tests.missions.reachable_domain.three_planes import COLLOCATION, GUESS, PLANES


def test_a_guess_resampled_to_a_finer_grid_is_the_same_arc() -> None:
    fine = domain().tools.collocation(24)
    there = resampled(COLLOCATION, GUESS, fine)
    back = resampled(fine, there, COLLOCATION)
    np.testing.assert_allclose(back.positions, GUESS.positions, atol=1e-8)
    np.testing.assert_allclose(np.linalg.norm(there.controls, axis=2), 1.0, atol=1e-12)
    assert plane_error(GUESS.ends, PLANES).max() < 0.2
