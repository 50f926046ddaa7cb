"""Figures over inclination and node: apogee maps, and the edge of the reachable planes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from orbsoc.orbit.array import Array
from orbsoc.orbit.planes import inclination_and_node

from ..search.continuation.boundary import edge_note
from ..search.query.envelope import edge_curve
from ..search.query.results import ReachableDomain
from .ellipses import bound_words

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colors import LogNorm
    from matplotlib.figure import Figure

MOST_TICKS = 8
NARROW = 1.25
"""Ratio of the ends of a range that one tick stands for."""
VERMILION, ESCAPE = "#D55E00", "#CC79A7"
MAPS = 6
"""Perigee bounds shown as maps."""
CURVES = 5
"""Perigee bounds shown as curves."""


def cell_limits(values: Array) -> tuple[float, float]:
    """From the outer side of the first cell of an axis to that of the last; a single value has a cell of 1 degree."""
    first, last = (values[1] - values[0], values[-1] - values[-2]) if len(values) > 1 else (1.0, 1.0)
    return float(values[0] - 0.5 * first), float(values[-1] + 0.5 * last)


def _spread(values: NDArray[Any], count: int) -> NDArray[Any]:
    """At most `count` of the values, ends included."""
    chosen = np.linspace(0, len(values) - 1, min(count, len(values))).round().astype(int)
    return np.asarray(values[np.unique(chosen)])


def cell_edges(values: Array) -> Array:
    """Edges (K + 1,) of the cells around the values of an axis."""
    first, last = cell_limits(values)
    return np.concatenate([[first], 0.5 * (values[1:] + values[:-1]), [last]])


def log_ticks(low: float, high: float) -> list[float]:
    """1, 2 and 5 times powers of ten within a range; its middle, or its ends, where fewer than two are; only the powers
    where more than eight are."""
    powers = 10.0 ** np.arange(np.floor(np.log10(low)), np.ceil(np.log10(high)) + 1.0)
    ticks = [float(k * power) for power in powers for k in (1, 2, 5) if low <= k * power <= high]
    if len(ticks) < 2:
        return [0.5 * (low + high)] if high <= NARROW * low else [low, high]
    return ticks if len(ticks) <= MOST_TICKS else [float(power) for power in powers if low <= power <= high]


def apogee_norm(apogees: Array) -> LogNorm:
    """A logarithmic scale of apogee heights (km) that is not empty even when all are the same."""
    from matplotlib.colors import LogNorm

    low, high = float(apogees.min()), float(apogees.max())
    return LogNorm(low, high) if high > 1.01 * low else LogNorm(0.9 * low, 1.1 * high)


def add_apogee_bar(figure: Figure, mapped: Any, axes: Any, **place: Any) -> None:
    """A colour bar of apogee heights with ticks that follow the data."""
    bar = figure.colorbar(mapped, ax=axes, label="apogee height (km)", **place)
    ticks = log_ticks(float(mapped.norm.vmin), float(mapped.norm.vmax))
    bar.set_ticks(ticks, labels=[f"{tick:.0f}" for tick in ticks])
    bar.ax.minorticks_off()


def draw_maps(figure: Figure, domain: ReachableDomain) -> None:
    """Largest apogee over node and inclination, a map a perigee bound; planes of which the vehicle escapes by themselves."""
    grid = domain.scenario.grid
    inc, raan, heights = (s.values() for s in (grid.inclination_deg, grid.raan_deg, grid.perigee_height_km))
    cube = domain.points["apogee_km"].reshape(len(inc), len(raan), len(heights))
    shown = _spread(np.arange(len(heights)), MAPS)
    columns = min(3, len(shown))
    axes = figure.subplots(-(-len(shown) // columns), columns, sharex=True, sharey=True, squeeze=False)
    finite = cube[np.isfinite(cube)]
    norm = apogee_norm(finite) if finite.size else None
    edges = cell_edges(raan), cell_edges(inc)
    mesh: Any = None
    for axis, k in zip(axes.flat, shown, strict=False):
        layer = cube[:, :, k]
        if norm is not None:
            closed = np.where(np.isfinite(layer), layer, np.nan)
            mesh = axis.pcolormesh(*edges, closed, norm=norm, cmap="viridis", rasterized=True)
        _shade_escape(axis, edges, layer)
        if not edge_note(domain.domain):
            _draw_edge(axis, domain, float(heights[k]))
        _mark_current(axis, domain, color="white")
        axis.set_title(bound_words(domain, float(heights[k])), fontsize=10.5)
        axis.set_xlim(*cell_limits(raan))
        axis.set_ylim(*cell_limits(inc))
    for axis in axes.flat[len(shown) :]:
        axis.set_visible(False)
    for axis in axes.flat[max(0, len(shown) - columns) : len(shown)]:
        axis.tick_params(labelbottom=True)
    figure.supxlabel("right ascension of the node (°)", fontsize=10.5)
    figure.supylabel("inclination (°)", fontsize=10.5)
    if mesh is not None:
        add_apogee_bar(figure, mesh, axes)
    if np.isposinf(cube).any():
        from matplotlib.patches import Patch

        patch = Patch(color=ESCAPE, label="escape: the largest orbit is a hyperbola")
        figure.legend(handles=[patch], loc="outside lower right")
    figure.suptitle(f"{domain.scenario.name}: largest apogee within reach")


def _shade_escape(axis: Axes, edges: tuple[Array, Array], layer: Array) -> None:
    from matplotlib.colors import ListedColormap

    escape = np.where(np.isposinf(layer), 1.0, np.nan)
    if np.isfinite(escape).any():
        axis.pcolormesh(*edges, escape, cmap=ListedColormap([ESCAPE]), vmin=0.0, vmax=2.0, rasterized=True)


def draw_boundary(figure: Figure, domain: ReachableDomain) -> None:
    """The edge of the reachable planes for several perigee bounds, dashed outside the search box."""
    import matplotlib as mpl
    from matplotlib.patches import Rectangle

    axis = figure.subplots()
    grid = domain.scenario.grid
    inc, raan = grid.inclination_deg.values(), grid.raan_deg.values()
    heights = _spread(domain.limit.height_km, CURVES)
    colours = mpl.colormaps["viridis"](np.linspace(0.0, 0.85, len(heights)))
    for height, colour in zip(heights, colours, strict=True):
        _draw_clipped_edge(axis, domain, float(height), colour)
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


def _draw_edge(axis: Axes, domain: ReachableDomain, height: float) -> None:
    """The edge in the plane of node and inclination."""
    if domain.limit.covers(height):
        inc, node = edge_curve(domain, height)
        axis.plot(node, inc, color="black", linewidth=1.2)


def _draw_clipped_edge(axis: Axes, domain: ReachableDomain, height: float, colour: Any) -> None:
    """The same, dashed outside the search box."""
    if not domain.limit.covers(height):
        return
    inc, node = edge_curve(domain, height)
    grid = domain.scenario.grid
    low, high = grid.inclination_deg.first, grid.inclination_deg.values()[-1]
    west, east = grid.raan_deg.first, grid.raan_deg.values()[-1]
    inside = (inc >= low) & (inc <= high) & (node >= west) & (node <= east)
    beyond = ~inside | np.roll(~inside, 1) | np.roll(~inside, -1)
    for shown, style, label in ((inside, "-", bound_words(domain, height)), (beyond, (0, (3, 2)), None)):
        lines = (np.where(shown, each, np.nan) for each in (node, inc))
        axis.plot(*lines, color=colour, linewidth=2.0, linestyle=style, label=label)


def _mark_current(axis: Axes, domain: ReachableDomain, *, color: str, label: str | None = None) -> None:
    inc, raan = (float(np.rad2deg(x)) for x in inclination_and_node(domain.domain.frame.normal))
    axis.plot(
        [raan], [inc], marker="+", markersize=9, markeredgewidth=1.8, color=color, linestyle="", label=label
    )
