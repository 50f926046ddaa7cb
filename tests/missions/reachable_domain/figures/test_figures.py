"""Figures of domains that are not the paper's: escape, orbits that run out of view, a single point, nothing reached."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import QuadMesh
from matplotlib.figure import Figure

from orbsoc.missions.reachable_domain.figures.band_page import write_band
from orbsoc.missions.reachable_domain.figures.draw import draw_figures
from orbsoc.missions.reachable_domain.figures.ellipses import VIEW_KM, band_title, largest_ellipses
from orbsoc.missions.reachable_domain.figures.orbits import draw_band, drawn_extent
from orbsoc.missions.reachable_domain.figures.planes import cell_edges, cell_limits, draw_maps, log_ticks
from orbsoc.missions.reachable_domain.search.continuation.boundary import solve_boundary
from orbsoc.missions.reachable_domain.search.continuation.domain import Domain
from orbsoc.orbit import EARTH
from orbsoc.reach import ReachableDomain
from tests.missions.reachable_domain.cases import paper

RADIUS_KM = EARTH.earth_radius_m / 1e3
MIXED = (1000.0, np.inf, 2.0e6, np.nan)
"""Apogee heights (km) on four planes: an ellipse, a hyperbola, an ellipse that runs out of view, and not reached."""


def drawn(apogees_km: tuple[float, ...], *, condition: str = "at_least") -> ReachableDomain:
    """A domain of 2 × 2 planes, or 1 × 1, at one bound, perigees at 100 km; the edge is real."""
    side = round(len(apogees_km) ** 0.5)
    heights = {"first": 100.0, "last": 100.0, "step": 10.0}
    scenario = paper().with_changes(
        grid={
            "inclination_deg": {"first": 27.3, "last": 27.3 + side - 1.0, "step": 1.0},
            "raan_deg": {"first": 334.25, "last": 334.25 + side - 1.0, "step": 1.0},
            "perigee_height_km": heights,
        },
        boundary={"azimuths": 8, "perigee_height_km": heights},
        perigee={"condition": condition},
    )
    ready = Domain.of(scenario)
    inc, raan = ready.planes()
    apogee = np.array(apogees_km)
    perigee = np.full(len(apogee), RADIUS_KM + 100.0)
    sma = np.where(np.isfinite(apogee), 0.5 * (perigee + apogee + RADIUS_KM), -50_000.0)
    sma = np.where(np.isnan(apogee), np.nan, sma)
    points = {
        "inc_deg": inc,
        "raan_deg": raan,
        "perigee_bound_km": np.full(len(apogee), 100.0),
        "argp_deg": np.full(len(apogee), 209.0),
        "apogee_km": apogee,
        "a_km": sma,
        "ecc": 1.0 - perigee / sma,
        "status": np.where(np.isnan(apogee), "not reached after these attempts", "reached").astype(object),
    }
    return ReachableDomain(scenario, points, solve_boundary(ready, np.arange(4) * 45.0))


def figure_of(size: tuple[float, float]) -> Figure:
    figure = Figure(figsize=size)
    FigureCanvasAgg(figure)
    return figure


def test_what_escapes_or_runs_out_of_view_is_said() -> None:
    found = drawn(MIXED)
    orbits = largest_ellipses(found)
    assert (len(orbits.curves), orbits.escaping, orbits.cut) == (2, 1, 1)
    assert orbits.apogees.tolist() == [2.0e6, 1000.0]
    far = [float(np.nanmax(np.linalg.norm(curve, axis=1))) for curve in orbits.curves]
    assert far == [pytest.approx(VIEW_KM), pytest.approx(RADIUS_KM + 1000.0)]
    title = band_title(found, orbits)
    assert title.endswith("perigee ≥ 100 km\n(1 escaping plane not drawn, 1 orbit cut at 120 000 km)")


def test_escape_has_a_colour_of_its_own_and_a_legend() -> None:
    figure = figure_of((11.0, 6.8))
    draw_maps(figure, drawn(MIXED))
    closed, escape = (c for c in figure.axes[0].collections if isinstance(c, QuadMesh))
    assert np.isfinite(np.ma.filled(np.ma.asarray(closed.get_array()), np.nan)).sum() == 2
    assert np.isfinite(np.ma.filled(np.ma.asarray(escape.get_array()), np.nan)).sum() == 1
    assert "escape" in figure.legends[0].get_texts()[0].get_text()


@pytest.mark.parametrize(
    "apogees_km", [MIXED, (np.inf,) * 4, (np.nan,) * 4, (1000.0,), (np.nan,)], ids=lambda a: str(a)
)
def test_every_domain_has_its_figures(tmp_path: Path, apogees_km: tuple[float, ...]) -> None:
    found = drawn(apogees_km)
    figures = draw_figures(found, tmp_path)
    assert [figure.name for figure in figures] == [
        "apogee_maps.png",
        "boundary.png",
        "projection.png",
        "band.png",
    ]
    write_band(found, tmp_path / "band.html")
    page = (tmp_path / "band.html").read_text(encoding="utf-8")
    assert ("escaping plane" in page) == bool(np.isposinf(apogees_km).any())


def test_a_grid_of_one_point_has_a_cell_to_see() -> None:
    figure = figure_of((11.0, 6.8))
    draw_maps(figure, drawn((1000.0,)))
    (mesh,) = (c for c in figure.axes[0].collections if isinstance(c, QuadMesh))
    corners = mesh.get_coordinates()
    assert np.ptp(corners[..., 0]) == pytest.approx(1.0)
    assert np.ptp(corners[..., 1]) == pytest.approx(1.0)
    assert cell_edges(np.array([20.0, 24.0, 28.0])).tolist() == [18.0, 22.0, 26.0, 30.0]


def test_titles_say_what_is_asked_of_the_perigee(tmp_path: Path) -> None:
    found = drawn((1000.0,), condition="equal")
    write_band(found, tmp_path / "band.html")
    page = (tmp_path / "band.html").read_text(encoding="utf-8")
    assert "largest orbits within reach, perigee = 100 km" in page
    figure = figure_of((11.0, 6.8))
    draw_maps(figure, found)
    assert figure.axes[0].get_title() == "perigee = 100 km"


@pytest.mark.parametrize("apogees_km", [MIXED, (30000.0,), (np.nan,)], ids=lambda a: str(a))
def test_the_band_fills_its_figure_and_stays_inside(apogees_km: tuple[float, ...]) -> None:
    figure = figure_of((9.6, 5.4))
    draw_band(figure, drawn(apogees_km))
    figure.canvas.draw()
    extent = drawn_extent(figure, figure.axes[0])
    assert min(extent.x0, extent.y0) >= 0.0
    assert max(extent.x1, extent.y1) <= 0.95
    assert max(extent.width, extent.height) > 0.8


def test_ticks_follow_the_data() -> None:
    assert log_ticks(800.0, 36000.0) == [1000.0, 2000.0, 5000.0, 10000.0, 20000.0]
    assert log_ticks(300.0, 4.0e6) == [1.0e3, 1.0e4, 1.0e5, 1.0e6]
    assert log_ticks(2100.0, 4100.0) == [2100.0, 4100.0]
    assert log_ticks(900.0, 1100.0) == [1000.0]


def test_maps_show_their_outer_cells_whole() -> None:
    assert cell_limits(np.array([20.0, 24.0, 28.0])) == (18.0, 30.0)
    assert cell_limits(np.array([20.0])) == (19.5, 20.5)
