"""A domain ten times as long as wide, with a tip at either end: the kick stage whose edge 48 equal azimuths cut off."""

from __future__ import annotations

from functools import cache

import numpy as np

from orbsoc.missions.reachable_domain.search.continuation.boundary import (
    next_azimuths,
    resolved_boundary,
    solve_boundary,
)
from orbsoc.missions.reachable_domain.search.continuation.domain import Domain
from orbsoc.missions.reachable_domain.search.query.envelope import limits
from orbsoc.orbit import Elements
from orbsoc.orbit.planes import inclination_and_node
from orbsoc.reach import ReachableDomain, Verdict
from tests.missions.reachable_domain.cases import kick_stage


@cache
def solved() -> ReachableDomain:
    ready = Domain.of(kick_stage())
    return ReachableDomain(
        kick_stage(), ready.solve_planes(*ready.planes()).columns, resolved_boundary(ready)
    )


def test_the_limits_are_those_of_288_equal_azimuths_or_wider() -> None:
    """On the 288 azimuths themselves the curve is theirs; between them the tip reaches half a degree further."""
    found, azimuth = solved(), np.arange(288) * 1.25
    tilt = found.limit(azimuth, 200.0)
    inc, raan = np.rad2deg(
        inclination_and_node(found.domain.frame.tilted(np.deg2rad(tilt), np.deg2rad(azimuth)))
    )
    at_288 = [tilt.max(), inc.min(), inc.max(), raan.min(), raan.max()]
    np.testing.assert_allclose(at_288, [14.136, 43.236, 61.567, 14.451, 42.053], atol=0.01)
    # The tip, by azimuths 0.01 degree apart: 14.785 at azimuth 49.12.
    tip = found.limit(49.1225, 200.0)
    assert abs(tip - 14.7851) <= found.limit.error_deg(49.1225, 200.0)
    for row, reached in zip(limits(found), (43.236, 61.567, 14.451, 42.053), strict=True):
        outwards = 1.0 if row.limit.startswith("highest") else -1.0
        assert 0.0 < outwards * (row.whole_deg - reached) < 1.0
        assert 0.0 < row.whole_error_deg < 0.045


def test_the_stated_error_covers_azimuths_that_were_left_out() -> None:
    found = solved()
    assert not next_azimuths(found.scenario.boundary, found.boundary).size
    drawn = np.random.default_rng(11).uniform(0.0, 180.0, 40)
    again = solve_boundary(found.domain, np.append(drawn, np.linspace(48.9, 49.4, 20)))
    azimuth, tilt = again["azimuth_deg"], again["tilt_deg"]
    away = np.abs(found.limit(azimuth, 200.0) - tilt)
    assert (away <= found.limit.error_deg(azimuth, 200.0)).all()


def test_an_orbit_in_the_tip_is_not_denied() -> None:
    orbit = Elements(
        sma_m=(6378.137 + 300.0) * 1e3,
        ecc=50.0 / 6678.137,
        inc_rad=float(np.deg2rad(60.522)),
        raan_rad=float(np.deg2rad(40.965)),
        argp_rad=0.0,
        true_anomaly_rad=0.0,
    )
    assert solved().can_reach(orbit).verdict is not Verdict.BEYOND
