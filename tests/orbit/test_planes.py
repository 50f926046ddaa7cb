"""Orbital planes by inclination and node, and by tilt and azimuth."""

from __future__ import annotations

import numpy as np
import pytest

from orbsoc.orbit.planes import TiltFrame, inclination_and_node, normals
from tests.missions.reachable_domain.cases import domain
from tests.missions.reachable_domain.three_planes import PLANES


def test_planes_survive_the_way_there_and_back() -> None:
    inc, raan = inclination_and_node(PLANES)
    np.testing.assert_allclose(normals(inc, raan), PLANES, atol=1e-15)
    frame: TiltFrame = domain().frame
    tilt, azimuth = frame.tilt_and_azimuth(PLANES)
    np.testing.assert_allclose(frame.tilted(tilt, azimuth), PLANES, atol=1e-14)
    current_inc, current_raan = np.rad2deg(inclination_and_node(frame.normal))
    assert current_inc == pytest.approx(28.18, abs=1e-3)
    assert current_raan == pytest.approx(335.36, abs=1e-3)
    higher, _node = np.rad2deg(inclination_and_node(frame.tilted(0.01, 0.0)))
    assert higher == pytest.approx(current_inc + np.rad2deg(0.01), abs=1e-9)
