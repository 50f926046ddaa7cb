"""The V-bar/R-bar plane with the keep-out and every drift, as rendezvous engineers draw it: V-bar to the right, nadir down."""

from __future__ import annotations

from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from orbsoc.guidance.figure_style import BURN, panels, write_png
from orbsoc.guidance.mission import FigureFile
from orbsoc.guidance.safety import CutBurn
from orbsoc.orbit.array import Array

from ..planner import ApproachPlan
from ..verification import LIMIT_M
from .charts import KEEP_OUT, SHOWN, STAR, UNSAFE, colour, labelled, legend

if TYPE_CHECKING:
    from matplotlib.axes import Axes

AXES = "V-bar, x (m)", "R-bar, z to nadir (m)"


def plane(plan: ApproachPlan, folder: Path) -> FigureFile:
    """Above all of it, below the surroundings of the target."""
    figure, (whole, near) = panels((7.6, 8.0), (0.62, 1.25), share=False)
    for axes in (whole, near):
        _draw_plane(plan, axes)
    cut = worst_cut(plan)
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
    labelled(plan, whole, *AXES)
    labelled(plan, near, *AXES, title=False)
    legend(figure, near, 3)
    words = (
        ""
        if cut is None
        else f" Dashed red: the drift after burn {cut.number} when it stops at {cut.fraction:.0%}."
    )
    return write_png(
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
            drift[:, 1], -drift[:, 0], color=colour(k), lw=0.9, alpha=0.9, label=f"drift after burn {k + 1}"
        )
    cut = worst_cut(plan)
    if cut is not None:
        track = _cut_track(plan, cut)
        label = f"burn {cut.number} cut at {cut.fraction:.0%}"
        axes.plot(track[:, 1], -track[:, 0], color=UNSAFE, lw=1.0, ls=(0, (4, 2)), label=label)
    axes.plot(found.track[:, 1], -found.track[:, 0], color="#222222", lw=2.4, label="approach", zorder=4)
    at = np.searchsorted(found.times_s, programme.times_s)
    axes.plot(found.track[at, 1], -found.track[at, 0], **BURN, ms=6, label="burn", zorder=5)
    axes.plot(approach.capture[1], -approach.capture[0], **STAR, label="capture")
    axes.plot(0, 0, marker="s", ms=5, color="#222222", ls="none", label="target", zorder=6)


def worst_cut(plan: ApproachPlan) -> CutBurn | None:
    """The burn whose interruption comes nearest, if that is inside the keep-out."""
    cuts = plan.verification.cuts if plan.verification and plan.approach.guarded else ()
    worst = min(cuts, key=lambda cut: cut.distance_m, default=None)
    return worst if worst is not None and worst.distance_m < plan.scenario.keep_out_m - LIMIT_M else None


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


def _free(plan: ApproachPlan) -> list[Array]:
    return [] if plan.verification is None else list(plan.verification.drifts)


def _box(tracks: list[Array]) -> tuple[Array, Array]:
    both = np.concatenate([*tracks, np.zeros((1, 3))])
    return both.min(axis=0), both.max(axis=0)
