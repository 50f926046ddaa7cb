"""Objective and terminal conditions: derivatives against finite differences."""

from __future__ import annotations

import numpy as np
import pytest

from orbsoc.missions.reachable_domain.model.direct.terminal import LargestOrbit
from orbsoc.missions.reachable_domain.model.indirect.conditions import conditions, curvature
from orbsoc.orbit.planes import in_plane_axes
from tests.missions.reachable_domain.three_planes import GUESS, PERIGEES, PLANES, TARGET


@pytest.mark.parametrize("target", [TARGET, LargestOrbit(PLANES, PERIGEES, in_plane_axes(PLANES)[0])])
def test_gradients_and_curvature_agree_with_finite_differences(target: LargestOrbit) -> None:
    ends, step = GUESS.ends, 1e-6
    multipliers = np.random.default_rng(3).normal(size=(3, 4))
    here, bend = conditions(target, ends), curvature(target, ends, multipliers)
    for j in range(6):
        nudge = step * np.eye(6)[j]
        ahead, behind = conditions(target, ends + nudge), conditions(target, ends - nudge)
        slope = (ahead.values - behind.values) / (2 * step)
        np.testing.assert_allclose(here.gradients[:, :, j], slope, atol=1e-8)
        total = [c.objective + (multipliers[:, :, None] * c.gradients).sum(axis=1) for c in (ahead, behind)]
        np.testing.assert_allclose(bend[:, :, j], (total[0] - total[1]) / (2 * step), atol=1e-7)
