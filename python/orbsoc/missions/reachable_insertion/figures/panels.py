"""Figures of a plan, after figures 5–7 of Li et al. 2025: velocity, position and attitude over the burn.

Every figure overlays the collocation nodes on the independently propagated curve, and shows their difference
below, because the two curves are one to the eye. Matplotlib is imported when a figure is drawn, with the Agg
canvas and without pyplot: no global state, no display.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from orbsoc.guidance.figure_style import BLUE, GREEN, STYLE, VERMILION, labels_in_line, write_png
from orbsoc.guidance.mission import FigureFile
from orbsoc.orbit import EARTH, CanonicalUnits, pitch_yaw

from ..search.result import SearchResult
from ..verification import Verification
from . import orbit

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

COLOURS = (BLUE, VERMILION, GREEN)
MARGINS = {"left": 0.15, "right": 0.97, "bottom": 0.08, "top": 0.93}
"""Fixed, for a layout that is worked out takes as long as the drawing."""


def draw_figures(plan: SearchResult, folder: Path) -> tuple[FigureFile, ...]:
    """Write the figures of a plan that was flown into `folder`; empty when there is nothing to show."""
    found = plan.verification
    if found is None:
        return ()
    import matplotlib as mpl

    with mpl.rc_context(STYLE):
        told = orbit.draw(plan, found, folder)
        if plan.time_of_flight_s == 0.0:
            return told
        checks = (draw(plan, found, folder) for draw in (_velocity, _position, _attitude))
        return (*told, *(replace(each, appendix=True) for each in checks))


def _velocity(plan: SearchResult, found: Verification, folder: Path) -> FigureFile:
    nodes = CanonicalUnits.of(EARTH).state_to_si(plan.trajectory.states)[:, 3:] / 1e3
    curve = found.flight.propagated[:, 3:] / 1e3
    error = (found.flight.planned - found.flight.propagated)[:, 3:]
    figure = _components_figure(plan, found, nodes, curve, error, ("vx", "vy", "vz"), "km/s", "m/s")
    return write_png(
        figure,
        folder,
        "velocity.png",
        f"Velocity over the burn{_paper(plan, 'figure 5a')}: collocation nodes on the independently propagated"
        f" curves, {_axes_of(plan)}, and their difference.",
    )


def _position(plan: SearchResult, found: Verification, folder: Path) -> FigureFile:
    nodes = CanonicalUnits.of(EARTH).state_to_si(plan.trajectory.states)[:, :3] / 1e3
    curve = found.flight.propagated[:, :3] / 1e3
    error = (found.flight.planned - found.flight.propagated)[:, :3]
    figure = _components_figure(plan, found, nodes, curve, error, ("x", "y", "z"), "km", "m")
    return write_png(
        figure,
        folder,
        "position.png",
        f"Position over the burn{_paper(plan, 'figure 5b')}: collocation nodes on the independently propagated"
        f" curves, Earth-centred {_axes_of(plan)}, and their difference.",
    )


def _components_figure(
    plan: SearchResult,
    found: Verification,
    nodes: Array,
    curve: Array,
    error: Array,
    names: Sequence[str],
    unit: str,
    error_unit: str,
) -> Figure:
    """Three stacked panels, one per component, and the difference of planned and propagated below."""
    figure, axes = _panels(heights=(1.0, 1.0, 1.0, 0.8), size=(7.2, 7.4))
    node_times = _node_times(plan)
    for k, (name, colour) in enumerate(zip(names, COLOURS, strict=True)):
        axes[k].plot(found.flight.times_s, curve[:, k], color=colour, label="propagated (DOP853)")
        _dots(axes[k], node_times, nodes[:, k], colour, "collocation nodes")
        axes[k].set_ylabel(f"{name} ({unit})")
        axes[3].plot(found.flight.times_s, error[:, k], color=colour, linewidth=1.2, label=name)
    _legend_above(axes[0])
    axes[3].set_ylabel(f"planned −\npropagated ({error_unit})")
    axes[3].ticklabel_format(axis="y", style="sci", scilimits=(-2, 3))
    _legend_above(axes[3])
    _finish(axes, plan)
    return figure


def _attitude(plan: SearchResult, found: Verification, folder: Path) -> FigureFile:
    figure, axes = _panels(heights=(1.0, 1.0, 0.7), size=(7.2, 6.2))
    node_times = _node_times(plan)
    flown, nodal = pitch_yaw(found.flight.direction), pitch_yaw(plan.trajectory.controls)
    for k, (name, colour) in enumerate(zip(("pitch", "yaw"), COLOURS, strict=False)):
        curve, dots = np.rad2deg(flown[k]), np.rad2deg(nodal[k])
        axes[k].plot(found.flight.times_s, curve, color=colour, label="commanded and flown")
        _dots(axes[k], node_times, dots, colour, "collocation nodes")
        axes[k].set_ylabel(f"{name} (°)")
        axes[k].margins(y=0.12)
    _legend_above(axes[0])
    axes[2].plot(found.flight.times_s, found.flight.raw_norm - 1.0, color="#444444", linewidth=1.2)
    limit = plan.scenario.verification.thrust_excess
    if found.thrust_excess > 0.1 * limit:
        axes[2].axhline(limit, color=COLOURS[1], linewidth=1.0, linestyle="--")
        axes[2].annotate(
            "limit", (0.0, limit), xytext=(2, -3), textcoords="offset points", va="top", color=COLOURS[1]
        )
    axes[2].set_ylabel("‖u‖ − 1\nbefore normalising")
    axes[2].ticklabel_format(axis="y", style="sci", scilimits=(-2, 3))
    _finish(axes, plan)
    number = 6 if plan.scenario.problem == "min_time" else 7
    return write_png(
        figure,
        folder,
        "attitude.png",
        f"Thrust attitude over the burn{_paper(plan, f'figure {number}')}: pitch = atan2(u_y, u_x) and yaw = −asin(u_z) in"
        f" {_axes_of(plan)}, at the nodes and as commanded between them; below, how far the interpolated thrust is from unit length before it is"
        " normalised.",
    )


def _paper(plan: SearchResult, figure: str) -> str:
    """The figure of the paper that this one is after, for the paper's own scenarios."""
    return f" (the paper's {figure})" if plan.scenario.compare_with else ""


def _axes_of(plan: SearchResult) -> str:
    if plan.scenario.plan_axes == "eci":
        return "ECI axes"
    return "launch-inertial axes (x downrange, y up, z right)"


def _panels(heights: Sequence[float], size: tuple[float, float]) -> tuple[Figure, list[Axes]]:
    from matplotlib.figure import Figure

    figure = Figure(figsize=size)
    grid = {"height_ratios": heights, "hspace": 0.3, **MARGINS}
    axes = figure.subplots(len(heights), 1, sharex=True, gridspec_kw=grid)
    return figure, list(axes)


def _dots(axes: Axes, times: Array, values: Array, colour: str, label: str) -> None:
    axes.plot(
        times,
        values,
        linestyle="none",
        marker="o",
        markersize=5.5,
        markerfacecolor="white",
        markeredgecolor=colour,
        markeredgewidth=1.4,
        label=label,
        clip_on=False,
        zorder=3,
    )


def _legend_above(axes: Axes) -> None:
    """A one-line legend over the panel's right end, where it hides no curve."""
    axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=3, borderaxespad=0.1, handlelength=1.5)


def _finish(axes: Sequence[Axes], plan: SearchResult) -> None:
    for panel in axes:
        panel.yaxis.set_major_locator(_few_ticks())
    axes[-1].set_xlabel("time since ignition (s)")
    axes[-1].set_xlim(0.0, plan.time_of_flight_s)
    figure = axes[0].get_figure(root=True)
    assert figure is not None
    labels_in_line(axes)
    figure.suptitle(_title(plan), x=0.01, ha="left", fontweight="bold")


def _few_ticks() -> Any:
    from matplotlib.ticker import MaxNLocator

    return MaxNLocator(nbins=5, min_n_ticks=3)


def _node_times(plan: SearchResult) -> Array:
    return plan.trajectory.elapsed() * CanonicalUnits.of(EARTH).time_s


def _title(plan: SearchResult) -> str:
    what = "shortest burn" if plan.scenario.problem == "min_time" else "largest orbit"
    if plan.scenario.problem == "max_energy" and plan.scenario.target.perigee_direction == "free":
        what += ", perigee direction free"
    return f"{plan.scenario.name}: {what}, {plan.trajectory.grid.size} nodes"
