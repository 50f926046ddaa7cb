"""`can_reach`: nobody is promised an orbit that is not reachable, and what it states of its errors holds."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from orbsoc.missions.reachable_domain.boundary import furthest_planes
from orbsoc.missions.reachable_domain.domain import Domain
from orbsoc.missions.reachable_domain.table import PointStatus
from orbsoc.orbit import Elements
from orbsoc.reach import ReachableDomain, Verdict
from orbsoc.reach.largest import LargestOrbits
from tests.missions.reach_cases import paper

GRID = {
    "inclination_deg": {"first": 24.3, "last": 34.3, "step": 2.0},
    "raan_deg": {"first": 325.25, "last": 345.25, "step": 2.0},
    "perigee_height_km": {"first": 100.0, "last": 500.0, "step": 50.0},
}
EDGE = {"azimuths": 32, "perigee_height_km": {"first": 100.0, "last": 500.0, "step": 100.0}}


@cache
def solved() -> ReachableDomain:
    scenario = paper().with_changes(grid=GRID, boundary=EDGE)
    ready = Domain.of(scenario)
    edge = furthest_planes(ready, np.arange(16) * 180.0 / 16)
    return ReachableDomain(scenario, ready.solve_planes(*ready.planes()).columns, edge)


def orbit(a_km: float, argp_deg: float, *, height_km: float = 300.0, inc_deg: float = 28.18) -> Elements:
    """On the current node."""
    ecc = max(0.0, 1.0 - (6378.137 + height_km) / a_km)
    return Elements(1e3 * a_km, ecc, np.deg2rad(inc_deg), np.deg2rad(335.36), np.deg2rad(argp_deg), 0.0)


NATURAL_DEG = 209.0
"""About where the largest orbit of the current plane has its perigee; it is 24 860 km large."""


def test_an_ellipse_turned_by_90_degrees_is_not_promised_and_exactly_refused() -> None:
    """With its perigee there the largest orbit of the plane is 7 283 km large, not 24 860."""
    turned = orbit(21500.0, NATURAL_DEG + 90.0)
    rough = solved().can_reach(turned)
    assert rough.verdict is Verdict.PERIGEE_FREE
    assert "its own was not looked at" in rough.words
    assert "exact=True" in rough.words
    exact = solved().can_reach(turned, exact=True)
    assert exact.verdict is Verdict.BEYOND
    assert exact.burn is not None
    assert exact.burn.left_s < -600.0
    assert "more than there is" in exact.words


def test_the_same_ellipse_the_right_way_round_is_reached_by_a_burn_that_was_flown() -> None:
    found = solved().can_reach(orbit(21500.0, NATURAL_DEG), exact=True)
    assert found.verdict is Verdict.WITHIN
    assert found.burn is not None
    assert found.burn.verified
    assert found.burn.duration_s == pytest.approx(1157.2, abs=0.5)


def test_the_largest_orbit_with_a_turned_perigee_takes_the_whole_burn() -> None:
    """Problem C with ω fixed and problem A know nothing of each other: at the largest orbit they must agree."""
    turned = paper().with_changes(perigee={"argp_deg": NATURAL_DEG + 20.0, "condition": "equal"})
    largest = Domain.of(turned).solve_planes([28.18], [335.36], [300.0])["a_km"][0]
    inside = solved().can_reach(orbit(largest - 20.0, NATURAL_DEG + 20.0), exact=True)
    outside = solved().can_reach(orbit(largest + 20.0, NATURAL_DEG + 20.0), exact=True)
    assert (inside.verdict, outside.verdict) == (Verdict.WITHIN, Verdict.BEYOND)
    assert inside.burn is not None
    assert 0.0 < inside.burn.left_s < 1.0


def test_a_burn_that_does_not_fly_to_its_orbit_is_no_promise() -> None:
    """Near the end of what is possible the steering turns around within seconds; no grid holds it, and no one says so."""
    found = solved().can_reach(orbit(7270.0, NATURAL_DEG + 90.0), exact=True)
    assert found.verdict is Verdict.NOT_FLOWN
    assert "not confirmed in flight" in found.words


@pytest.mark.parametrize("exact", [False, True])
def test_a_circular_orbit_has_no_perigee_to_turn(exact: bool) -> None:
    found = solved().can_reach(orbit(6678.137, 0.0), exact=exact)
    assert found.circular
    assert found.verdict is Verdict.WITHIN


def test_the_domain_with_its_perigee_free_rules_out_what_is_too_large() -> None:
    for exact in (False, True):
        found = solved().can_reach(orbit(30000.0, NATURAL_DEG), exact=exact)
        assert found.verdict is Verdict.BEYOND
        assert found.burn is None


def test_planes_outside_the_search_box_are_called_so_and_solved_when_asked() -> None:
    outside = orbit(6678.137, 0.0, inc_deg=36.0)
    rough = solved().can_reach(outside)
    assert rough.verdict is Verdict.OUTSIDE
    assert rough.verdict == PointStatus.OUTSIDE
    assert "no largest semi-major axis known" in rough.words
    assert solved().can_reach(outside, exact=True).verdict is Verdict.WITHIN


def test_a_bound_on_the_altitude_is_kept_by_the_burn_onto_an_orbit() -> None:
    """The shortest burn onto this one passes 152 km high."""
    high = paper().with_changes(grid=GRID, boundary=EDGE, burn={"minimum_altitude_km": 170.0})
    bounded = ReachableDomain(high, solved().points, solved().boundary)
    found = bounded.can_reach(orbit(21500.0, NATURAL_DEG), exact=True)
    assert found.verdict is Verdict.NOT_FLOWN
    assert "below the bound of 170 km" in found.words


def test_the_stated_error_of_the_semi_major_axis_holds_for_held_out_orbits() -> None:
    """Twenty-five at random, three axes; three hundred on the paper's grid were all covered (docs/reach.md)."""
    found, draw = solved(), np.random.default_rng(11)
    checked = 0
    for inc, raan, height in draw.uniform([24.3, 325.25, 100.0], [34.3, 345.25, 500.0], (25, 3)):
        value, error = found.largest(inc, raan, height)
        truth = found.domain.solve_planes([inc], [raan], [height])["a_km"][0]
        if np.isfinite(value):
            assert abs(value - truth) <= error, (inc, raan, height)
            checked += np.isfinite(error)
    assert checked >= 15


def test_the_height_counts_in_the_error_and_coarse_nodes_do_not_hide_it() -> None:
    """A table that bends in height only, read on a node of inclination and node."""
    axes = np.array([20.0, 21.0, 22.0]), np.array([330.0, 331.0, 332.0]), np.arange(100.0, 501.0, 100.0)
    bend = np.maximum(0.0, axes[2] - 250.0)
    table = LargestOrbits.of(axes, np.broadcast_to(20000.0 - 10.0 * bend, (3, 3, 5)).ravel())
    value, error = table(21.0, 331.0, 250.0)
    assert value == pytest.approx(19750.0)
    assert error >= 125.0
    assert table(21.0, 331.0, 300.0) == (pytest.approx(19500.0), pytest.approx(1e-3))
    assert np.isnan(table(21.0, 331.0, 90.0)[0])
    assert table(21.0, 331.5, 150.0)[0] == pytest.approx(20000.0)


def test_next_to_the_edge_and_on_tiny_grids_the_error_is_not_small() -> None:
    axes = np.array([20.0, 21.0, 22.0]), np.array([330.0, 331.0]), np.array([100.0])
    values = np.array([9000.0, 9000.0, 8000.0, 8000.0, np.nan, np.nan])
    table = LargestOrbits.of(axes, values)
    assert table(20.5, 330.0, 100.0) == (pytest.approx(8500.0), np.inf)
    assert np.isnan(table(21.5, 330.0, 100.0)[0])
    assert table(20.0, 330.0, 100.0) == (pytest.approx(9000.0), pytest.approx(1e-3))
