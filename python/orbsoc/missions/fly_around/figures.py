"""Figures of a plan: the ellipse with its tube and pulses, the error over time, the pulses, their price, engine failures.

Matplotlib is imported when a figure is drawn, with the Agg canvas and without pyplot: no global state, no display.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from orbsoc.guidance.figure_style import BLUE, GREEN, GREY, STYLE, VERMILION, panels, write_png
from orbsoc.guidance.mission import FigureFile
from orbsoc.orbit.array import Array
from orbsoc.orbit.relative import LVLH

from .paper import is_papers
from .planner import FlyAround
from .verification import Checked, inner_radius_m

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

TUBE_AROUND = 24
PRIMER_POINTS = 721
ARROW_M_PER_M_S = 0.35
"""Of the longer semi-axis, for the largest pulse but the first."""


def draw_figures(plan: FlyAround, folder: Path) -> tuple[FigureFile, ...]:
    """Write the figures of a plan that has a programme into `folder`; empty when there is nothing to show."""
    found = plan.verification
    if found is None:
        return ()
    import matplotlib as mpl

    with mpl.rc_context(STYLE):
        figures = [_path(plan, found, folder), _error(plan, found, folder), _pulses(plan, found, folder)]
        figures.append(_engine(plan, found, folder))
        if plan.front:
            figures.append(_front(plan, found, folder))
    return tuple(figures)


def _path(plan: FlyAround, found: Checked, folder: Path) -> FigureFile:
    """The paper's figure 4a, with the pulses, in the target's axes."""
    from matplotlib.figure import Figure

    scenario = plan.scenario
    ellipse = scenario.flight.ellipse
    figure = Figure(figsize=(7.4, 5.8))
    axes: Any = figure.add_axes((0.0, 0.04, 0.94, 0.94), projection="3d")
    tube = _tube_surface(plan)
    axes.plot_surface(*tube, color=BLUE, alpha=0.10, linewidth=0, antialiased=False, shade=False)
    times = np.linspace(0.0, scenario.duration_s, 400)
    line = ellipse.position(times) @ LVLH.T
    axes.plot(*line.T, color=BLUE, linewidth=1.2, label=f"ellipse, tube of {scenario.tolerance_m:g} m")
    flown = found.truth.positions_m[:, 0] @ LVLH.T
    axes.plot(*flown.T, color=VERMILION, linewidth=1.2, label="flown, with J2 and drag")
    nodes = found.flown.before[:-1, :3] @ LVLH.T
    axes.plot(*nodes.T, linestyle="none", marker="o", markersize=5, color="black", label="pulses")
    pulses = found.programme.dv_m_s @ LVLH.T
    sizes = found.programme.sizes_m_s
    usual = float(sizes[1:].max()) if len(sizes) > 1 else float(sizes.max())
    scale = ARROW_M_PER_M_S * max(scenario.ellipse.semi_axes_m) / usual if usual > 0.0 else 0.0
    axes.quiver(*nodes.T, *(scale * pulses).T, color=GREEN, linewidth=1.4, arrow_length_ratio=0.25)
    axes.plot([], [], color=GREEN, label=f"Δv; after the first ≤ {usual:.3f} m/s")
    axes.plot([0.0], [0.0], [0.0], marker="s", color=GREY, markersize=7, linestyle="none", label="target")
    axes.set_xlabel("x, motion (m)", labelpad=8)
    axes.set_ylabel("y, −normal (m)", labelpad=8)
    axes.set_zlabel("z, nadir (m)", labelpad=4)
    axes.invert_zaxis()
    axes.set_aspect("equal")
    axes.set_box_aspect(axes.get_box_aspect(), zoom=1.15)
    axes.view_init(elev=22.0, azim=-62.0)
    axes.locator_params(nbins=5)
    figure.legend(*axes.get_legend_handles_labels(), loc="lower center", ncols=3, fontsize=9.5)
    _title(figure, plan)
    return write_png(
        figure, folder, "ellipse.png",
        "The fly-around in the target's axes (the paper's figure 4a): the ellipse with the tube about it, the flight with"
        " J2 and drag, the pulses and their velocity changes.",
    )  # fmt: skip


def _tube_surface(plan: FlyAround) -> tuple[Array, Array, Array]:
    """Points on the tube, in the target's axes."""
    ellipse = plan.scenario.flight.ellipse
    times = np.linspace(0.0, plan.scenario.duration_s, 160)
    centre, along = ellipse.position(times), ellipse.velocity(times)
    along /= np.linalg.norm(along, axis=1)[:, None]
    normal = ellipse.frame[1]
    across = np.cross(along, normal)
    angle = np.linspace(0.0, 2.0 * np.pi, TUBE_AROUND)[None, :, None]
    ring = np.cos(angle) * normal + np.sin(angle) * across[:, None, :]
    points = (centre[:, None, :] + plan.scenario.tolerance_m * ring) @ LVLH.T
    return points[..., 0], points[..., 1], points[..., 2]


def _error(plan: FlyAround, found: Checked, folder: Path) -> FigureFile:
    """The paper's figure 4b."""
    figure, (axes,) = panels((7.4, 3.6))
    scenario, truth = plan.scenario, found.truth
    if found.dispersed is not None:
        band = np.quantile(found.dispersed.errors_m, [0.05, 0.95], axis=1)
        label = "dispersed, 5 to 95 %"
        axes.fill_between(found.dispersed.times_s, *band, color=GREY, alpha=0.22, linewidth=0, label=label)
    axes.plot(truth.times_s, truth.errors_m[:, 0], color=VERMILION, label="flown, J2 and drag")
    ring: Any = {"ls": "none", "marker": "o", "mfc": "white", "mec": BLUE, "zorder": 3}
    axes.plot(found.flown.errors_at_s, found.flown.errors_m, **ring, label="largest of each arc")
    axes.axhline(scenario.tolerance_m, color="black", linewidth=1.0, linestyle="--")
    axes.plot([], [], color="black", linewidth=1.0, linestyle="--", label=f"{scenario.tolerance_m:g} m")
    _mark_pulses(axes, found)
    axes.set_ylabel("distance from the\nellipse (m)")
    axes.set_ylim(0.0, 1.08 * max(float(axes.get_ylim()[1]), scenario.tolerance_m))
    _over_time(axes, plan)
    return write_png(
        figure, folder, "error.png",
        "Distance from the moving point of the ellipse (the paper's figure 4b); ticks at the top are pulses.",
    )  # fmt: skip


def _pulses(plan: FlyAround, found: Checked, folder: Path) -> FigureFile:
    """The paper's figures 4c and 4d, and the primer vector where there is one."""
    programme = found.programme
    tube = plan.search.found if plan.search is not None else None
    figure, (axes, *below) = panels((7.4, 3.4), (1.0,)) if tube is None else panels((7.4, 5.0), (1.0, 1.0))
    width = 0.35 * float(np.diff(np.append(programme.times_s, found.flown.end_s)).mean()) / 3.0
    for k, (name, colour) in enumerate(zip("RTN", (BLUE, VERMILION, GREEN), strict=True)):
        at = programme.times_s + (k - 1) * width
        axes.bar(at, programme.dv_m_s[:, k], width, color=colour, label=f"$Δv_{name}$")
    axes.plot(
        programme.times_s, programme.sizes_m_s, ls="none", marker="_", ms=13, color="black", label="‖Δv‖"
    )
    axes.axhline(0.0, color="black", linewidth=0.8)
    axes.set_ylabel("velocity change\n(m/s)")
    _over_time(axes, plan)
    caption = (
        f"The {len(programme)} pulses (the paper's figures 4c, 4d): components radial, along the motion and along the"
        f" angular momentum, and sizes; {programme.total_m_s:.3f} m/s in all."
    )
    if tube is not None:
        times = np.linspace(0.0, plan.scenario.duration_s, PRIMER_POINTS)
        sizes = tube.impulses.primer_size(tube.solution, times)
        at_pulses = tube.impulses.primer_size(tube.solution, programme.times_s)
        below[0].plot(times, sizes, color=BLUE, linewidth=1.2)
        below[0].plot(programme.times_s, at_pulses, ls="none", marker="o", ms=4, color="black")
        below[0].axhline(1.0, color="black", linewidth=1.0, linestyle="--")
        below[0].set_ylabel("primer vector")
        below[0].set_xlabel("time (s)")
        axes.set_xlabel("")
        caption += " Below, the length of the primer vector: 1 at a pulse, and above 1 where one more pulse would save fuel."
    return write_png(figure, folder, "delta_v.png", caption)


def _engine(plan: FlyAround, found: Checked, folder: Path) -> FigureFile:
    figure, (axes,) = panels((7.4, 3.4))
    times = found.programme.times_s
    out = [each.distance_m for each in found.engine_out]
    cut = [each.distance_m for each in found.cut_burns]
    axes.vlines(times, cut, out, color="#bbbbbb", linewidth=2.0)
    axes.plot(times, out, ls="none", marker="o", color=BLUE, label="engine out after the pulse")
    axes.plot(times, cut, ls="none", marker="v", color=VERMILION, label="pulse cut at its worst fraction")
    inner = inner_radius_m(plan.scenario)
    axes.axhline(inner, color="black", linewidth=1.0, linestyle="--")
    place: Any = {"xycoords": ("axes fraction", "data"), "textcoords": "offset points", "va": "top"}
    axes.annotate("inner edge of the tube", (0.0, inner), xytext=(12, -3), **place)
    axes.set_ylabel("least distance from\nthe target, 2 orbits (m)")
    axes.set_ylim(0.0, 1.1 * max(out))
    _over_time(axes, plan)
    return write_png(
        figure, folder, "engine_out.png",
        "How near the free drift comes to the target within two orbits when the engine fails after a pulse, or within it"
        " at the worst fraction.",
    )  # fmt: skip


def _front(plan: FlyAround, found: Checked, folder: Path) -> FigureFile:
    figure, (axes,) = panels((7.4, 3.8))
    points = [(len(found.programme), found.programme.total_m_s)]
    points += [(each.pulses, each.dv_m_s) for each in plan.front if each.dv_m_s is not None]
    points.sort()
    axes.plot(*np.array(points).T, color=BLUE, marker="o", label="free within the tube, the cheapest found")
    if is_papers(plan.scenario):
        axes.plot([19, 20], [3.315, 3.237], ls="none", marker="s", color=VERMILION, label="the paper's two")
    search = plan.search
    axes.set_xscale("log")
    counts = sorted({count for count, _ in points})
    axes.set_xticks(counts, [str(count) for count in counts])
    axes.minorticks_off()
    if search is not None and search.impossible >= 1:
        edge = search.impossible + 0.5
        axes.axvspan(0.84 * edge, edge, color=GREY, alpha=0.18, linewidth=0)
        axes.set_xlim(0.84 * edge, None)
        text = f"{search.impossible} and fewer: proved impossible"
        place: Any = {"xycoords": ("data", "axes fraction"), "ha": "center", "va": "center"}
        axes.annotate(text, (0.92 * edge, 0.5), rotation=90, **place)
    axes.set_xlabel("number of pulses")
    axes.set_ylabel("Σ‖Δv‖ (m/s)")
    axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, borderaxespad=0.1)
    _title(figure, plan)
    return write_png(
        figure, folder, "front.png",
        f"The price of a pulse: the least velocity change found with each number of pulses within"
        f" {plan.scenario.tolerance_m:g} m, and what is proved impossible.",
    )  # fmt: skip


def _mark_pulses(axes: Axes, found: Checked) -> None:
    for t in found.programme.times_s:
        axes.plot([t, t], [0.97, 1.0], transform=axes.get_xaxis_transform(), color="black", linewidth=0.9)


def _over_time(axes: Axes, plan: FlyAround) -> None:
    axes.set_xlabel("time (s)")
    axes.set_xlim(-0.02 * plan.scenario.duration_s, 1.02 * plan.scenario.duration_s)
    axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=4, borderaxespad=0.1, handlelength=1.2)
    figure = axes.get_figure(root=True)
    assert figure is not None
    _title(figure, plan)


def _title(figure: Figure, plan: FlyAround) -> None:
    assert plan.verification is not None
    count = len(plan.verification.programme)
    text = f"{plan.scenario.name}: {count} pulse{'s' if count != 1 else ''}"
    figure.suptitle(text, x=0.01, ha="left", fontweight="bold", fontsize=11)
