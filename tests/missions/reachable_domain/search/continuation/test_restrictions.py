"""What restricts the domain further: the perigee's direction, its height from both sides, bounds that no orbit meets."""

from __future__ import annotations

import numpy as np
import pytest

from orbsoc.missions.reachable_domain.search.continuation.boundary import solve_boundary
from orbsoc.missions.reachable_domain.search.continuation.domain import Domain
from orbsoc.missions.reachable_domain.search.continuation.table import PointStatus, PointTable
from tests.missions.reachable_domain.cases import paper

INC, RAAN = np.array([28.3]), np.array([335.25])


def solved(height_km: float, **changes: dict[str, object]) -> PointTable:
    return Domain.of(paper().with_changes(**changes)).solve_planes(INC, RAAN, np.array([height_km]))


@pytest.mark.parametrize("argp_deg", [30.0, 120.0, 160.0, 200.0, 280.0])
def test_a_plan_whose_perigee_lies_elsewhere_is_not_counted(argp_deg: float) -> None:
    """At 30 degrees the indirect equations lead to a perigee at 210; at 280 the steering swings within seconds."""
    table = solved(150.0, perigee={"argp_deg": argp_deg})
    if argp_deg == 30.0:
        assert table["status"][0] == PointStatus.NOT_REACHED.value
        assert "may be circular" in table["evidence"][0]
    else:
        assert table["status"][0] == PointStatus.REACHED.value
        turned = np.deg2rad(table["argp_deg"][0] - argp_deg)
        assert 2.0 * table["ecc"][0] * abs(np.sin(0.5 * turned)) <= 1e-6


def test_a_perigee_at_its_bound_keeps_the_altitude_too() -> None:
    """Newton alone dives below 120 km on the way; the largest orbit with the perigee above its bound is larger."""
    bound = {"minimum_altitude_km": 120.0}
    perigee_at_bound = solved(200.0, burn=bound, perigee={"condition": "equal"})
    above = solved(200.0, burn=bound)
    assert perigee_at_bound["status"][0] == above["status"][0] == PointStatus.REACHED.value
    assert perigee_at_bound["perigee_km"][0] == pytest.approx(200.0, abs=1e-3)
    assert perigee_at_bound["lowest_km"][0] >= 119.999
    assert above["perigee_km"][0] > 201.0
    assert perigee_at_bound["a_km"][0] < above["a_km"][0]


def test_a_bound_that_no_orbit_meets_is_no_failure_of_the_solver() -> None:
    table = solved(2100.0)
    assert table["status"][0] == PointStatus.NOT_REACHED.value
    assert "no subproblem is feasible" in table["evidence"][0]
    heights = {"first": 100.0, "last": 2100.0, "step": 2000.0}
    edge = solve_boundary(
        Domain.of(paper().with_changes(boundary={"perigee_height_km": heights})), np.array([0.0])
    )
    assert set(edge["status"][edge["perigee_bound_km"] == 2100.0]) == {PointStatus.NOT_REACHED.value}
    assert np.isfinite(edge["tilt_deg"][edge["perigee_bound_km"] == 100.0]).all()
