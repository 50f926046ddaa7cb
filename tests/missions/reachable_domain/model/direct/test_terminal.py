"""Linearised terminal conditions: against the exact ones."""

from __future__ import annotations

import numpy as np
import pytest

from orbsoc.missions.reachable_domain.model.direct.terminal import LargestOrbit, LargestTilt
from orbsoc.orbit.planes import cross, in_plane_axes
from tests.missions.reachable_domain.three_planes import GUESS, TARGET, TILT


@pytest.mark.parametrize("target", [TARGET, TILT], ids=["orbit", "tilt"])
def test_terminal_rows_are_the_first_order_expansion(target: LargestOrbit | LargestTilt) -> None:
    """Rows at the reference have the value of the exact conditions, and their slope by finite differences."""
    ends = GUESS.ends
    rows, step = target.rows(ends), 1e-6

    def exact(at: np.ndarray) -> np.ndarray:
        """Objective and equalities (1 + p, B) at end states, by their definitions."""
        momentum = cross(at[:, :3], at[:, 3:])
        if isinstance(target, LargestTilt):
            hinge = cross(target.frame.normal, target.frame.directions(target.azimuth))
            return np.stack([target.tilts(at), (hinge * momentum).sum(axis=1)])
        energy = 0.5 * (at[:, 3:] ** 2).sum(axis=1) - 1.0 / np.linalg.norm(at[:, :3], axis=1)
        return np.stack([energy, *((axis * momentum).sum(axis=1) for axis in in_plane_axes(target.normal))])

    for j in range(6):
        nudge = step * np.eye(6)[j]
        slope = (exact(ends + nudge) - exact(ends - nudge)) / (2.0 * step)
        np.testing.assert_allclose(-rows.cost[:, j], slope[0], atol=1e-8)
        np.testing.assert_allclose(rows.equal[:, :, j].T, slope[1:], atol=1e-8)
    at_reference = (rows.equal @ ends[:, :, None])[..., 0] - rows.equal_rhs
    np.testing.assert_allclose(at_reference.T, exact(ends)[1:], atol=1e-13)
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
