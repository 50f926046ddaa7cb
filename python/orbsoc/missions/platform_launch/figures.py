"""Figures of a plan: the rendezvous, the launch, the cost over time, what else could be, and the tube's reaction.

Matplotlib is imported when a figure is drawn, with the Agg canvas and without pyplot: no global state, no display.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from orbsoc.guidance.figure_style import BLUE, GREEN, GREY, ORANGE, STYLE, VERMILION, panels, write_png
from orbsoc.guidance.mission import FigureFile
from orbsoc.orbit.array import Array

from .model import two_body
from .model.transfer import Transfers, costs, in_plane
from .planner import LaunchPlan
from .search.rendezvous import Rendezvous
from .verification.audits import ORBITS, Dispersed
from .verification.checks import Verification

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COST = {"squares": "Σ‖Δv‖² (m²/s²)", "norms": "Σ‖Δv‖ (m/s)"}
APPENDIX = ("tube.png", "primer.png")
"""What tells how well the plan was computed."""
DRAWN_ORBITS = 0.02
"""Of an orbit, from which on the cost is drawn."""


def draw_figures(plan: LaunchPlan, folder: Path) -> tuple[FigureFile, ...]:
    """Write the figures of a plan that has impulses into `folder`; empty when there is nothing to show."""
    met, found = plan.meeting, plan.verification
    if met is None or found is None:
        return ()
    import matplotlib as mpl

    drawn: list[tuple[str, str, Callable[[], Figure]]] = [
        ("rendezvous.png", "The flight after the separation (the paper's figures 9 and 10): arrows are the impulses, to scale"
         " among themselves.", lambda: _rendezvous(plan, met, found)),
        ("launch.png", "The launch (the paper's figures 3 to 8): what it does to the platform, and the server in its tube.",
         lambda: _launch(plan)),
        ("cost.png", "The cost of two impulses over the time of flight, with every local minimum.", lambda: _cost(plan, met)),
        ("engine_out.png", f"How near the server comes to the target within {ORBITS:g} orbits when an impulse stops at a fraction"
         " of itself and none follows.", lambda: _engine(plan)),
        ("scans.png", "The least cost of two impulses over the yaw bias of the tube and over the place on the fly-around ellipse.",
         lambda: _scans(plan)),
    ]  # fmt: skip
    if plan.front:
        drawn.append(("front.png", "The least Σ‖Δv‖ over the time of flight, with two impulses and with as many as pay.",
                      lambda: _front(plan)))  # fmt: skip
    flights = plan.dispersed
    if flights is not None:
        drawn.append(("dispersed.png", f"{flights.miss_m.size} flights with errors of push, pointing and impulses: how far from"
                      " the target they end, and what two impulses planned again at the separation cost.",
                      lambda: _dispersed(flights, met)))  # fmt: skip
    drawn.append(("tube.png", "What the tube does to the server, by two bodies with the forces between them: its lateral force, along the"
         " platform's x, and its couple.", lambda: _tube(plan)))  # fmt: skip
    if met.cost == "norms":
        drawn.append(("primer.png", "Length of the primer vector: 1 at an impulse, and above 1 where a further impulse would"
                      " save.", lambda: _primer(met)))  # fmt: skip
    written = []
    with mpl.rc_context(STYLE):
        for name, caption, draw in drawn:
            figure = draw()
            figure.suptitle(plan.scenario.name, x=0.01, ha="left", fontweight="bold")
            written.append(write_png(figure, folder, name, caption, appendix=name in APPENDIX))
    return tuple(written)


def _pair(height: float) -> tuple[Figure, list[Axes]]:
    return panels((7.4, height), columns=2, share=False)


def _panel(along: str, up: str) -> tuple[Figure, Axes]:
    figure, (axes,) = panels((7.4, 3.4))
    axes.set(xlabel=along, ylabel=up)
    return figure, axes


def _legend(axes: Axes) -> None:
    """Above the axes, where no curve is."""
    axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=4, borderaxespad=0.1, handlelength=1.4)


def _launch(plan: LaunchPlan) -> Figure:
    found, scenario = plan.separation, plan.scenario
    times = found.times()
    q = two_body.integrate(found.pair, times).states
    still = np.array([scenario.platform_state(float(t)) for t in times])
    sight = np.array([scenario.sight(float(t)) for t in times])
    base = found.platform
    moved = np.column_stack([base[:2] + base[2:] * times[:, None] + q[:, :2], base[2:] + q[:, 4:6]])
    bias = found.pair.yaw_rad - sight[0, 0]
    rows: list[tuple[str, Array, Array | None]] = [
        ("z − z(0) (m)", moved[:, 1] - base[1], still[:, 1] - base[1]),
        ("yaw (°)", np.degrees(q[:, 2]), np.degrees(sight[:, 0] + bias)),
        ("vx (m/s)", moved[:, 2], still[:, 2]),
        ("yaw rate (°/s)", np.degrees(q[:, 6]), np.degrees(sight[:, 1])),
        ("vz (m/s)", moved[:, 3], still[:, 3]),
        ("slid (m)", q[:, 3], None),
        ("x − x(0) (m)", moved[:, 0] - base[0], still[:, 0] - base[0]),
        ("sliding (m/s)", q[:, 7], None),
    ]
    figure, all_axes = panels((7.4, 7.2), 4 * (1.0,), columns=2, share=False)
    for axes, (label, launched, undisturbed) in zip(all_axes, rows, strict=True):
        axes.plot(times, launched, color=BLUE, label="launch")
        if undisturbed is not None:
            axes.plot(times, undisturbed, color=GREY, linestyle="--", label="no launch")
        axes.set_ylabel(label)
    _legend(all_axes[0])
    for axes in all_axes[-2:]:
        axes.set_xlabel("time (s)")
    figure.align_ylabels()
    return figure


def _tube(plan: LaunchPlan) -> Figure:
    found = plan.separation
    bodies = two_body.integrate(found.pair, found.times())
    figure, (left, right) = _pair(3.2)
    left.plot(bodies.states[:, 3], bodies.lateral_n, color=BLUE)
    left.set_ylabel("lateral force (N)")
    right.plot(bodies.states[:, 3], bodies.couple_n_m, color=VERMILION)
    right.set_ylabel("couple (N m)")
    for axes in (left, right):
        axes.axhline(0.0, color="black", linewidth=0.8)
        axes.set_xlabel("slid in the tube (m)")
    return figure


def _rendezvous(plan: LaunchPlan, met: Rendezvous, found: Verification) -> Figure:
    scenario, flight = plan.scenario, found.as_planned.flight
    figure, (left, right) = panels((8.6, 4.2), columns=2, share=False)
    around = np.linspace(0.0, scenario.motion.period_s, 181)
    ellipse = np.array([scenario.platform_state(float(t))[:2] for t in around])
    left.plot(*ellipse.T, color=GREY, linewidth=1.0, linestyle="--", label="platform's ellipse")
    left.plot(flight.states[:, 1], flight.states[:, 0], color=BLUE, label="server")
    left.plot(0.0, 0.0, "o", markersize=8, markerfacecolor="none", color="black", label="target")
    times, dv = met.programme.times_s, met.programme.dv_m_s
    places = np.array([np.interp(times, flight.times_s, flight.states[:, k]) for k in (1, 0)])
    reach = max(2.0 * scenario.orbit.semi_minor_m, *np.ptp(flight.states[:, :2], axis=0).tolist())
    size = 0.25 * reach / met.programme.largest_m_s
    left.quiver(*places, dv[:, 1] * size, dv[:, 0] * size, color=VERMILION, angles="xy", scale_units="xy", scale=1.0,
                width=0.006, zorder=3)  # fmt: skip
    left.plot([], [], color=VERMILION, label=f"Δv, largest {met.programme.largest_m_s:.3f} m/s")
    left.set_aspect("equal", adjustable="datalim")
    left.set(xlabel="along the motion (m)", ylabel="outward (m)")
    figure.legend(*left.get_legend_handles_labels(), loc="outside lower left", ncols=4, fontsize=9)
    right.plot(flight.times_s, flight.states[:, 1], color=BLUE, label="along the motion")
    right.plot(flight.times_s, flight.states[:, 0], color=GREEN, label="outward")
    for t in times:
        right.axvline(float(t), color=VERMILION, linewidth=0.8, linestyle=":")
    right.set(xlabel="time after the separation (s)", ylabel="position (m)")
    _legend(right)
    return figure


def _cost(plan: LaunchPlan, met: Rendezvous) -> Figure:
    motion, state = plan.scenario.motion, in_plane(plan.separation.state)
    figure, axes = _panel("time of flight (orbits)", COST[met.cost])
    transfers = Transfers.of(motion, max(plan.scenario.longest_s, met.time_s))
    with np.errstate(all="ignore"):
        values = costs(transfers.matrices, state, met.cost)
    points = np.array([[each.time_s / motion.period_s, each.cost] for each in met.minima])
    least = min(met.value, float(points[:, 1].min()))
    orbits = transfers.times_s / motion.period_s
    values[(values > 30.0 * least) | (orbits < DRAWN_ORBITS)] = np.nan
    axes.plot(orbits, values, color=BLUE, linewidth=1.4)
    axes.plot(*points.T, color=VERMILION, linestyle="none", marker="o", markersize=5, label="local minima")
    here = met.time_s / motion.period_s
    axes.plot(here, met.value, color="black", linestyle="none", marker="*", markersize=12, label="plan")
    axes.set_yscale("log")
    ticks = [m * 10.0**k for k in range(-6, 7) for m in (1, 2, 5) if least <= m * 10.0**k <= 30.0 * least]
    axes.set_yticks(ticks, [f"{tick:g}" for tick in ticks])
    axes.minorticks_off()
    _legend(axes)
    return figure


def _engine(plan: LaunchPlan) -> Figure:
    figure, axes = _panel("of the impulse, given (%)", "least distance (m)")
    for cut, colour in zip(plan.cuts, (BLUE, VERMILION, GREEN, ORANGE) * 8, strict=False):
        share = 100.0 * np.linspace(0.0, 1.0, len(cut.by_fraction_m))
        axes.plot(share, cut.by_fraction_m, color=colour, label=f"impulse {cut.number}, {cut.time_s:.0f} s")
    axes.set_ylim(bottom=0.0)
    _legend(axes)
    return figure


def _scans(plan: LaunchPlan) -> Figure:
    figure, pair = _pair(3.4)
    marks = (plan.scenario.yaw_bias_deg, plan.scenario.phase_deg % 360.0)
    for axes, found, mark, label in zip(pair, plan.scans, marks, ("yaw bias (°)", "phase (°)"), strict=True):
        best = f"{found.best_cost:.3f} at {found.best_deg:.1f}°"
        axes.plot(found.samples_deg, found.costs, color=BLUE, marker=".", linewidth=1.2)
        axes.plot(found.best_deg, found.best_cost, color=VERMILION, marker="o", linestyle="none", label=best)
        axes.axvline(mark, color="black", linewidth=0.9, linestyle="--", label="the plan's")
        axes.set_xlabel(label)
        _legend(axes)
    pair[0].set_ylabel(COST[plan.scenario.rendezvous.cost])
    return figure


def _primer(met: Rendezvous) -> Figure:
    figure, axes = _panel("time after the separation (s)", "primer vector")
    times, at = np.linspace(0.0, met.time_s, 481), met.programme.times_s
    axes.plot(times, met.primer(times), color=BLUE)
    axes.plot(at, met.primer(at), color=VERMILION, linestyle="none", marker="o", label="impulses")
    axes.axhline(1.0, color="black", linewidth=0.9, linestyle="--")
    _legend(axes)
    return figure


def _front(plan: LaunchPlan) -> Figure:
    figure, axes = _panel("longest time of flight (orbits)", COST["norms"])
    times, two, many, count = np.array(plan.front).T
    orbits = times / plan.scenario.motion.period_s
    axes.plot(orbits, two, color=GREY, marker="s", label="two impulses")
    axes.plot(orbits, many, color=BLUE, marker="o", label="as many as pay")
    for x, y, k in zip(orbits, many, count, strict=True):
        axes.annotate(f"{k:.0f}", (x, y), xytext=(0, -14), textcoords="offset points", ha="center")
    axes.set_ylim(0.0, 1.1 * float(two.max()))
    _legend(axes)
    return figure


def _dispersed(found: Dispersed, met: Rendezvous) -> Figure:
    figure, (left, right) = _pair(3.2)
    left.hist(found.miss_m, bins=30, color=BLUE)
    for share, style in ((0.5, ":"), (0.95, "--")):
        value = float(np.quantile(found.miss_m, share))
        left.axvline(value, color=VERMILION, linestyle=style, label=f"{100 * share:.0f} %: {value:.1f} m")
    left.set(xlabel="missed by (m)", ylabel="flights")
    right.plot(found.times_s, found.costs, color=BLUE, linestyle="none", marker=".", markersize=3)
    right.plot(
        met.time_s, met.value, color="black", marker="*", markersize=12, linestyle="none", label="plan"
    )
    right.set(xlabel="time of flight of two new impulses (s)", ylabel=COST[met.cost])
    for axes in (left, right):
        _legend(axes)
    return figure
