"""The orbits before, between and after the burns of a plan, with coasts, burns and thrust, seen from the first one's angular momentum."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from orbsoc.guidance.figure_style import BLUE, GREEN, VERMILION
from orbsoc.guidance.orbit_drawing import draw_earth, draw_orbit, plane_of
from orbsoc.orbit import ConstantsSet, elements_from_state
from orbsoc.orbit.array import Array

from ..verification import Arcs, shape_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

BEFORE, BURN, AFTER, COAST, BETWEEN = BLUE, VERMILION, GREEN, "#7a7a7a", "#CC79A7"
"""The last one is Okabe–Ito reddish purple, of the transfer orbit."""
INSIDE = 0.5
"""Of a panel's side, that the Earth has to take for a close-up within it."""
FAR = 4.0
"""Start radii, to which a hyperbola is drawn."""
ROOM = 1.25
"""Factor on the panel's span where the close-up stands in a corner."""


def orbit_figure(title: str, start: Array, arcs: Arcs) -> Figure:
    """From a first state (6,) over coasts and burns; one burn is enlarged, of several each has its number."""
    from matplotlib.figure import Figure

    axes, one = plane_of(start), len(arcs.burns) == 1
    figure = Figure(figsize=(7.2, 7.2 if one else 7.6))
    panel = figure.add_axes((0.15, 0.215, 0.8, 0.73) if one else (0.15, 0.255, 0.8, 0.69))
    about = arcs.burns[0].about
    draw_earth(panel, about)
    reach = FAR * max(float(np.linalg.norm(x.propagated[:, :3], axis=1).max()) for x in arcs.burns) / 1e3
    names = [("before", BEFORE, "-"), *[("between", BETWEEN, ":")] * (not one), ("after", AFTER, "-")]
    shown = []
    for state, (name, colour, style) in zip(
        (start, *(each.propagated[-1] for each in arcs.burns)), names, strict=True
    ):
        orbit = elements_from_state(state[:3], state[3:], about)
        shown.append(draw_orbit(orbit, axes, reach))
        panel.plot(*shown[-1], color=colour, linestyle=style, label=f"{name}: {shape_of(orbit)}")
    for coast, colour in zip(arcs.coasts, (COAST, BETWEEN), strict=False):
        if coast.times_s.size and coast.times_s[-1] > 0.0:
            way = coast.states[:, :3] @ axes.T / 1e3
            label = f"coast, {coast.times_s[-1]:.0f} s"
            panel.plot(way[:, 0], way[:, 1], color=colour, linewidth=2.6, alpha=0.75, label=label)
    span = float(np.ptp(panel.get_xlim()))
    for k, burn in enumerate(arcs.burns):
        way, u = burn.propagated[:, :3] @ axes.T / 1e3, burn.direction @ axes.T
        duration_s = float(burn.times_s[-1])
        out_deg = float(np.rad2deg(np.arcsin(np.clip(np.abs(u[:, 2]).max(), 0.0, 1.0))))
        label = f"burn, {duration_s:.1f} s"
        if not one:
            label = f"burn {k + 1}, {duration_s:.1f} s, up to {out_deg:.1f}° out of the first orbit's plane"
            _arrows(panel, way, 0.09 * span * u, 3, 0.005)
            middle = way[len(way) // 2, :2]
            aside = -16.0 * middle / np.linalg.norm(middle)
            panel.annotate(
                f"{k + 1}", (middle[0], middle[1]), (float(aside[0]), float(aside[1])), textcoords="offset points",
                ha="center", va="center", fontweight="bold", color=BURN,
            )  # fmt: skip
        panel.plot(*way[0, :2], "o", color=BURN, markersize=5)
        if duration_s > 0.0:
            panel.plot(way[:, 0], way[:, 1], color=BURN, linewidth=4.2, label=label)
    panel.set_aspect("equal", adjustable="datalim")
    panel.set_xlabel("along the first position, in the first orbit's plane (km)")
    panel.set_ylabel("ahead of it (km)")
    columns, size = (1, 9.5) if one else (2, 8.5)
    panel.legend(loc="upper center", bbox_to_anchor=(0.45, -0.085), ncols=columns, fontsize=size)
    if one and duration_s > 0.0:
        _close_up(panel, way, u, np.hstack(shown), out_deg, about)
    figure.suptitle(title, x=0.01, ha="left", fontweight="bold")
    return figure


def _arrows(panel: Axes, way: Array, thrust: Array, count: int, width: float) -> None:
    at = np.linspace(0, len(way) - 1, count).astype(int)
    panel.quiver(
        way[at, 0], way[at, 1], thrust[at, 0], thrust[at, 1], angles="xy", scale_units="xy", scale=1.0, width=width,
        color="#222222", zorder=3,
    )  # fmt: skip


def _close_up(
    panel: Axes, burn: Array, direction: Array, orbits: Array, out_deg: float, about: ConstantsSet
) -> None:
    """The burn arc with thrust arrows, in a panel of its own: inside the Earth, or in the emptiest corner."""
    span = max(float(np.ptp(burn[:, 0])), float(np.ptp(burn[:, 1])), 1e-3)
    panel.apply_aspect()
    corner, size = _free_place(panel, orbits, about)
    inset = panel.inset_axes((*corner, size, size))
    inset.plot(burn[:, 0], burn[:, 1], color=BURN, linewidth=3.0)
    length = 0.28 * span
    _arrows(inset, burn, length * direction, 7, 0.018)
    middle, half = (burn.min(axis=0) + burn.max(axis=0))[:2] / 2, 0.5 * span + 1.15 * length
    inset.set(
        xlim=(middle[0] - half, middle[0] + half), ylim=(middle[1] - half, middle[1] + half), aspect="equal"
    )
    inset.set(xticks=[], yticks=[])
    inset.set_title("thrust over the burn", fontsize=8.5)
    inset.set_xlabel(f"{span:.0f} km across\nup to {out_deg:.1f}° out of the plane", fontsize=8)


def _free_place(panel: Axes, orbits: Array, about: ConstantsSet) -> tuple[tuple[float, float], float]:
    """Lower left corner and size, in shares of the panel, of a square that hides little of the orbits (2, K)."""
    low, high = np.array([panel.get_xlim(), panel.get_ylim()]).T
    globe = 2e-3 * about.earth_radius_m / (high - low)
    if globe.min() > INSIDE:
        size = 0.3 * float(globe.min())
        middle = -low / (high - low)
        return (float(middle[0]) - size / 2, float(middle[1]) - size / 2), size
    middle, half = (low + high) / 2, ROOM * (high - low) / 2
    low, high = middle - half, middle + half
    panel.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
    size = 0.23
    places = [(x, y) for x in (0.03, 0.97 - size) for y in (0.09, 0.94 - size)]
    at = (orbits - low[:, None]) / (high - low)[:, None]
    hidden = [
        sum(np.all(np.abs(at.T - np.array(place) - size / 2) < 0.85 * size, axis=1)) for place in places
    ]
    return places[int(np.argmin(hidden))], size
