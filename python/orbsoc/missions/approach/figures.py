"""The figures of a plan: the orbital plane with keep-out and corridor, the abort fan, range and speed, aborts, and in space.

Matplotlib is imported when a figure is drawn, without pyplot: no global state, no display. V-bar to the right, nadir down.
"""

from __future__ import annotations

from math import radians, tan
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from orbsoc.guidance.figure_style import BLUE, BURN, GREEN, GREY, ORANGE, STYLE, VERMILION, panels, write_png
from orbsoc.guidance.mission import FigureFile
from orbsoc.orbit.array import Array
from orbsoc.orbit.relative import LVLH

from .planner import ApproachPlan
from .verification.aborts import kicked
from .verification.verify import Verification

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

KEEP_OUT, INSIDE = "#f3c9b5", "#d3ead9"
PLANE = "V-bar, x (m)", "R-bar, z to nadir (m)"
TIME = "time since the start (s)"
FAN = 12
"""Aborts that are drawn."""


def draw_figures(plan: ApproachPlan, folder: Path) -> tuple[FigureFile, ...]:
    """Write the figures of a plan that was flown into `folder`; empty where there is nothing to show."""
    found = plan.verification
    if found is None:
        return ()
    import matplotlib as mpl

    with mpl.rc_context(STYLE):
        return tuple(draw(plan, found, folder) for draw in (_plane, _fan, _speed, _aborts, _space))


def _plane(plan: ApproachPlan, found: Verification, folder: Path) -> FigureFile:
    figure, (whole, near) = panels((7.6, 8.2), (0.55, 1.0), share=False)
    before = [arc for arc in found.arcs if arc.times_s[0] < plan.approach.gate_s]
    drifts = [_drift(plan, float(arc.times_s[0]), arc.states[0]) for arc in before]
    for axes in (whole, near):
        _surroundings(plan, axes)
        for k, places in enumerate(drifts):
            label = "drift after a burn, if no other comes" if k == 0 else None
            axes.plot(places[:, 0], places[:, 2], color=ORANGE, lw=0.8, alpha=0.8, label=label)
        _flight(plan, found, axes)
    _frame(whole, [_track(found), *drifts])
    gate = float(np.linalg.norm(plan.scenario.gate.position()))
    reach = 1.5 * max(gate, float(plan.approach.axes_m.max()))
    _box(near, reach)
    _labels(plan, whole, *PLANE)
    _labels(plan, near, *PLANE, title=False)
    _legend(figure, near, 3)
    return write_png(
        figure, folder, "approach.png",
        "The approach in the orbital plane, V-bar to the right, nadir down; below, the surroundings of the target with"
        " keep-out and corridor. Thin: an orbit of free drift after each burn before the gate, if no other follows.",
    )  # fmt: skip


def _fan(plan: ApproachPlan, found: Verification, folder: Path) -> FigureFile:
    figure, (axes,) = panels((7.6, 6.0))
    _surroundings(plan, axes)
    inside = [each for each in found.aborts if each.time_s >= plan.approach.gate_s - 1e-6]
    shown = inside[:: max(1, len(inside) // FAN)] or list(found.aborts)
    seen: set[str] = set()

    def label(words: str) -> str | None:
        first = words not in seen
        seen.add(words)
        return words if first else None

    tracks = []
    for each in shown:
        free = _drift(plan, each.time_s, each.state)
        colour, words = (BLUE, "drift, safe by itself") if each.safe else (VERMILION, "drift, not safe")
        axes.plot(free[:, 0], free[:, 2], color=colour, lw=0.9, alpha=0.9, label=label(words))
        if not each.safe and each.dv_m_s is not None:
            away = _drift(plan, each.time_s, kicked(each.state, each.dv_m_s))
            axes.plot(
                away[:, 0],
                away[:, 2],
                color=GREEN,
                lw=1.1,
                ls=(0, (5, 2)),
                label=label("after the abort impulse"),
            )
            tracks.append(away)
    _flight(plan, found, axes)
    _box(axes, 2.2 * float(plan.approach.axes_m.max()))
    _labels(plan, axes, *PLANE)
    _legend(figure, axes, 3)
    caption = "What follows if the engine fails in the corridor: the drift of an orbit from instants of it"
    if not plan.approach.held:
        caption += (
            ", and, where that is not safe, the drift after the smallest impulse found that makes it so"
        )
    return write_png(figure, folder, "abort_fan.png", f"{caption}.")


def _speed(plan: ApproachPlan, found: Verification, folder: Path) -> FigureFile:
    figure, (axes,) = panels((7.6, 4.0))
    ranges = np.concatenate([np.linalg.norm(arc.states[:, :3], axis=1) for arc in found.arcs])
    speeds = np.concatenate([np.linalg.norm(arc.states[:, 3:], axis=1) for arc in found.arcs])
    axes.loglog(ranges, np.maximum(speeds, 1e-3), color=BLUE, lw=1.3, label="speed on the way")
    at = [arc.states[0] for arc in found.arcs]
    burns = [[float(np.linalg.norm(state[:3])), max(float(np.linalg.norm(state[3:])), 1e-3)] for state in at]
    axes.loglog(*np.array(burns).T, **BURN, ms=4, label=_marked(plan, "after a burn"))
    if plan.scenario.speed is not None:
        grid = np.geomspace(float(ranges.min()), float(ranges.max()), 200)
        axes.loglog(grid, plan.scenario.speed.limit(grid), color=VERMILION, ls=(0, (6, 4)), label="allowed")
    axes.axvline(float(plan.approach.axes_m.min()), color=GREY, lw=0.9, label="keep-out")
    axes.invert_xaxis()
    _labels(plan, axes, "range (m)", "speed (m/s)")
    _legend(figure, axes, 4)
    caption = "Speed by range, the flight from left to right, and the speed that is allowed."
    return write_png(figure, folder, "speed.png", caption)


def _aborts(plan: ApproachPlan, found: Verification, folder: Path) -> FigureFile:
    held = plan.approach.held
    figure, (top, *others) = panels((7.6, 3.6 if held else 5.2), (1.0,) if held else (1.2, 1.0))
    times = np.array([each.time_s for each in found.aborts])
    margins = np.array([each.drift_margin_m for each in found.aborts])
    safe = np.array([each.safe for each in found.aborts])
    top.plot(times, margins, color=GREY, lw=0.9)
    top.plot(times[safe], margins[safe], ls="none", marker=".", color=BLUE, label="drift safe by itself")
    top.plot(times[~safe], margins[~safe], ls="none", marker="x", color=VERMILION, label="not safe")
    top.axhline(0.0, color="#222222", lw=0.8)
    top.axvline(plan.approach.gate_s, color=GREEN, lw=1.0, label="gate is left")
    _labels(plan, top, "", "margin of the\ndrift (m)")
    top.legend(fontsize=9, ncols=3, loc="upper center", bbox_to_anchor=(0.5, 1.0 if held else -0.02))
    if held:
        top.set_xlabel(TIME)
        caption = (
            "By when thrust fails: how far outside the keep-out, and off the target's body, the drift stays."
        )
        return write_png(figure, folder, "aborts.png", caption)
    (bottom,) = others
    sizes = np.array([each.size_m_s for each in found.aborts])
    needed = ~safe & np.isfinite(sizes)
    if needed.any():
        bottom.stem(
            times[needed], sizes[needed], linefmt=GREEN, markerfmt="o", basefmt=" ", label="abort impulse"
        )
    none = ~safe & ~np.isfinite(sizes)
    most = plan.scenario.safety.abort_m_s
    bottom.plot(
        times[none], np.full(none.sum(), most), ls="none", marker="x", color=VERMILION, label="none found"
    )
    bottom.set_ylim(
        0.0, 1.15 * (float(sizes[needed].max(initial=0.0)) or most) if not none.any() else 1.1 * most
    )
    bottom.set_xlim(0.0, plan.approach.duration_s)
    _labels(plan, bottom, TIME, "abort\nimpulse (m/s)", title=False)
    return write_png(
        figure, folder, "aborts.png",
        "By when the engine fails: how far outside the keep-out, and off the target's body, the drift stays, and the smallest"
        " impulse found that makes it safe where it is not.",
    )  # fmt: skip


def _space(plan: ApproachPlan, found: Verification, folder: Path) -> FigureFile:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7.4, 5.6))
    axes: Any = figure.add_axes((0.0, 0.06, 0.94, 0.92), projection="3d")
    radii = plan.approach.axes_m @ np.abs(LVLH.T)
    u, v = np.meshgrid(np.linspace(0.0, 2.0 * np.pi, 37), np.linspace(0.0, np.pi, 19))
    ball = np.stack([np.cos(u) * np.sin(v), np.sin(u) * np.sin(v), np.cos(v)], axis=-1) * radii
    axes.plot_surface(*np.moveaxis(ball, -1, 0), color=VERMILION, alpha=0.12, linewidth=0, shade=False)
    corridor = plan.scenario.corridor
    gate = float(np.linalg.norm(plan.scenario.gate.position()))
    if corridor is not None:
        axis = LVLH @ corridor.direction()
        across = np.linalg.svd(axis[None])[2][1:]
        length = np.array([0.0, gate - corridor.apex_m])[:, None]
        around = np.linspace(0.0, 2.0 * np.pi, 37)[None, :]
        ring = np.cos(around)[..., None] * across[0] + np.sin(around)[..., None] * across[1]
        radius = tan(radians(corridor.half_angle_deg)) * length[..., None]
        cone = (corridor.apex_m + length[..., None]) * axis + radius * ring
        axes.plot_surface(*np.moveaxis(cone, -1, 0), color=GREEN, alpha=0.25, linewidth=0, shade=False)
    track = _track(found)
    near = track[np.linalg.norm(track, axis=1) < 3.0 * gate]
    axes.plot(*near.T, color="#222222", lw=1.8, label="approach")
    nodes = np.array([arc.states[0, :3] @ LVLH.T for arc in found.arcs])
    nodes = nodes[np.linalg.norm(nodes, axis=1) < 3.0 * gate]
    nodes_are = "arcs begin" if plan.approach.held else "impulses"
    axes.plot(*nodes.T, ls="none", marker="o", ms=3, color=BLUE, label=nodes_are)
    axes.plot([0.0], [0.0], [0.0], marker="s", ms=6, color=GREY, ls="none", label="target")
    for name, words, pad in (("x", "V-bar, x (m)", 8), ("y", "H-bar, y (m)", 8), ("z", "R-bar, z (m)", 4)):
        getattr(axes, f"set_{name}label")(words, labelpad=pad)
    axes.invert_zaxis()
    axes.set_aspect("equal")
    axes.view_init(elev=20.0, azim=-60.0)
    axes.locator_params(nbins=5)
    figure.legend(*axes.get_legend_handles_labels(), loc="lower center", ncols=3, fontsize=9)
    return write_png(
        figure,
        folder,
        "space.png",
        f"The last part of the approach in space: keep-out, corridor, and where {'arcs of thrust begin' if plan.approach.held else 'impulses are'}.",
    )


def _drift(plan: ApproachPlan, t_s: float, state: Array) -> Array:
    """Positions of an orbit of drift after a state, in x, y, z."""
    lapse = np.linspace(0.0, plan.approach.period_s, 241)
    motion = plan.approach.motion
    places = np.array([motion.transition(t_s + float(t), t_s)[:3] @ state for t in lapse])
    return np.asarray(places @ LVLH.T)


def _track(found: Verification) -> Array:
    return np.asarray(np.concatenate([arc.states[:, :3] for arc in found.arcs]) @ LVLH.T)


def _surroundings(plan: ApproachPlan, axes: Axes) -> None:
    """The keep-out, and the corridor out to the gate."""
    from matplotlib.patches import Ellipse, Polygon

    depth, width, _ = plan.approach.axes_m
    axes.add_patch(Ellipse((0, 0), 2 * width, 2 * depth, color=KEEP_OUT, lw=0, label="keep-out", zorder=1))
    corridor = plan.scenario.corridor
    if corridor is not None and abs(corridor.direction()[2]) < 0.5:
        length = float(np.linalg.norm(plan.scenario.gate.position())) - corridor.apex_m
        axis = LVLH @ corridor.direction()
        flat = np.array([axis[0], axis[2]])
        side = tan(radians(corridor.half_angle_deg)) * length * np.array([-flat[1], flat[0]])
        apex, end = corridor.apex_m * flat, (corridor.apex_m + length) * flat
        shape = Polygon(
            np.array([apex, end + side, end - side]), color=INSIDE, lw=0, label="corridor", zorder=2
        )
        axes.add_patch(shape)
    axes.plot(0, 0, marker="s", ms=5, color="#222222", ls="none", label="target", zorder=6)


def _flight(plan: ApproachPlan, found: Verification, axes: Axes) -> None:
    track = _track(found)
    axes.plot(track[:, 0], track[:, 2], color="#222222", lw=1.8, label="approach", zorder=4)
    fired = [
        arc.states[0, :3] @ LVLH.T
        for arc, size in zip(found.arcs, plan.programme.sizes_m_s, strict=True)  # type: ignore[union-attr]
        if size > 1e-6
    ]
    nodes = np.array(fired).reshape(-1, 3)
    axes.plot(nodes[:, 0], nodes[:, 2], **BURN, ms=4, label=_marked(plan, "burn"), zorder=5)


def _marked(plan: ApproachPlan, burn: str) -> str:
    """What a mark says: of an impulse so, of thrust that is held where it begins."""
    return "thrust begins" if plan.approach.held else burn


def _frame(axes: Axes, tracks: list[Array]) -> None:
    both = np.concatenate(tracks)
    low, high = both.min(axis=0), both.max(axis=0)
    pad = 0.05 * max(high[0] - low[0], high[2] - low[2])
    axes.set_xlim(low[0] - pad, high[0] + pad)
    axes.set_ylim(high[2] + pad, low[2] - pad)
    axes.set_aspect("equal")


def _box(axes: Axes, reach: float) -> None:
    axes.set_xlim(-1.5 * reach, 1.5 * reach)
    axes.set_ylim(reach, -reach)
    axes.set_aspect("equal")


def _labels(plan: ApproachPlan, axes: Axes, along: str, up: str, *, title: bool = True) -> None:
    axes.set_xlabel(along)
    axes.set_ylabel(up)
    if title and plan.programme is not None:
        axes.set_title(f"{plan.scenario.name}: {plan.words}", loc="left", fontsize=11, fontweight="bold")


def _legend(figure: Figure, axes: Axes, columns: int) -> None:
    figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=columns, fontsize=9)
