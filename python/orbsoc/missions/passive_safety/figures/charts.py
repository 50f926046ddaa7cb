"""Curves of a plan: margins over time, cut burns, the primer, the scan of times, the front, flights with errors."""

from __future__ import annotations

from math import inf
from pathlib import Path

import numpy as np

from orbsoc.guidance.figure_style import write_png
from orbsoc.guidance.mission import FigureFile

from ..planner import ApproachPlan
from .canvas import COLOURS, KEEP_OUT, SHOWN, UNSAFE, colour, panels, title


def margins(plan: ApproachPlan, folder: Path) -> FigureFile:
    found, programme = plan.verification, plan.programme
    assert found is not None
    assert programme is not None
    figure, (top, bottom) = panels((7.6, 5.6), (1.0, 1.5))
    end = plan.approach.duration_s
    steps = np.concatenate([[0.0], np.repeat(programme.times_s, 2), [end]])
    totals = np.concatenate([[0.0, 0.0], np.repeat(np.cumsum(programme.sizes_m_s), 2)])
    top.plot(steps, totals[: steps.size], color=COLOURS[0])
    for t, total, size in zip(
        programme.times_s, np.cumsum(programme.sizes_m_s), programme.sizes_m_s, strict=True
    ):
        if len(programme) <= SHOWN:
            top.annotate(f"+{size:.4f}", (t, total), xytext=(4, -12), textcoords="offset points", fontsize=9)
    top.set_ylabel("Δv spent (m/s)")
    top.set_title(title(plan), loc="left", fontsize=11, fontweight="bold")
    away = np.linalg.norm(found.track, axis=1)
    bottom.semilogy(found.times_s, away, color="#222222", label="distance from the target")
    for truth in found.truths:
        if truth.name == "j2":
            times, flown = np.linspace(0.0, end, len(truth.track)), np.linalg.norm(truth.track, axis=1)
            bottom.semilogy(times, flown, color=COLOURS[1], ls=(0, (4, 3)), label="the same with J$_2$")
    if plan.approach.guarded and len(programme) <= SHOWN:
        for k, cut in enumerate(found.cuts):
            until = found.cuts[k + 1].time_s if k + 1 < len(found.cuts) else end
            bottom.hlines(cut.completed_m, cut.time_s, until, color=colour(k), lw=2.2)
            shade = UNSAFE if cut.distance_m < plan.scenario.keep_out_m - 0.01 else colour(k)
            bottom.vlines(cut.time_s, max(cut.distance_m, 1.0), cut.completed_m, color=shade, lw=1.4, ls=":")
        bottom.plot([], [], color=colour(0), lw=2.2, label="nearest of the drift, if no later burn comes")
        bottom.plot([], [], color=UNSAFE, lw=1.2, ls=":", label="… if the burn stops inside")
    if plan.approach.guarded:
        bottom.axhline(plan.scenario.keep_out_m, color=UNSAFE, lw=1.0, label="keep-out")
    bottom.set_ylabel("metres")
    bottom.set_xlabel("time since the first impulse (s)")
    bottom.set_xlim(0.0, end)
    bottom.set_ylim(bottom=1.0)
    figure.legend(*bottom.get_legend_handles_labels(), loc="outside lower center", ncols=2, fontsize=9)
    return write_png(
        figure, folder, "margins.png",
        "Velocity change spent, and how near the chaser comes: on its way, and for all later time by the drift that it is"
        " on. Dotted: down to the worst place at which a burn can stop.",
    )  # fmt: skip


def cut_burns(plan: ApproachPlan, folder: Path) -> FigureFile:
    assert plan.verification is not None
    figure, (axes,) = panels((7.6, 4.2), (1.0,))
    keep_out = plan.scenario.keep_out_m
    for k, cut in enumerate(plan.verification.cuts[:SHOWN]):
        fractions = np.linspace(0.0, 100.0, cut.by_fraction_m.size)
        axes.semilogy(
            fractions, np.maximum(cut.by_fraction_m, 0.01), color=colour(k), label=f"burn {cut.number}"
        )
    lowest = axes.get_ylim()[0]
    axes.axhspan(lowest, keep_out, color=KEEP_OUT, alpha=0.6, lw=0, zorder=0)
    axes.set_ylim(bottom=lowest)
    axes.axhline(keep_out, color=UNSAFE, lw=1.0)
    axes.annotate(
        "keep-out",
        (100, keep_out),
        xytext=(-4, -3),
        textcoords="offset points",
        va="top",
        ha="right",
        color=UNSAFE,
    )
    axes.set_xlim(0, 100)
    axes.set_xlabel("how much of the burn is flown before the engine stops (%)")
    axes.set_ylabel(
        "nearest for all later time (m)" if plan.approach.circular else "nearest in one orbit (m)"
    )
    axes.set_title(title(plan), loc="left", fontsize=11, fontweight="bold")
    figure.legend(loc="outside lower center", ncols=6, fontsize=9)
    return write_png(
        figure, folder, "cut_burns.png",
        "Where a burn may stop: the least distance from the target over all later time, by the fraction that is flown.",
    )  # fmt: skip


def primer(plan: ApproachPlan, folder: Path) -> FigureFile:
    assert plan.timed is not None
    assert plan.timed.best is not None
    assert plan.programme is not None
    impulses, solution = plan.timed.best.impulses, plan.timed.best.solution
    figure, (axes,) = panels((7.6, 3.6), (1.0,))
    times = np.linspace(0.0, plan.approach.duration_s, 361)
    axes.plot(times, impulses.primer_size(solution, times), color=COLOURS[0])
    at = plan.programme.times_s
    axes.plot(
        at, impulses.primer_size(solution, at), ls="none", marker="o", mfc="white", mec="#222222", mew=1.5
    )
    axes.axhline(1.0, color="#999999", lw=0.9, ls=(0, (6, 4)))
    axes.set_xlim(0.0, plan.approach.duration_s)
    axes.set_ylim(bottom=0.0)
    axes.set_xlabel("time since the first impulse (s)")
    axes.set_ylabel("primer magnitude")
    axes.set_title(title(plan), loc="left", fontsize=11, fontweight="bold")
    return write_png(
        figure, folder, "primer.png",
        "The primer, what an impulse at each time would be worth against its cost, with the burns. Above 1 another time"
        " would save Δv if it added no condition of its own; each burn here adds the safety of its drift.",
    )  # fmt: skip


def scan(plan: ApproachPlan, folder: Path) -> FigureFile:
    assert plan.timed is not None
    assert plan.timed.best is not None
    figure, (axes,) = panels((7.6, 3.6), (1.0,))
    trials = sorted(plan.timed.trials, key=lambda trial: trial.second_s)
    times = np.array([trial.second_s for trial in trials])
    costs = np.array([trial.cost if trial.cost < inf else np.nan for trial in trials])
    axes.plot(times, costs, color=COLOURS[0], marker=".", ms=5, lw=1.2)
    bad = times[~np.isfinite(costs)]
    if bad.size:
        axes.plot(
            bad,
            np.full(bad.size, np.nanmin(costs)),
            ls="none",
            marker="x",
            ms=4,
            color=UNSAFE,
            label="infeasible",
        )
        figure.legend(loc="outside lower center", fontsize=9)
    axes.plot(plan.timed.best.second_s, plan.timed.best.cost, marker="*", ms=13, color="#222222")
    axes.set_xlabel("time of impulse 2 (s)")
    axes.set_ylabel("cost (m/s)")
    axes.set_title(title(plan), loc="left", fontsize=11, fontweight="bold")
    return write_png(
        figure, folder, "timing.png",
        f"Cost by the time of the second impulse, {len(trials)} problems; the star is the plan.",
    )  # fmt: skip


def front(plan: ApproachPlan, folder: Path) -> FigureFile:
    figure, (axes,) = panels((7.6, 4.0), (1.0,))
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
    axes.plot(
        plan.approach.duration_s,
        plan.cost,
        marker="*",
        ms=13,
        color="#222222",
        ls="none",
        label="the plan",
        zorder=5,
    )
    axes.set_xlabel("duration of the approach (s)")
    axes.set_ylabel("cost (m/s)")
    axes.set_title(title(plan), loc="left", fontsize=11, fontweight="bold")
    figure.legend(loc="outside lower center", ncols=2, fontsize=9)
    return write_png(
        figure, folder, "front.png",
        "What safety under interrupted burns costs, by how long the approach may take; each point on a coarse grid of"
        " times, so that a plan may lie a little below. Where a curve begins later, no approach is so safe before.",
    )  # fmt: skip


def flights(plan: ApproachPlan, folder: Path) -> FigureFile:
    figure, (axes,) = panels((7.6, 4.0), (1.0,))
    names = {"as_planned": "as planned", "re_planned": "re-planned before every burn"}
    for k, (key, flights) in enumerate(plan.flights.items()):
        ordered = np.sort(flights.nearest_m)
        share = np.arange(1, flights.runs + 1) / flights.runs
        label = f"{names[key]}: {flights.unsafe} of {flights.runs} unsafe, capture missed by {flights.miss_m.mean():.1f} m"
        axes.step(ordered, 100.0 * share, where="post", color=colour(k), label=label)
    keep_out = plan.scenario.keep_out_m
    axes.axvspan(0.0, keep_out, color=KEEP_OUT, alpha=0.6, lw=0, zorder=0)
    axes.axvline(keep_out, color=UNSAFE, lw=1.0)
    axes.set_xlim(
        left=min(0.8 * keep_out, 0.95 * min(float(each.nearest_m.min()) for each in plan.flights.values()))
    )
    axes.set_ylim(0.0, 100.0)
    axes.set_xlabel("nearest of any drift within one orbit (m)")
    axes.set_ylabel("flights (%)")
    axes.set_title(title(plan), loc="left", fontsize=11, fontweight="bold")
    figure.legend(loc="outside lower center", ncols=1, fontsize=9)
    return write_png(
        figure, folder, "monte_carlo.png",
        "Flights with navigation and execution errors: the share that comes nearer to the target than a distance, by the"
        " drift after any burn if no other follows. Shaded: the keep-out.",
    )  # fmt: skip
