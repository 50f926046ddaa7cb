"""Three planes with their perigee bounds, and cold arcs towards them, for the tests of subproblems and conditions."""

from __future__ import annotations

import numpy as np

from orbsoc.missions.reachable_domain.model.direct.guess import towards_planes
from orbsoc.missions.reachable_domain.model.direct.terminal import LargestOrbit, LargestTilt
from orbsoc.orbit.planes import normals
from tests.missions.reachable_domain.cases import domain, perigees

PLANES = normals(np.deg2rad([28.18, 20.3, 33.3]), np.deg2rad([335.36, 322.25, 340.25]))
PERIGEES = perigees(100.0, 250.0, 400.0)
TARGET = LargestOrbit(PLANES, PERIGEES)
TILT = LargestTilt(domain().frame, np.array([0.3, 2.0, 5.0]), PERIGEES)
COLLOCATION = domain().tools.collocation(12)
GUESS = towards_planes(COLLOCATION, PLANES)
