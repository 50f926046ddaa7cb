"""The bound on the altitude at the nodes."""

from __future__ import annotations

import numpy as np

from orbsoc.missions.reachable_domain.model.direct.condensed import altitude_rows
from tests.missions.reachable_domain.three_planes import COLLOCATION, GUESS


def test_altitude_rows_bound_the_projected_radius() -> None:
    linear = COLLOCATION.end_map(GUESS)
    rows, rhs = altitude_rows(COLLOCATION, linear, GUESS, np.full(3, 1.01))
    found = COLLOCATION.arcs(linear, GUESS.controls)
    outward = GUESS.positions / np.linalg.norm(GUESS.positions, axis=2)[..., None]
    slack = rhs - (rows @ GUESS.controls.reshape(3, -1, 1))[..., 0]
    np.testing.assert_allclose(slack, (outward * found.positions).sum(axis=2) - 1.01, atol=1e-12)
