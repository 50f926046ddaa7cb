"""`can_reach`: no orbit is promised that is not reachable."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from orbsoc.missions.reachable_domain.search.continuation.boundary import solve_boundary
from orbsoc.missions.reachable_domain.search.continuation.domain import Domain
from orbsoc.missions.reachable_domain.search.continuation.table import PointStatus
from orbsoc.orbit import Elements, elements_from_state, propagate_burn, state_from_elements
from orbsoc.reach import OrbitError, ReachableDomain, Verdict
from tests.missions.reachable_domain.cases import paper

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
    edge = solve_boundary(ready, np.arange(16) * 180.0 / 16)
    return ReachableDomain(scenario, ready.solve_planes(*ready.planes()).columns, edge)


def bounded(altitude_km: float) -> ReachableDomain:
    """The same tables, of a burn that must keep an altitude: outer limits of its own."""
    high = paper().with_changes(grid=GRID, boundary=EDGE, burn={"minimum_altitude_km": altitude_km})
    return ReachableDomain(high, solved().points, solved().boundary)


@cache
def in_orbit(*, thrust_n: float, mass_flow_kg_s: float, duration_s: float) -> ReachableDomain:
    """The domain of 20 t in a circular orbit 400 km high on the paper's plane, on 2 × 2 planes and two heights."""
    position, velocity = state_from_elements(orbit(6778.137, 0.0, height_km=400.0))
    scenario = paper().with_changes(
        vehicle={"mass_kg": 20000.0, "thrust_n": thrust_n, "mass_flow_kg_s": mass_flow_kg_s},
        initial={"position_m": tuple(position), "velocity_m_s": tuple(velocity)},
        burn={"duration_s": duration_s},
        grid={
            "inclination_deg": {"first": 28.1, "last": 28.3, "step": 0.2},
            "raan_deg": {"first": 335.3, "last": 335.5, "step": 0.2},
            "perigee_height_km": {"first": 100.0, "last": 400.0, "step": 300.0},
        },
        boundary={"azimuths": 8, "perigee_height_km": {"first": 100.0, "last": 400.0, "step": 300.0}},
    )
    ready = Domain.of(scenario)
    edge = solve_boundary(ready, np.arange(4) * 45.0)
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
    assert rough.verdict is Verdict.NOT_RULED_OUT
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


def test_near_the_end_of_what_is_possible_the_burn_is_recovered_until_it_flies() -> None:
    """The largest orbit turned so is 7 283 km; the steering onto this one turns around within seconds, which no grid resolves."""
    found = solved().can_reach(orbit(7270.0, NATURAL_DEG + 90.0), exact=True)
    assert found.verdict is Verdict.WITHIN
    assert found.burn is not None
    assert 0.0 < found.burn.left_s < 20.0


def test_a_circular_orbit_is_promised_by_its_own_burn_alone() -> None:
    """The shortest burn onto it turns around between the nodes and misses by 1e-3; what is flown was recovered, and meets it."""
    circular = orbit(6678.137, 0.0)
    assert solved().can_reach(circular).verdict is Verdict.NOT_RULED_OUT
    found = solved().can_reach(circular, exact=True)
    assert found.verdict is Verdict.WITHIN
    assert found.burn is not None
    assert found.burn.verified
    assert found.burn.duration_s == pytest.approx(557.6, abs=0.5)


@pytest.mark.parametrize("height_km", [300.0, 200.0, 150.0])
def test_a_minute_of_thrust_in_orbit_promises_no_orbit_far_below(height_km: float) -> None:
    """From a circular orbit 400 km high thrust moves the vehicle 3 km in that minute; no table rules these orbits out."""
    minute = in_orbit(thrust_n=20000.0, mass_flow_kg_s=6.0, duration_s=60.0)
    lower = orbit(6378.137 + height_km, 0.0, height_km=height_km)
    assert minute.can_reach(lower, exact=True).verdict in (Verdict.NOT_FOUND, Verdict.BEYOND)
    assert minute.can_reach(lower).verdict not in (Verdict.WITHIN, Verdict.BEYOND)


def test_the_orbit_that_the_vehicle_is_in_takes_no_burn() -> None:
    found = in_orbit(thrust_n=20000.0, mass_flow_kg_s=6.0, duration_s=60.0).can_reach(
        orbit(6778.137, 0.0, height_km=400.0), exact=True
    )
    assert found.verdict is Verdict.WITHIN
    assert found.burn is not None
    assert found.burn.duration_s == 0.0


def test_the_orbit_after_some_seconds_of_braking_is_within_reach() -> None:
    """Thrust along the velocity, the first start of a plan, ends nowhere near it."""
    minute = in_orbit(thrust_n=20000.0, mass_flow_kg_s=6.0, duration_s=60.0)
    start = minute.scenario.initial_eci()
    braked = propagate_burn(start, minute.scenario.vehicle.thruster(), lambda _t, x: -x[3:], np.array([6.0]))[
        -1
    ]
    found = minute.can_reach(elements_from_state(braked[:3], braked[3:]), exact=True)
    assert found.verdict is Verdict.WITHIN
    assert found.burn is not None
    assert found.burn.duration_s <= 6.0 + 1e-3


@pytest.mark.parametrize("exact", [False, True])
@pytest.mark.parametrize("height_km", [50.0, 105.0, 110.0, 119.0])
def test_cut_off_below_the_least_altitude_is_refused(height_km: float, exact: bool) -> None:
    """The whole of these circular orbits lies below the 120 km that the burn must keep."""
    found = bounded(120.0).can_reach(orbit(6378.137 + height_km, 0.0, height_km=height_km), exact=exact)
    assert found.verdict is Verdict.BEYOND
    assert "cut-off would break the bound" in found.words


def test_an_orbit_through_the_least_altitude_is_decided_by_where_the_burn_ends_on_it() -> None:
    """Its perigee lies 10 km below the bound, which holds during the burn alone: that keeps 120 km and is promised."""
    low = orbit(7000.0, NATURAL_DEG, height_km=110.0)
    found = bounded(120.0).can_reach(low, exact=True)
    assert found.verdict is Verdict.WITHIN


def test_a_hyperbola_is_larger_than_any_ellipse() -> None:
    """3.7 km/s in orbit is enough to escape: the largest orbit of the plane has a negative axis and rules nothing out."""
    escaping = in_orbit(thrust_n=100000.0, mass_flow_kg_s=22.7, duration_s=500.0)
    found = escaping.can_reach(orbit(6628.137, 0.0, height_km=250.0), exact=True)
    assert found.sma_km == np.inf
    assert "hyperbolas reached on its plane" in found.words
    assert found.verdict is Verdict.WITHIN


@pytest.mark.parametrize("height_km", [50.0, 700.0])
def test_a_perigee_height_that_the_tables_lack_is_called_so(height_km: float) -> None:
    found = solved().can_reach(orbit(9000.0, NATURAL_DEG, height_km=height_km))
    assert found.verdict is Verdict.NOT_IN_TABLES
    assert f"its perigee height, {height_km:g} km, is not in the tables (100…500 km)" in found.words


def test_tables_for_one_perigee_direction_say_nothing_of_another() -> None:
    """The largest orbit with its perigee at 209° bounds none with its perigee elsewhere."""
    perigee_at_bound = paper().with_changes(
        grid=GRID, boundary=EDGE, perigee={"argp_deg": NATURAL_DEG + 90.0, "condition": "equal"}
    )
    tables = {**solved().points, "a_km": np.full_like(solved().points["a_km"], 7283.0)}
    found = ReachableDomain(perigee_at_bound, tables, solved().boundary)
    assert found.can_reach(orbit(21500.0, NATURAL_DEG + 90.0)).verdict is Verdict.BEYOND
    natural = found.can_reach(orbit(21500.0, NATURAL_DEG))
    assert natural.verdict is Verdict.NOT_IN_TABLES
    assert "made for an argument of perigee of 299 degrees" in natural.words


@pytest.mark.parametrize(
    ("field", "value", "words"),
    [
        ("sma_m", np.nan, "finite"), ("ecc", np.nan, "finite"), ("inc_rad", np.inf, "finite"), ("raan_rad", -np.inf, "finite"),
        ("argp_rad", np.nan, "finite"), ("true_anomaly_rad", np.nan, "finite"), ("sma_m", -2.0e7, "must be an ellipse"),
        ("ecc", 1.0, "must be an ellipse"), ("sma_m", 9000.0, "below the surface"), ("inc_rad", 28.18, "radians, not degrees"),
        ("raan_rad", 335.36, "radians, not degrees"),
    ],
)  # fmt: skip
def test_an_orbit_that_is_none_is_refused_by_its_field(field: str, value: float, words: str) -> None:
    with pytest.raises(OrbitError, match=words) as refused:
        solved().can_reach(replace(orbit(9000.0, 0.0), **{field: value}))
    assert refused.value.field == field
    assert f"orbit.{field} = " in str(refused.value)


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
    found = bounded(170.0).can_reach(orbit(21500.0, NATURAL_DEG), exact=True)
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
