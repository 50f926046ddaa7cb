"""Linearised terminal conditions: against the exact ones."""

from __future__ import annotations

import numpy as np
import pytest

from orbsoc.missions.reachable_domain.model.direct.terminal import LargestOrbit, LargestTilt
from orbsoc.missions.reachable_domain.model.indirect.conditions import conditions
from orbsoc.orbit.planes import cross
from tests.missions.reachable_domain.three_planes import GUESS, TARGET, TILT


@pytest.mark.parametrize("target", [TARGET, TILT], ids=["orbit", "tilt"])
def test_terminal_rows_are_the_first_order_expansion(target: LargestOrbit | LargestTilt) -> None:
    """Rows at the reference have the value of the exact conditions, and their slope."""
    ends = GUESS.ends
    rows, exact = target.rows(ends), conditions(target, ends)
    np.testing.assert_allclose(-rows.cost, exact.objective, atol=1e-13)
    np.testing.assert_allclose(rows.equal, exact.gradients[:, : rows.equal.shape[1]], atol=1e-13)
    at_reference = (rows.equal @ ends[:, :, None])[..., 0] - rows.equal_rhs
    np.testing.assert_allclose(at_reference, exact.values[:, : rows.equal.shape[1]], atol=1e-13)
    head = rows.cone_rhs - (rows.cone @ ends[:, :, None])[..., 0]
    momentum = cross(ends[:, :3], ends[:, 3:])
    laplace = cross(ends[:, 3:], momentum) - ends[:, :3] / np.linalg.norm(ends[:, :3], axis=1)[:, None]
    normal = (
        target.normal
        if isinstance(target, LargestOrbit)
        else target.frame.tilted(target.tilts(ends), target.azimuth)
    )
    np.testing.assert_allclose(
        head[:, 0], (momentum * normal).sum(axis=1) ** 2 / target.perigee - 1.0, atol=1e-12
    )
    in_plane = laplace - (laplace * normal).sum(axis=1)[:, None] * normal
    np.testing.assert_allclose(
        np.linalg.norm(head[:, 1:], axis=1), np.linalg.norm(in_plane, axis=1), atol=1e-12
    )
