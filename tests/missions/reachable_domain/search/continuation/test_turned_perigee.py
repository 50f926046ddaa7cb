"""Perigee directions that the convex sequence does not reach, by Newton from the natural one; the truth is that of a direct
transcription of the same burns."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from orbsoc.missions.reachable_domain.search.continuation.domain import Domain
from orbsoc.missions.reachable_domain.search.continuation.table import PointTable
from tests.missions.reachable_domain.cases import paper


def solved(inc_deg: float, raan_deg: float, heights_km: list[float], **perigee: Any) -> PointTable:
    return Domain.of(paper().with_changes(perigee=perigee)).solve_planes(
        np.array([inc_deg]), np.array([raan_deg]), np.array(heights_km)
    )


@pytest.mark.parametrize(
    ("inc_deg", "raan_deg", "height_km", "argp_deg", "sma_km"),
    [
        (28.18, 335.36, 100.0, 325.64, 7035.717),
        (36.30, 342.25, 150.0, 300.00, 7148.69),
        (20.30, 322.25, 400.0, 90.00, 7042.94),
    ],
)
def test_a_perigee_at_its_bound_in_a_far_direction_is_found(
    inc_deg: float, raan_deg: float, height_km: float, argp_deg: float, sma_km: float
) -> None:
    table = solved(inc_deg, raan_deg, [height_km], condition="equal", argp_deg=argp_deg)
    assert table["status"][0] == "reached", table["evidence"][0]
    assert table["origin"][0] == "perigee turned from its natural direction by Newton"
    assert table["a_km"][0] == pytest.approx(sma_km, abs=0.01)
    assert table["perigee_km"][0] == pytest.approx(height_km, abs=1e-3)
    assert table["argp_deg"][0] == pytest.approx(argp_deg, abs=1e-3)
    assert table["sma_error_rel"][0] <= 1e-6


def test_an_orbit_at_the_bound_is_not_called_the_largest_where_a_higher_perigee_gives_a_larger_one() -> None:
    """At ω = 30 degrees the orbit with its perigee at 350 km is larger than that at 250 km."""
    at_bound = solved(28.18, 335.36, [250.0, 350.0], condition="equal", argp_deg=30.0)
    assert at_bound["a_km"][1] > at_bound["a_km"][0] + 40.0
    table = solved(28.18, 335.36, [250.0], argp_deg=30.0)
    assert table["status"][0] == "not reached after these attempts"
    assert "may be circular" in table["evidence"][0]
