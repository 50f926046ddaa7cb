"""Figures of a reachable domain: maps, boundary curves, the band around the Earth and its equatorial projection.

Drawn with Matplotlib's Agg canvas, without pyplot: no global state, no display.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from orbsoc.missions.reachable_domain.boundary import edge_note
from orbsoc.missions.reachable_domain.planes import inclination_and_node
from orbsoc.orbit import EARTH, Elements, state_from_elements

from .envelope import edge_curve
from .results import ReachableDomain

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

STYLE: Any = {
    "font.size": 10.5,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.axisbelow": True,
    "legend.frameon": False,
    "figure.titlesize": 11,
}
DOTS_PER_INCH = 150
BLUE, VERMILION, GREEN, GREY = "#0072B2", "#D55E00", "#009E73", "#6b7680"
MAPS = 6
"""Perigee bounds shown as maps."""
CURVES = 5
"""Perigee bounds shown as curves."""


@dataclass(frozen=True, slots=True)
class FigureFile:
    """A figure that was written: its file name, and a caption that says what it shows."""

    name: str
    caption: str


def draw_figures(domain: ReachableDomain, folder: Path) -> tuple[FigureFile, ...]:
    """Write all figures into `folder`."""
    import matplotlib as mpl
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    plots: tuple[tuple[str, str, tuple[float, float], Callable[[Figure, ReachableDomain], None]], ...] = (
        (
            "apogee_maps.png",
            "Largest apogee height on each plane, for several bounds on the perigee height. White: not reached. "
            + (edge_note(domain.domain) or "The line is the edge found without the grid."),
            (11.0, 6.6),
            _maps,
        ),
        (
            "boundary.png",
            "The edge of the reachable planes for several perigee bounds. Solid inside the paper's search box, dashed"
            " where the box would cut it off.",
            (8.2, 6.4),
            _boundary,
        ),
        (
            "projection.png",
            "Largest orbits of all reached planes at the lowest perigee bound, projected on the equator (after figure 4"
            " of the paper). Colour: apogee height.",
            (8.8, 5.0),
            _projection,
        ),
        (
            "band.png",
            "The same orbits in space (after figure 3 of the paper); band.html turns.",
            (9.0, 6.2),
            _band,
        ),
    )
    written = []
    for name, caption, size, draw in plots:
        if draw is _boundary and edge_note(domain.domain):
            continue
        with mpl.rc_context(STYLE):
            figure = Figure(figsize=size, layout="constrained")
            FigureCanvasAgg(figure)
            draw(figure, domain)
            figure.savefig(folder / name, dpi=DOTS_PER_INCH)
        written.append(FigureFile(name, caption))
    return tuple(written)


def orbits_at_lowest_bound(domain: ReachableDomain, samples: int = 181) -> tuple[list[Array], Array]:
    """Ellipses (samples, 3) in km of the largest orbits of all reached planes, and their apogee heights (km), smallest
    apogee last so that it is drawn on top."""
    points = domain.points
    rows = np.flatnonzero(
        (points["perigee_bound_km"] == points["perigee_bound_km"].min()) & (points["status"] == "reached")
    )
    rows = rows[np.isfinite(points["apogee_km"][rows])]
    rows = rows[np.argsort(-points["apogee_km"][rows])]
    ellipses = []
    for row in rows:
        a, e = 1e3 * points["a_km"][row], points["ecc"][row]
        inc, raan, argp = (np.deg2rad(points[name][row]) for name in ("inc_deg", "raan_deg", "argp_deg"))
        # Equal steps of eccentric anomaly: as dense at the apogee as at the perigee.
        eccentric = np.linspace(0.0, 2.0 * np.pi, samples)
        r0, v0 = state_from_elements(Elements(a, e, inc, raan, argp, 0.0))
        along, ahead = r0 / np.linalg.norm(r0), v0 / np.linalg.norm(v0)
        x, y = a * (np.cos(eccentric) - e), a * np.sqrt(1.0 - e**2) * np.sin(eccentric)
        ellipses.append((np.outer(x, along) + np.outer(y, ahead)) / 1e3)
    return ellipses, points["apogee_km"][rows]


def cell_limits(values: Array) -> tuple[float, float]:
    """From the outer side of the first cell of an axis to that of the last; a single value has a cell of 1 degree."""
    first, last = (values[1] - values[0], values[-1] - values[-2]) if len(values) > 1 else (1.0, 1.0)
    return float(values[0] - 0.5 * first), float(values[-1] + 0.5 * last)


def _spread(values: Array, count: int) -> Array:
    """At most `count` of the values, ends included."""
    chosen = np.linspace(0, len(values) - 1, min(count, len(values))).round().astype(int)
    return np.asarray(values[np.unique(chosen)])


def _maps(figure: Figure, domain: ReachableDomain) -> None:
    from matplotlib.colors import LogNorm

    grid = domain.scenario.grid
    inc, raan, heights = (s.values() for s in (grid.inclination_deg, grid.raan_deg, grid.perigee_height_km))
    cube = domain.points["apogee_km"].reshape(len(inc), len(raan), len(heights))
    shown = _spread(heights, MAPS)
    columns = min(3, len(shown))
    axes = figure.subplots(-(-len(shown) // columns), columns, sharex=True, sharey=True, squeeze=False)
    finite = cube[np.isfinite(cube)]
    norm = LogNorm(finite.min(), finite.max()) if finite.size else None
    mesh: Any = None
    for axis, height in zip(axes.flat, shown, strict=False):
        layer = np.where(
            np.isfinite(cube[:, :, heights == height][..., 0]), cube[:, :, heights == height][..., 0], np.nan
        )
        mesh = axis.pcolormesh(
            raan, inc, layer, norm=norm, cmap="viridis", shading="nearest", rasterized=True
        )
        if not edge_note(domain.domain):
            _draw_edge(axis, domain, float(height), color="black", linewidth=1.2)
        _mark_current(axis, domain, color="white")
        axis.set_title(f"perigee ≥ {height:g} km", fontsize=10.5)
        axis.set_xlim(*cell_limits(raan))
        axis.set_ylim(*cell_limits(inc))
    for axis in axes.flat[len(shown) :]:
        axis.set_visible(False)
    for axis in axes[-1]:
        axis.set_xlabel("right ascension of the node (°)")
    for axis in axes[:, 0]:
        axis.set_ylabel("inclination (°)")
    if mesh is not None and finite.size:
        bar = figure.colorbar(mesh, ax=axes, label="apogee height (km)")
        ticks = [t for t in (500, 1000, 2000, 5000, 10000, 20000, 50000) if finite.min() <= t <= finite.max()]
        bar.set_ticks(ticks, labels=[f"{tick:g}" for tick in ticks])
        bar.ax.minorticks_off()
    figure.suptitle(f"{domain.scenario.name}: largest apogee within reach")


def _boundary(figure: Figure, domain: ReachableDomain) -> None:
    import matplotlib as mpl
    from matplotlib.patches import Rectangle

    axis = figure.subplots()
    grid = domain.scenario.grid
    inc, raan = grid.inclination_deg.values(), grid.raan_deg.values()
    heights = _spread(domain.limit.height_km, CURVES)
    colours = mpl.colormaps["viridis"](np.linspace(0.0, 0.85, len(heights)))
    for height, colour in zip(heights, colours, strict=True):
        _draw_edge(
            axis,
            domain,
            float(height),
            color=colour,
            linewidth=2.0,
            label=f"perigee ≥ {height:g} km",
            clip=True,
        )
    box = (raan[0], inc[0]), raan[-1] - raan[0], inc[-1] - inc[0]
    axis.add_patch(
        Rectangle(*box, fill=False, edgecolor=VERMILION, linewidth=1.5, label="search box of the grid")
    )
    _mark_current(axis, domain, color="black", label="current plane")
    axis.set_xlabel("right ascension of the node (°)")
    axis.set_ylabel("inclination (°)")
    axis.grid(color="#dddddd", linewidth=0.6)
    axis.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))
    axis.set_title(
        f"{domain.scenario.name}: edge of the reachable planes (dashed outside the box)", fontsize=11
    )


def _draw_edge(
    axis: Axes,
    domain: ReachableDomain,
    height: float,
    *,
    color: Any,
    linewidth: float,
    label: str | None = None,
    clip: bool = False,
) -> None:
    """The edge in the plane of node and inclination; with `clip` dashed outside the search box."""
    limit = domain.limit
    if not limit.covers(height):
        return
    inc, node = edge_curve(domain, height)
    if not clip:
        axis.plot(node, inc, color=color, linewidth=linewidth)
        return
    grid = domain.scenario.grid
    low, high = grid.inclination_deg.first, grid.inclination_deg.values()[-1]
    west, east = grid.raan_deg.first, grid.raan_deg.values()[-1]
    inside = (inc >= low) & (inc <= high) & (node >= west) & (node <= east)
    for part, style in ((inside, "-"), (~inside, (0, (3, 2)))):
        shown = part | np.roll(part, 1) | np.roll(part, -1) if style != "-" else part
        axis.plot(
            np.where(shown, node, np.nan),
            np.where(shown, inc, np.nan),
            color=color,
            linewidth=linewidth,
            linestyle=style,
            label=label if style == "-" else None,
        )


def _mark_current(axis: Axes, domain: ReachableDomain, *, color: str, label: str | None = None) -> None:
    inc, raan = (float(np.rad2deg(x)) for x in inclination_and_node(domain.domain.frame.normal))
    axis.plot(
        [raan], [inc], marker="+", markersize=9, markeredgewidth=1.8, color=color, linestyle="", label=label
    )


def _projection(figure: Figure, domain: ReachableDomain) -> None:
    import matplotlib as mpl
    from matplotlib.collections import LineCollection
    from matplotlib.colors import LogNorm
    from matplotlib.patches import Circle

    axis = figure.subplots()
    ellipses, apogees = orbits_at_lowest_bound(domain)
    if ellipses:
        lines = LineCollection(
            [ellipse[:, :2] for ellipse in ellipses],
            array=apogees,
            norm=LogNorm(apogees.min(), apogees.max()),
            cmap=mpl.colormaps["viridis"],
            linewidths=0.6,
            alpha=0.7,
        )
        axis.add_collection(lines)
        figure.colorbar(lines, ax=axis, label="apogee height (km)", shrink=0.95)
    axis.add_patch(Circle((0.0, 0.0), EARTH.earth_radius_m / 1e3, color="#c9d3dc", zorder=0))
    axis.autoscale_view()
    axis.set_aspect("equal")
    axis.set_xlabel("x (km), towards the zero of the node")
    axis.set_ylabel("y (km)")
    axis.grid(color="#e3e3e3", linewidth=0.6)
    axis.set_title(f"{domain.scenario.name}: projection on the equator", fontsize=11)


def _band(figure: Figure, domain: ReachableDomain) -> None:
    import matplotlib as mpl
    from matplotlib.colors import LogNorm
    from mpl_toolkits.mplot3d.art3d import Line3DCollection

    axis: Any = figure.add_subplot(projection="3d", computed_zorder=False)
    ellipses, apogees = orbits_at_lowest_bound(domain)
    radius = EARTH.earth_radius_m / 1e3
    u, v = np.meshgrid(np.linspace(0.0, 2.0 * np.pi, 49), np.linspace(0.0, np.pi, 25))
    ball = radius * np.stack([np.cos(u) * np.sin(v), np.sin(u) * np.sin(v), np.cos(v)])
    axis.plot_surface(*ball, color="#b9c6d2", linewidth=0, zorder=1, shade=True)
    if ellipses:
        norm = LogNorm(apogees.min(), apogees.max())
        colours = mpl.colormaps["viridis"](norm(apogees))
        for front, order in ((False, 0), (True, 2)):
            parts = [np.where((_towards_eye(e) > 0.0)[:, None] == front, e, np.nan) for e in ellipses]
            axis.add_collection3d(
                Line3DCollection(parts, colors=colours, linewidths=0.6, alpha=0.75, zorder=order)
            )
        reach = max(float(np.abs(ellipse).max()) for ellipse in ellipses)
        corners = np.concatenate(ellipses)
        low, high = corners.min(axis=0), corners.max(axis=0)
        axis.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
        axis.set_box_aspect(np.maximum(high - low, 0.05 * reach), zoom=1.15)
        axis.set_zticks([-5000, 0, 5000])
        axis.set_yticks([-10000, 0, 10000])
        scale = mpl.cm.ScalarMappable(norm, mpl.colormaps["viridis"])
        figure.colorbar(scale, ax=axis, label="apogee height (km)", shrink=0.6, pad=0.08)
    axis.view_init(elev=_EYE[0], azim=_EYE[1])
    axis.set(xlabel="x (km)", ylabel="y (km)", zlabel="z (km)")
    axis.set_title(f"{domain.scenario.name}: largest orbits within reach", fontsize=11)


_EYE = (34.0, 68.0)
"""Elevation and azimuth of the eye, degrees."""


def _towards_eye(points: Array) -> Array:
    """Distance of points (K, 3) towards the eye."""
    elevation, azimuth = np.deg2rad(_EYE)
    eye = [np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)]
    return np.asarray(points @ np.array(eye))
