"""Curves of a plan: margins over time, cut burns, the primer, the scan of times, the front, flights with errors."""

from __future__ import annotations

from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from orbsoc.guidance.figure_style import BLUE, BURN, GREEN, ORANGE, VERMILION, panels, write_png
from orbsoc.guidance.mission import FigureFile

from ..planner import ApproachPlan
from ..verification import LIMIT_M

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLOURS = (BLUE, GREEN, "#CC79A7", "#56B4E9", ORANGE, "#000000")
UNSAFE, KEEP_OUT = VERMILION, "#f3c9b5"
"""For what is unsafe alone."""
STAR: Any = {"marker": "*", "ms": 13, "color": "#222222", "ls": "none", "zorder": 5}
SHOWN = 6
"""Impulses that are drawn with a drift of their own; of more, the first ones."""
TIME = "time since the first impulse (s)"


def colour(k: int) -> str:
    return COLOURS[k % len(COLOURS)]


def labelled(plan: ApproachPlan, axes: Axes, along: str, up: str, *, title: bool = True) -> None:
    """Labels, and the plan's name and cost above."""
    assert plan.programme is not None
    axes.set_xlabel(along)
    axes.set_ylabel(up)
    if title:
        text = f"{plan.scenario.name}: {plan.programme.words}"
        axes.set_title(text, loc="left", fontsize=11, fontweight="bold")


def legend(figure: Figure, axes: Axes, columns: int = 1) -> None:
    figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=columns, fontsize=9)


def margins(plan: ApproachPlan, folder: Path) -> FigureFile:
    found, programme, end = plan.verification, plan.programme, plan.approach.duration_s
    assert found is not None
    assert programme is not None
    figure, (top, bottom) = panels((7.6, 5.6), (1.0, 1.5))
    sums = np.cumsum(programme.sizes_m_s)
    steps = np.concatenate([[0.0], np.repeat(programme.times_s, 2), [end]])
    top.plot(steps, np.concatenate([[0.0, 0.0], np.repeat(sums, 2)])[: steps.size], color=BLUE)
    few = len(programme) <= SHOWN
    for t, total, size in zip(programme.times_s, sums, programme.sizes_m_s, strict=True):
        if few:
            top.annotate(f"+{size:.4f}", (t, total), xytext=(4, -12), textcoords="offset points", fontsize=9)
    labelled(plan, top, "", "Δv spent (m/s)")
    away = np.linalg.norm(found.track, axis=1)
    bottom.semilogy(found.times_s, away, color="#222222", label="distance from the target")
    for truth in (each for each in found.truths if each.name == "j2"):
        flown = np.linalg.norm(truth.track, axis=1)
        times = np.linspace(0.0, end, flown.size)
        bottom.semilogy(times, flown, color=GREEN, ls=(0, (4, 3)), label="the same with J$_2$")
    if plan.approach.guarded and few:
        ends = [*(cut.time_s for cut in found.cuts[1:]), end]
        for k, (cut, until) in enumerate(zip(found.cuts, ends, strict=True)):
            bottom.hlines(cut.completed_m, cut.time_s, until, color=colour(k), lw=2.2)
            shade = UNSAFE if cut.distance_m < plan.scenario.keep_out_m - LIMIT_M else colour(k)
            bottom.vlines(cut.time_s, max(cut.distance_m, 1.0), cut.completed_m, color=shade, lw=1.4, ls=":")
        bottom.plot([], [], color=BLUE, lw=2.2, label="nearest of the drift, if no later burn comes")
        bottom.plot([], [], color=UNSAFE, lw=1.2, ls=":", label="… if the burn stops inside")
    if plan.approach.guarded:
        bottom.axhline(plan.scenario.keep_out_m, color=UNSAFE, lw=1.0, label="keep-out")
    labelled(plan, bottom, TIME, "metres", title=False)
    bottom.set_xlim(0.0, end)
    bottom.set_ylim(bottom=1.0)
    legend(figure, bottom, 2)
    return write_png(
        figure, folder, "margins.png",
        "Velocity change spent, and how near the chaser comes: on its way, and for all later time by the drift that it is"
        " on. Dotted: down to the worst place at which a burn can stop.",
    )  # fmt: skip


def cut_burns(plan: ApproachPlan, folder: Path) -> FigureFile:
    assert plan.verification is not None
    figure, (axes,) = panels((7.6, 4.2))
    keep_out = plan.scenario.keep_out_m
    for k, cut in enumerate(plan.verification.cuts[:SHOWN]):
        fractions, nearest = (
            np.linspace(0.0, 100.0, cut.by_fraction_m.size),
            np.maximum(cut.by_fraction_m, 0.01),
        )
        axes.semilogy(fractions, nearest, color=colour(k), label=f"burn {cut.number}")
    lowest = axes.get_ylim()[0]
    axes.axhspan(lowest, keep_out, color=KEEP_OUT, alpha=0.6, lw=0, zorder=0)
    axes.set_ylim(bottom=lowest)
    axes.axhline(keep_out, color=UNSAFE, lw=1.0)
    place: Any = {"xytext": (-4, -3), "textcoords": "offset points", "va": "top", "ha": "right"}
    axes.annotate("keep-out", (100, keep_out), color=UNSAFE, **place)
    axes.set_xlim(0, 100)
    until = "for all later time" if plan.approach.circular else "in one orbit"
    labelled(plan, axes, "how much of the burn is flown before the engine stops (%)", f"nearest {until} (m)")
    legend(figure, axes, 6)
    return write_png(
        figure, folder, "cut_burns.png",
        "Where a burn may stop: the least distance from the target over all later time, by the fraction that is flown.",
    )  # fmt: skip


def primer(plan: ApproachPlan, folder: Path) -> FigureFile:
    assert plan.programme is not None
    assert plan.timed is not None
    assert plan.timed.best is not None
    impulses, solution = plan.timed.best.impulses, plan.timed.best.solution
    figure, (axes,) = panels((7.6, 3.6))
    times, at = np.linspace(0.0, plan.approach.duration_s, 361), plan.programme.times_s
    axes.plot(times, impulses.primer_size(solution, times), color=BLUE)
    axes.plot(at, impulses.primer_size(solution, at), **BURN)
    axes.axhline(1.0, color="#999999", lw=0.9, ls=(0, (6, 4)))
    axes.set_xlim(0.0, plan.approach.duration_s)
    axes.set_ylim(bottom=0.0)
    labelled(plan, axes, TIME, "primer magnitude")
    return write_png(
        figure, folder, "primer.png",
        "The primer, what an impulse at each time would be worth against its cost, with the burns. Above 1 another time"
        " would save Δv if it added no condition of its own; each burn here adds the safety of its drift.",
        appendix=True,
    )  # fmt: skip


def scan(plan: ApproachPlan, folder: Path) -> FigureFile:
    assert plan.timed is not None
    assert plan.timed.best is not None
    figure, (axes,) = panels((7.6, 3.6))
    trials = sorted(plan.timed.trials, key=lambda trial: trial.second_s)
    times = np.array([trial.second_s for trial in trials])
    costs = np.array([trial.cost if trial.cost < inf else np.nan for trial in trials])
    axes.plot(times, costs, color=BLUE, marker=".", ms=5, lw=1.2)
    bad = times[~np.isfinite(costs)]
    if bad.size:
        least = np.full(bad.size, np.nanmin(costs))
        axes.plot(bad, least, ls="none", marker="x", ms=4, color=UNSAFE, label="infeasible")
        legend(figure, axes)
    axes.plot(plan.timed.best.second_s, plan.timed.best.cost, **STAR)
    labelled(plan, axes, "time of impulse 2 (s)", "cost (m/s)")
    caption = f"Cost by the time of the second impulse, {len(trials)} problems; the star is the plan."
    return write_png(figure, folder, "timing.png", caption, appendix=True)


def front(plan: ApproachPlan, folder: Path) -> FigureFile:
    figure, (axes,) = panels((7.6, 4.0))
    names = (
        "after completed burns",
        "also for one orbit after a cut burn",
        "also for two orbits after a cut burn",
    )
    for orbits, name in enumerate(names):
        points = [point for point in plan.front if point.orbits == orbits]
        times = np.array([point.duration_s for point in points])
        costs = np.array([point.cost if point.cost < inf else np.nan for point in points])
        axes.semilogy(times, costs, color=colour(orbits), marker="o", ms=5, mfc="white", label=f"safe {name}")
    axes.plot(plan.approach.duration_s, plan.cost, **STAR, label="the plan")
    labelled(plan, axes, "duration of the approach (s)", "cost (m/s)")
    legend(figure, axes, 2)
    return write_png(
        figure, folder, "front.png",
        "What safety under interrupted burns costs, by how long the approach may take; each point on a coarse grid of"
        " times, so that a plan may lie a little below. Where a curve begins later, no approach is so safe before.",
    )  # fmt: skip


def flights(plan: ApproachPlan, folder: Path) -> FigureFile:
    figure, (axes,) = panels((7.6, 4.0))
    names = {"as_planned": "as planned", "re_planned": "re-planned before every burn"}
    for k, (key, flights) in enumerate(plan.flights.items()):
        share = 100.0 * np.arange(1, flights.runs + 1) / flights.runs
        label = f"{names[key]}: {flights.unsafe} of {flights.runs} unsafe, capture missed by {flights.miss_m.mean():.1f} m"
        axes.step(np.sort(flights.nearest_m), share, where="post", color=colour(k), label=label)
    keep_out = plan.scenario.keep_out_m
    axes.axvspan(0.0, keep_out, color=KEEP_OUT, alpha=0.6, lw=0, zorder=0)
    axes.axvline(keep_out, color=UNSAFE, lw=1.0)
    nearest = min(float(each.nearest_m.min()) for each in plan.flights.values())
    axes.set_xlim(left=min(0.8 * keep_out, 0.95 * nearest))
    axes.set_ylim(0.0, 100.0)
    labelled(plan, axes, "nearest of any drift within one orbit (m)", "flights (%)")
    legend(figure, axes)
    return write_png(
        figure, folder, "monte_carlo.png",
        "Flights with navigation and execution errors: the share that comes nearer to the target than a distance, by the"
        " drift after any burn if no other follows. Shaded: the keep-out.",
    )  # fmt: skip
