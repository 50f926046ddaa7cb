"""Figures of a plan: the V-bar/R-bar plane with every drift, cut burns, margins over time, the primer, the scan.

Axes as rendezvous engineers draw them: V-bar to the right, R-bar (nadir) down. Matplotlib is imported when a figure is
drawn, with the Agg canvas and without pyplot: no global state, no display.
"""

from __future__ import annotations

from math import inf, isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from orbsoc.guidance.mission import FigureFile
from orbsoc.guidance.safety import CutBurn

from .approach_plan import ApproachPlan

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

COLOURS = ("#0072B2", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", "#000000")
"""Okabe–Ito without vermilion, which is for what is unsafe."""
UNSAFE = "#D55E00"
KEEP_OUT = "#f3c9b5"
STYLE: Any = {
    "font.size": 10.5,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#dddddd",
    "grid.linewidth": 0.6,
    "axes.axisbelow": True,
    "lines.linewidth": 1.8,
    "legend.frameon": False,
}
DOTS_PER_INCH = 150
SHOWN = 6
"""Impulses that are drawn with a drift of their own; of more, the first ones."""


def draw_figures(plan: ApproachPlan, folder: Path) -> tuple[FigureFile, ...]:
    """Write the figures of a plan that was flown into `folder`; empty when there is nothing to show."""
    if plan.verification is None or plan.programme is None:
        return ()
    import matplotlib as mpl

    with mpl.rc_context(STYLE):
        found = [_plane(plan, folder), _margins(plan, folder)]
        if plan.approach.guarded:
            found.append(_cut_burns(plan, folder))
        if plan.timed is not None and plan.timed.best is not None:
            found.append(_primer(plan, folder))
            if plan.timed.scanned:
                found.append(_scan(plan, folder))
        if plan.front:
            found.append(_front(plan, folder))
        if plan.flights:
            found.append(_flights(plan, folder))
    return tuple(found)


def _colour(k: int) -> str:
    return COLOURS[k % len(COLOURS)]


def _plane(plan: ApproachPlan, folder: Path) -> FigureFile:
    """Above all of it, below the surroundings of the target."""
    figure, (whole, near) = _panels((7.6, 8.0), (0.62, 1.25), share=False)
    for axes in (whole, near):
        _draw_plane(plan, axes)
    cut = _worst_cut(plan)
    track = plan.verification.track if plan.verification else np.zeros((1, 3))
    lows, highs = _box([track, *_free(plan)[:SHOWN]])
    whole.set_xlim(lows[1] - 0.04 * (highs[1] - lows[1]), highs[1] + 0.04 * (highs[1] - lows[1]))
    depth = max(highs[0] - lows[0], 0.12 * (highs[1] - lows[1]))
    whole.set_ylim(-(lows[0] - 0.1 * depth), -(highs[0] + 0.1 * depth))
    whole.set_aspect("equal")
    reach = 4.0 * max(plan.scenario.keep_out_m, 0.3 * float(np.linalg.norm(plan.approach.capture)), 1.0)
    near.set_xlim(-1.6 * reach, 1.6 * reach)
    near.set_ylim(reach, -reach)
    near.set_aspect("equal")
    whole.set_title(_title(plan), loc="left", fontsize=11, fontweight="bold")
    handles, labels = near.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=3, fontsize=9)
    words = (
        ""
        if cut is None
        else f" Dashed red: the drift after burn {cut.number} when it stops at {cut.fraction:.0%}."
    )
    return _save(
        figure, folder, "approach.png",
        "The approach in the orbital plane, V-bar to the right, nadir down; below, the surroundings of the target with the"
        " keep-out disc. Thick: as flown (DOP853). Thin: one orbit of free drift after each burn, if no other follows."
        + words,
    )  # fmt: skip


def _draw_plane(plan: ApproachPlan, axes: Axes) -> None:
    from matplotlib.patches import Circle

    approach, found, programme = plan.approach, plan.verification, plan.programme
    assert found is not None
    assert programme is not None
    if approach.guarded:
        axes.add_patch(Circle((0, 0), approach.keep_out_m, color=KEEP_OUT, lw=0, label="keep-out", zorder=1))
        level = -approach.side * approach.keep_out_m
        axes.axhline(level, color="#999999", lw=0.9, ls=(0, (6, 4)), label="half-plane of the later drifts")
    for k, drift in enumerate(_free(plan)[:SHOWN]):
        axes.plot(
            drift[:, 1], -drift[:, 0], color=_colour(k), lw=0.9, alpha=0.9, label=f"drift after burn {k + 1}"
        )
    cut = _worst_cut(plan)
    if cut is not None:
        track = _cut_track(plan, cut)
        label = f"burn {cut.number} cut at {cut.fraction:.0%}"
        axes.plot(track[:, 1], -track[:, 0], color=UNSAFE, lw=1.0, ls=(0, (4, 2)), label=label)
    axes.plot(found.track[:, 1], -found.track[:, 0], color="#222222", lw=2.4, label="approach", zorder=4)
    at = np.searchsorted(found.times_s, programme.times_s)
    axes.plot(
        found.track[at, 1], -found.track[at, 0], ls="none", marker="o", ms=6, mfc="white", mec="#222222", mew=1.5,
        label="burn", zorder=5,
    )  # fmt: skip
    axes.plot(
        approach.capture[1],
        -approach.capture[0],
        marker="*",
        ms=13,
        color="#222222",
        ls="none",
        label="capture",
        zorder=6,
    )
    axes.plot(0, 0, marker="s", ms=5, color="#222222", ls="none", label="target", zorder=6)
    axes.set_xlabel("V-bar, x (m)")
    axes.set_ylabel("R-bar, z to nadir (m)")


def _margins(plan: ApproachPlan, folder: Path) -> FigureFile:
    found, programme = plan.verification, plan.programme
    assert found is not None
    assert programme is not None
    figure, (top, bottom) = _panels((7.6, 5.6), (1.0, 1.5))
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
    top.set_title(_title(plan), loc="left", fontsize=11, fontweight="bold")
    away = np.linalg.norm(found.track, axis=1)
    bottom.semilogy(found.times_s, away, color="#222222", label="distance from the target")
    times = (
        found.times_s[0] + np.linspace(0.0, end, len(found.truths[0].track)) if found.truths else np.zeros(0)
    )
    for truth, colour in zip(found.truths[1:2], COLOURS[1:], strict=False):
        flown = np.linalg.norm(truth.track, axis=1)
        bottom.semilogy(times, flown, color=colour, ls=(0, (4, 3)), label="the same with J$_2$")
    if plan.approach.guarded and len(programme) <= SHOWN:
        for k, cut in enumerate(found.cuts):
            until = found.cuts[k + 1].time_s if k + 1 < len(found.cuts) else end
            bottom.hlines(cut.completed_m, cut.time_s, until, color=_colour(k), lw=2.2)
            colour = UNSAFE if cut.distance_m < plan.scenario.keep_out_m - 0.01 else _colour(k)
            bottom.vlines(cut.time_s, max(cut.distance_m, 1.0), cut.completed_m, color=colour, lw=1.4, ls=":")
        bottom.plot([], [], color=_colour(0), lw=2.2, label="nearest of the drift, if no later burn comes")
        bottom.plot([], [], color=UNSAFE, lw=1.2, ls=":", label="… if the burn stops inside")
    if plan.approach.guarded:
        bottom.axhline(plan.scenario.keep_out_m, color=UNSAFE, lw=1.0, label="keep-out")
    bottom.set_ylabel("metres")
    bottom.set_xlabel("time since the first impulse (s)")
    bottom.set_xlim(0.0, end)
    bottom.set_ylim(bottom=1.0)
    figure.legend(*bottom.get_legend_handles_labels(), loc="outside lower center", ncols=2, fontsize=9)
    return _save(
        figure, folder, "margins.png",
        "Velocity change spent, and how near the chaser comes: on its way, and for all later time by the drift that it is"
        " on. Dotted: down to the worst place at which a burn can stop.",
    )  # fmt: skip


def _cut_burns(plan: ApproachPlan, folder: Path) -> FigureFile:
    assert plan.verification is not None
    figure, (axes,) = _panels((7.6, 4.2), (1.0,))
    keep_out = plan.scenario.keep_out_m
    for k, cut in enumerate(plan.verification.cuts[:SHOWN]):
        fractions = np.linspace(0.0, 100.0, cut.by_fraction_m.size)
        axes.semilogy(
            fractions, np.maximum(cut.by_fraction_m, 0.01), color=_colour(k), label=f"burn {cut.number}"
        )
    axes.axhspan(axes.get_ylim()[0], keep_out, color=KEEP_OUT, alpha=0.6, lw=0, zorder=0)
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
    axes.set_title(_title(plan), loc="left", fontsize=11, fontweight="bold")
    figure.legend(loc="outside lower center", ncols=6, fontsize=9)
    return _save(
        figure, folder, "cut_burns.png",
        "Where a burn may stop: the least distance from the target over all later time, by the fraction that is flown.",
    )  # fmt: skip


def _primer(plan: ApproachPlan, folder: Path) -> FigureFile:
    assert plan.timed is not None
    assert plan.timed.best is not None
    assert plan.programme is not None
    impulses, solution = plan.timed.best.impulses, plan.timed.best.solution
    figure, (axes,) = _panels((7.6, 3.6), (1.0,))
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
    axes.set_title(_title(plan), loc="left", fontsize=11, fontweight="bold")
    return _save(
        figure, folder, "primer.png",
        "The primer, what an impulse at each time would be worth against its cost, with the burns. Above 1 another time"
        " would save Δv if it added no condition of its own; each burn here adds the safety of its drift.",
    )  # fmt: skip


def _scan(plan: ApproachPlan, folder: Path) -> FigureFile:
    assert plan.timed is not None
    assert plan.timed.best is not None
    figure, (axes,) = _panels((7.6, 3.6), (1.0,))
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
    axes.set_title(_title(plan), loc="left", fontsize=11, fontweight="bold")
    return _save(
        figure, folder, "timing.png",
        f"Cost by the time of the second impulse, {len(trials)} problems; the star is the plan.",
    )  # fmt: skip


def _front(plan: ApproachPlan, folder: Path) -> FigureFile:
    figure, (axes,) = _panels((7.6, 4.0), (1.0,))
    names = (
        "after completed burns",
        "also for one orbit after a cut burn",
        "also for two orbits after a cut burn",
    )
    for orbits, name in enumerate(names):
        points = [point for point in plan.front if point.orbits == orbits]
        times = np.array([point.duration_s for point in points])
        costs = np.array([point.cost if point.cost < inf else np.nan for point in points])
        axes.semilogy(
            times, costs, color=_colour(orbits), marker="o", ms=5, mfc="white", label=f"safe {name}"
        )
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
    axes.set_title(_title(plan), loc="left", fontsize=11, fontweight="bold")
    figure.legend(loc="outside lower center", ncols=2, fontsize=9)
    return _save(
        figure, folder, "front.png",
        "What safety under interrupted burns costs, by how long the approach may take; each point on a coarse grid of"
        " times, so that a plan may lie a little below. Where a curve begins later, no approach is so safe before.",
    )  # fmt: skip


def _flights(plan: ApproachPlan, folder: Path) -> FigureFile:
    figure, (axes,) = _panels((7.6, 4.0), (1.0,))
    names = {"as_planned": "as planned", "re_planned": "re-planned before every burn"}
    for k, (key, flights) in enumerate(plan.flights.items()):
        ordered = np.sort(flights.nearest_m)
        share = np.arange(1, flights.runs + 1) / flights.runs
        label = f"{names[key]}: {flights.unsafe} of {flights.runs} unsafe, capture missed by {flights.miss_m.mean():.1f} m"
        axes.step(ordered, 100.0 * share, where="post", color=_colour(k), label=label)
    keep_out = plan.scenario.keep_out_m
    axes.axvspan(0.0, keep_out, color=KEEP_OUT, alpha=0.6, lw=0, zorder=0)
    axes.axvline(keep_out, color=UNSAFE, lw=1.0)
    axes.set_xlim(
        left=min(0.8 * keep_out, 0.95 * min(float(each.nearest_m.min()) for each in plan.flights.values()))
    )
    axes.set_ylim(0.0, 100.0)
    axes.set_xlabel("nearest of any drift within one orbit (m)")
    axes.set_ylabel("flights (%)")
    axes.set_title(_title(plan), loc="left", fontsize=11, fontweight="bold")
    figure.legend(loc="outside lower center", ncols=1, fontsize=9)
    return _save(
        figure, folder, "monte_carlo.png",
        "Flights with navigation and execution errors: the share that comes nearer to the target than a distance, by the"
        " drift after any burn if no other follows. Shaded: the keep-out.",
    )  # fmt: skip


def _free(plan: ApproachPlan) -> list[Array]:
    return [] if plan.verification is None else list(plan.verification.drifts)


def _worst_cut(plan: ApproachPlan) -> CutBurn | None:
    """The burn whose interruption comes nearest, if that is inside the keep-out."""
    cuts = plan.verification.cuts if plan.verification and plan.approach.guarded else ()
    worst = min(cuts, key=lambda cut: cut.distance_m, default=None)
    return worst if worst is not None and worst.distance_m < plan.scenario.keep_out_m - 0.01 else None


def _cut_track(plan: ApproachPlan, cut: CutBurn) -> Array:
    """Positions of the drift after a cut burn up to its nearest point, at most three orbits before and half one after."""
    assert plan.verification is not None
    assert plan.programme is not None
    state = plan.verification.after[cut.number - 1].copy()
    state[3:] -= (1.0 - cut.fraction) * plan.programme.dv_m_s[cut.number - 1]
    period = plan.approach.period_s
    nearest = cut.after_s if isfinite(cut.after_s) else 0.0
    lapse = np.linspace(max(0.0, nearest - 3.0 * period), nearest + 0.25 * period, 900)
    motion = plan.approach.motion
    return np.array([motion.transition(cut.time_s + float(t), cut.time_s)[:3] @ state for t in lapse])


def _box(tracks: list[Array]) -> tuple[Array, Array]:
    both = np.concatenate([*tracks, np.zeros((1, 3))])
    return both.min(axis=0), both.max(axis=0)


def _title(plan: ApproachPlan) -> str:
    assert plan.programme is not None
    return f"{plan.scenario.name}: {plan.programme.total_m_s:.4f} m/s in {len(plan.programme)} impulses"


def _panels(
    size: tuple[float, float], heights: tuple[float, ...], *, share: bool = True
) -> tuple[Figure, list[Axes]]:
    from matplotlib.figure import Figure

    figure = Figure(figsize=size, layout="constrained")
    found = figure.subplots(
        len(heights), 1, sharex=share, squeeze=False, gridspec_kw={"height_ratios": heights}
    )
    return figure, list(found[:, 0])


def _save(figure: Figure, folder: Path, name: str, caption: str) -> FigureFile:
    figure.savefig(folder / name, dpi=DOTS_PER_INCH, metadata={"Software": "orbsoc"})
    return FigureFile(name, caption)
