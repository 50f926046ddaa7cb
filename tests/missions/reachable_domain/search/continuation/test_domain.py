"""Points of the reachable domain: the reference values, and every promise flown by SciPy's integrator."""

from __future__ import annotations

import numpy as np
import pytest

from orbsoc.guidance.collocation import legendre_gauss
from orbsoc.missions.reachable_domain.search.continuation.domain import Domain
from orbsoc.missions.reachable_domain.search.continuation.table import Origin, PointStatus, PointTable
from orbsoc.orbit import elements_from_state, propagate_burn
from orbsoc.orbit.planes import normals, plane_error
from tests.missions.reachable_domain.cases import domain, paper

# i, Ω (deg), h_p ≥ (km): a, h_a, h_p, smallest altitude (km), from indirect and direct methods that agree to 2e-6.
REFERENCES = {
    (28.18, 335.36, 100.0): (24860.2660, 36636.165, 328.093, 154.1),
    (28.30, 330.25, 100.0): (21739.7722, 30417.106, 306.164, 150.1),
    (20.30, 322.25, 100.0): (15428.6195, 17778.546, 322.420, 165.2),
    (24.30, 334.25, 200.0): (22003.8220, 30939.268, 312.102, 152.0),
    (16.30, 318.25, 500.0): (9880.7905, 6505.307, 500.000, 191.1),
    (28.30, 350.25, 100.0): (7628.9296, 2401.585, 100.000, 83.9),
}


def assert_flies(table: PointTable, row: int) -> None:
    """The row's attitude programme, flown by DOP853 at constant thrust, reaches the row's orbit and plane."""
    scenario, vectors = paper(), table["commands"][row].reshape(-1, 3)
    grid = legendre_gauss(len(vectors))

    def steering(t_s: float, _state: np.ndarray) -> np.ndarray:
        return grid.interpolate(vectors, 2.0 * t_s / scenario.burn.duration_s - 1.0)[0]

    end = propagate_burn(
        scenario.initial_eci(), scenario.vehicle.thruster(), steering, [scenario.burn.duration_s]
    )[-1]
    reached = elements_from_state(end[:3], end[3:])
    normal = normals(np.deg2rad(table["inc_deg"][row]), np.deg2rad(table["raan_deg"][row]))
    assert reached.sma_m / 1e3 == pytest.approx(table["a_km"][row], rel=1e-8)
    assert reached.perigee_height_m() / 1e3 == pytest.approx(table["perigee_km"][row], abs=1e-4)
    assert np.rad2deg(reached.argp_rad) == pytest.approx(table["argp_deg"][row], abs=1e-4)
    assert plane_error(end, normal) < 1e-5


@pytest.mark.parametrize("point", REFERENCES, ids=str)
def test_reference_points_are_met_to_1e_6(point: tuple[float, float, float]) -> None:
    a_km, apogee_km, perigee_km, lowest_km = REFERENCES[point]
    table = domain().solve_planes([point[0]], [point[1]], [point[2]])
    assert table["status"][0] == PointStatus.REACHED.value
    assert table["a_km"][0] == pytest.approx(a_km, rel=1e-6)
    assert table["apogee_km"][0] == pytest.approx(apogee_km, abs=0.01)
    assert table["perigee_km"][0] == pytest.approx(perigee_km, abs=0.01)
    assert table["lowest_km"][0] == pytest.approx(lowest_km, abs=0.06)
    assert_flies(table, 0)


def test_twelve_nodes_over_promise_at_the_edge_and_the_flight_finds_out() -> None:
    """The plan on 12 nodes promises 7664.4 km; the truth is 7628.9296 km, and the row is polished."""
    table = domain().solve_planes([28.30], [350.25], [100.0])
    assert table["level"][0] == "polished"
    assert table["newton_steps"][0] >= 1
    assert table["a_km"][0] < 7628.94


def test_the_perigee_goes_down_to_its_bound_where_it_must() -> None:
    lowered = Domain.of(paper().with_changes(perigee={"condition": "equal"}))
    table = lowered.solve_planes([28.18], [335.36], [100.0, 300.0, 400.0])
    assert list(table["status"]) == [PointStatus.REACHED.value] * 3
    assert table["a_km"][0] == pytest.approx(22986.1191, rel=1e-6)
    assert table["lowest_km"][0] == pytest.approx(50.0, abs=0.06)
    np.testing.assert_allclose(table["perigee_km"], [100.0, 300.0, 400.0], atol=1e-3)
    assert list(table["origin"]) == [
        Origin.PERIGEE_AT_BOUND.value,
        Origin.PERIGEE_AT_BOUND.value,
        Origin.CONTINUATION.value,
    ]
    assert_flies(table, 0)


def test_a_minimum_altitude_is_kept_between_the_nodes_too() -> None:
    bounded = Domain.of(paper().with_changes(burn={"minimum_altitude_km": 180.0}))
    table = bounded.solve_planes([28.18, 28.3], [335.36, 350.25], [100.0])
    free = domain().solve_planes([28.18], [335.36], [100.0])
    assert table["status"][0] == PointStatus.REACHED.value
    assert 179.999 <= table["lowest_km"][0] < 180.5
    assert table["a_km"][0] < free["a_km"][0] * (1.0 - 1e-3)
    assert_flies(table, 0)
    assert table["status"][1] == PointStatus.NOT_REACHED.value
    assert (
        "deg short" in table["evidence"][1]
    )  # of the furthest tilt with this bound; without it the plane is reached
    assert domain().solve_planes([28.3], [350.25], [100.0])["status"][0] == PointStatus.REACHED.value


def test_a_fixed_perigee_direction_costs_energy_and_is_kept() -> None:
    free = domain().solve_planes([28.18], [335.36], [100.0])
    turned = Domain.of(paper().with_changes(perigee={"argp_deg": float(free["argp_deg"][0]) - 360.0 + 5.0}))
    table = turned.solve_planes([28.18], [335.36], [100.0])
    assert table["argp_deg"][0] == pytest.approx(free["argp_deg"][0] + 5.0, abs=1e-5)
    assert table["a_km"][0] < free["a_km"][0]
    assert_flies(table, 0)


def test_points_beyond_the_edge_say_how_far_and_what_was_tried() -> None:
    table = domain().solve_planes([16.3, 40.3], [332.25, 318.25], [100.0, 110.0])
    assert list(table["status"]) == [PointStatus.NOT_REACHED.value] * 4
    gap = table["tilt_deg"] - table["furthest_tilt_deg"]
    assert gap[0] == pytest.approx(0.035, abs=0.002)  # the nearest miss of the 1 degree grid at 100 km
    assert "deg short" in table["evidence"][0]
    assert table["origin"][1] == Origin.BELOW.value


def test_points_that_only_the_furthest_tilt_leads_to_are_reached() -> None:
    """Cold, a subproblem of this point has no feasible point; it lies 0.033 degrees within the edge."""
    table = domain().solve_planes([31.3], [323.25], [100.0])
    assert table["status"][0] == PointStatus.REACHED.value
    assert table["origin"][0] == Origin.LARGEST_TILT.value
    assert_flies(table, 0)


def test_held_and_continued_plans_are_what_every_point_finds_for_itself() -> None:
    alone = Domain.of(paper().with_changes(method={"continuation": "none"}))
    planes = ([24.3, 30.3], [334.25, 344.25], [100.0, 300.0, 350.0, 450.0])
    waves, cold = domain().solve_planes(*planes), alone.solve_planes(*planes)
    assert Origin.REUSED.value in waves["origin"]
    assert Origin.CONTINUATION.value in waves["origin"]
    assert set(cold["origin"]) == {Origin.COLD.value}
    np.testing.assert_allclose(waves["a_km"], cold["a_km"], rtol=1e-6)
    np.testing.assert_allclose(waves["argp_deg"], cold["argp_deg"], atol=1e-2)


def test_larger_perigees_cost_energy_and_no_plan_breaks_its_bounds() -> None:
    table = domain().solve_planes([20.3, 24.3], [322.25, 334.25])
    reached = table.reached().reshape(2, -1)
    assert reached[1].all()
    a = table["a_km"].reshape(2, -1)
    assert all((np.diff(row[ok]) <= 1e-6 * row[ok][1:]).all() for row, ok in zip(a, reached, strict=True))
    flown = table.reached()
    assert table["sma_error_rel"][flown].max() <= 1e-6
    assert table["plane_error_rad"][flown].max() <= 1e-6
    assert table["perigee_short_m"][flown].max() <= 1.0


def test_a_coarse_extremal_far_off_does_not_lead_astray() -> None:
    """Next to the edge the extremal of 6 steps is 5 km off in a, and Newton on 16 steps does not find its way from there:
    from the sequence's own multipliers it does."""
    table = domain().solve_planes([19.3], [341.25], np.array([100.0, 110.0, 120.0]))
    assert (table["status"] == PointStatus.REACHED.value).all()
    assert table["a_km"][2] == pytest.approx(6843.5987, rel=1e-6)
