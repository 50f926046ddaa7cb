"""Figures of the largest orbits around the Earth: their band in space, and its projection on the equator."""

from __future__ import annotations

from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np

from orbsoc.orbit.array import Array

from ..search.query.results import ReachableDomain
from .ellipses import EARTH_KM, band_title, largest_ellipses, sphere
from .planes import add_apogee_bar, apogee_norm

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from matplotlib.transforms import Bbox

EYE_DEG = (34.0, 68.0)
"""Elevation and azimuth of the eye."""
LIGHT_DEG = (50.0, 110.0)
"""Elevation and azimuth of the light: above, over the eye's shoulder."""
BAND_PLACE = (0.01, 0.02, 0.82, 0.89)
"""Left, bottom, width and height of the band in its figure, as shares."""
FILLS = 2
"""How often the band is fitted into its place: labels do not scale with it."""
MOST_TICKS = 6
"""Of the longest axis of the band; shorter ones have fewer."""


def draw_projection(figure: Figure, domain: ReachableDomain) -> None:
    """Seen from over the north pole, without what the Earth hides."""
    import matplotlib as mpl
    from matplotlib.collections import LineCollection
    from matplotlib.patches import Circle

    axis = figure.subplots()
    orbits = largest_ellipses(domain)
    axis.add_patch(Circle((0.0, 0.0), EARTH_KM, color="#c9d3dc", zorder=0))
    if orbits.curves:
        seen = [
            np.where(((c[:, 2] < 0.0) & (np.hypot(c[:, 0], c[:, 1]) < EARTH_KM))[:, None], np.nan, c)[:, :2]
            for c in orbits.curves
        ]
        lines = LineCollection(
            seen, array=orbits.apogees, norm=apogee_norm(orbits.apogees), cmap=mpl.colormaps["viridis"],
            linewidths=0.6, alpha=0.7,
        )  # fmt: skip
        axis.add_collection(lines)
        add_apogee_bar(figure, lines, axis, shrink=0.95)
    axis.autoscale_view()
    axis.set_aspect("equal")
    axis.set_xlabel("x (km), towards the zero of the node")
    axis.set_ylabel("y (km)")
    axis.grid(color="#e3e3e3", linewidth=0.6)
    axis.set_title(band_title(domain, orbits), fontsize=11)


def draw_band(figure: Figure, domain: ReachableDomain) -> None:
    """The orbits in space; what passes behind the Earth is drawn first."""
    import matplotlib as mpl
    from matplotlib.ticker import MaxNLocator
    from mpl_toolkits.mplot3d.art3d import Line3DCollection

    axis: Any = figure.add_axes(BAND_PLACE, projection="3d", computed_zorder=False)
    orbits = largest_ellipses(domain)
    _draw_earth(axis)
    corners = np.concatenate([*orbits.curves, EARTH_KM * np.vstack([np.eye(3), -np.eye(3)])])
    low, high = np.nanmin(corners, axis=0), np.nanmax(corners, axis=0)
    size = high - low
    axis.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    axis.set_box_aspect(size)
    for each, length in zip((axis.xaxis, axis.yaxis, axis.zaxis), size, strict=True):
        each.set_major_locator(
            MaxNLocator(max(2, round(MOST_TICKS * length / size.max())), steps=[1, 2, 5, 10])
        )
    if orbits.curves:
        norm = apogee_norm(orbits.apogees)
        colours = mpl.colormaps["viridis"](norm(orbits.apogees))
        for side, order in ((-1.0, 0), (1.0, 2)):
            parts = [_side(curve, side) for curve in orbits.curves]
            axis.add_collection3d(
                Line3DCollection(parts, colors=colours, linewidths=0.6, alpha=0.75, zorder=order),
                autolim=False,
            )
        scale = mpl.cm.ScalarMappable(norm, mpl.colormaps["viridis"])
        add_apogee_bar(figure, scale, None, cax=figure.add_axes((0.865, 0.16, 0.022, 0.66)))
    axis.view_init(elev=EYE_DEG[0], azim=EYE_DEG[1])
    for name in "xyz":
        getattr(axis, f"set_{name}label")(f"{name} (km)", labelpad=8)
    figure.suptitle(band_title(domain, orbits), fontsize=11)
    _fill(figure, axis)


def _side(curve: Array, side: float) -> Array:
    """The part of a curve on the eye's side of the Earth's centre (1) or beyond it (−1), NaN elsewhere; both share ends."""
    shown = side * (curve @ _towards(EYE_DEG)) > 0.0
    shared = shown.copy()
    shared[1:] |= shown[:-1]
    shared[:-1] |= shown[1:]
    return np.where(shared[:, None], curve, np.nan)


def _fill(figure: Figure, axis: Any) -> None:
    """Move and scale an axis so that what it draws, labels included, fills its place: a flat box leaves much of it empty."""
    for _ in range(FILLS):
        figure.canvas.draw()
        drawn = drawn_extent(figure, axis)
        scale = min(BAND_PLACE[2] / drawn.width, BAND_PLACE[3] / drawn.height)
        box = axis.get_position(original=True)
        x = BAND_PLACE[0] + 0.5 * (BAND_PLACE[2] - scale * (drawn.x0 + drawn.x1 - 2.0 * box.x0))
        y = BAND_PLACE[1] + 0.5 * (BAND_PLACE[3] - scale * (drawn.y0 + drawn.y1 - 2.0 * box.y0))
        axis.set_position((x, y, scale * box.width, scale * box.height))


def drawn_extent(figure: Figure, axis: Any) -> Bbox:
    """What an axis draws, in shares of the figure: its box with ticks and labels, without the empty place around it."""
    from matplotlib.transforms import Bbox
    from mpl_toolkits.mplot3d import proj3d

    corners = np.array(list(product(axis.get_xlim(), axis.get_ylim(), axis.get_zlim())))
    x, y, _depth = proj3d.proj_transform(*corners.T, axis.get_proj())
    at = axis.transData.transform(np.column_stack([x, y]))
    parts = [Bbox([at.min(axis=0), at.max(axis=0)])]
    parts += [each.get_tightbbox() for each in (axis.xaxis, axis.yaxis, axis.zaxis)]
    return Bbox.union(parts).transformed(figure.transFigure.inverted())


def _draw_earth(axis: Any) -> None:
    """A ball, lit from above."""
    outward = sphere(73, 37)
    lit = 0.62 + 0.38 * np.maximum(0.0, outward @ _towards(LIGHT_DEG))
    colours = np.ones((*lit.shape, 4))
    colours[..., :3] = lit[..., None] * np.array([0.80, 0.86, 0.92])
    ball = EARTH_KM * np.moveaxis(outward, -1, 0)
    axis.plot_surface(
        *ball, facecolors=colours, linewidth=0, zorder=1, shade=False, rstride=1, cstride=1, antialiased=False
    )


def _towards(elevation_azimuth_deg: tuple[float, float]) -> Array:
    """Unit vector (3,) towards an elevation and azimuth."""
    elevation, azimuth = np.deg2rad(elevation_azimuth_deg)
    level = np.cos(elevation)
    return np.array([level * np.cos(azimuth), level * np.sin(azimuth), np.sin(elevation)])
