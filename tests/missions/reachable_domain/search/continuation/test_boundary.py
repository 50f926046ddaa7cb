"""The boundary of the domain: its mirror symmetry, and what restricts it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from orbsoc.missions.reachable_domain.figures.draw import draw_figures
from orbsoc.missions.reachable_domain.model.direct.terminal import LargestTilt
from orbsoc.missions.reachable_domain.record.summary import summary
from orbsoc.missions.reachable_domain.search.continuation.boundary import (
    edge_note,
    inside_box,
    solve_boundary,
)
from orbsoc.missions.reachable_domain.search.continuation.domain import Domain
from orbsoc.missions.reachable_domain.search.continuation.largest_tilt import largest_tilts
from orbsoc.missions.reachable_domain.search.continuation.table import PointStatus
from orbsoc.orbit.planes import inclination_and_node
from orbsoc.reach import ReachableDomain
from tests.missions.reachable_domain.cases import domain, paper, perigees


def test_the_edge_is_the_same_at_opposite_azimuths() -> None:
    """Solved on both sides, not mirrored: a burn and its mirror image in the current plane."""
    azimuth = np.deg2rad([20.0, 110.0, 200.0, 290.0])
    tilt = largest_tilts(domain().tools, LargestTilt(domain().frame, azimuth, perigees(*[200.0] * 4))).tilt
    np.testing.assert_allclose(tilt[2:], tilt[:2], rtol=0, atol=1e-6)


def test_half_the_azimuths_stand_for_all() -> None:
    found = solve_boundary(domain(), np.array([0.0, 60.0]))
    bounds = paper().boundary.perigee_height_km.count
    assert len(found["tilt_deg"]) == 4 * bounds
    np.testing.assert_array_equal(found["azimuth_deg"][::bounds], [0.0, 60.0, 180.0, 240.0])
    np.testing.assert_array_equal(found["tilt_deg"][: 2 * bounds], found["tilt_deg"][2 * bounds :])
    assert (np.diff(found["tilt_deg"].reshape(4, bounds), axis=1) < 0.0).all()  # a higher perigee costs tilt
    assert np.nanmax(found["tilt_change_deg"]) < 0.03
    assert (found["sequence_iterations"][2 * bounds :] == 0).all()


def test_a_sequence_that_goes_to_and_fro_on_twelve_nodes_ends_on_more() -> None:
    target = LargestTilt(domain().frame, np.deg2rad([12.5]), perigees(100.0))
    found = largest_tilts(domain().tools, target)
    assert found.nodes[0] == 48
    assert np.rad2deg(found.tilt[0]) == pytest.approx(13.959, abs=0.005)


def test_the_search_box_may_lie_across_360_degrees() -> None:
    raan = {"first": 350.0, "last": 370.0, "step": 5.0}
    wide = domain().of(paper().with_changes(grid={"raan_deg": raan}))
    found = inside_box(wide, np.array([30.0, 30.0, 30.0, 30.0]), np.array([355.0, 5.0, 10.0, 11.0]))
    assert list(found) == [True, True, True, False]


def test_points_of_the_edge_outside_the_search_box_are_called_so() -> None:
    found = solve_boundary(domain(), np.array([0.0, 60.0]))
    outside = found["status"] == PointStatus.OUTSIDE.value
    assert outside.any()
    assert not outside.all()
    np.testing.assert_array_equal(outside, ~found["inside_box"])
    assert set(found["status"][~outside]) == {PointStatus.REACHED.value}


def test_a_bound_on_the_altitude_moves_the_edge_inwards_and_reached_planes_lie_within_it() -> None:
    high = Domain.of(paper().with_changes(burn={"minimum_altitude_km": 180.0}))
    azimuth = np.deg2rad(np.arange(0.0, 180.0, 22.5))
    target = LargestTilt(domain().frame, azimuth, perigees(*[100.0] * 8))
    free, bounded = (np.rad2deg(largest_tilts(d.tools, target).tilt) for d in (domain(), high))
    assert (bounded < free - 0.05).all()
    assert (free - bounded < 0.3).all()
    reached, not_reached = PointStatus.REACHED.value, PointStatus.NOT_REACHED.value
    for back, expected in ((0.5, reached), (0.1, reached), (0.02, reached), (-0.02, not_reached)):
        tilt = np.deg2rad(bounded[::2] - back)
        inc, raan = np.rad2deg(inclination_and_node(high.frame.tilted(tilt, azimuth[::2])))
        table = high.solve_planes(inc, raan, np.array([100.0]))
        assert set(table["status"]) == {expected}
        assert not (table.reached() & (table["lowest_km"] < 179.999)).any()
        assert not (table.reached() & (table["plane_error_rad"] > 1e-6)).any()
        # The steering has corners along the bound: what the nodes promise is flown less and less exactly.
        assert not (table.reached() & (table["sma_error_rel"] > (1e-6 if back > 0.4 else 1e-2))).any()


@pytest.mark.parametrize("perigee", [{"argp_deg": 209.0}, {"condition": "equal"}])
def test_an_edge_that_is_not_the_scenarios_own_is_not_drawn(tmp_path: Path, perigee: dict[str, Any]) -> None:
    """It would be that of a larger domain; the figure is missing, and everything that shows the edge says why."""
    span = {"first": 28.3, "last": 30.3, "step": 1.0}
    grid = {"inclination_deg": span, "raan_deg": {"first": 333.25, "last": 335.25, "step": 1.0}}
    heights = {"first": 100.0, "last": 300.0, "step": 200.0}
    scenario = paper().with_changes(
        perigee=perigee, grid={**grid, "perigee_height_km": heights}, boundary={"perigee_height_km": heights}
    )
    ready = Domain.of(scenario)
    edge = solve_boundary(ready, np.arange(0.0, 180.0, 30.0))
    found = ReachableDomain(scenario, ready.solve_planes(*ready.planes()).columns, edge)
    figures = draw_figures(found, tmp_path)
    assert "boundary.png" not in {figure.name for figure in figures}
    assert not (tmp_path / "boundary.png").exists()
    assert "not drawn" in figures[0].caption
    document = summary(found)
    assert "outer limit" in document["boundary"]["not_drawn"]
    assert all(np.isnan(row["whole_deg"]) and "not drawn" in row["reason"] for row in document["envelope"])
    assert edge_note(domain()) == ""
