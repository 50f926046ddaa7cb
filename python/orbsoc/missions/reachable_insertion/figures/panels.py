"""The figures of a plan: the orbits, what happens over time, and, after figures 5–7 of Li et al. 2025, diagnostic panels.

A diagnostic panel overlays the collocation nodes on the independently propagated curve, and shows their difference
below, because the two curves are one to the eye. Matplotlib is imported when a figure is drawn, with the Agg
canvas and without pyplot: no global state, no display.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from orbsoc.guidance.figure_style import BLUE, GREEN, STYLE, VERMILION, labels_in_line, write_png
from orbsoc.guidance.mission import FigureFile
from orbsoc.orbit import pitch_yaw
from orbsoc.orbit.array import Array

from ..scenario import Scenario
from ..search.run import SearchResult
from ..verification import Arcs, Verification
from .history import history_figure
from .orbit import orbit_figure
from .space import draw_in_space

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLOURS = (BLUE, VERMILION, GREEN)
ORBIT = (
    "The orbits before{between} and after, seen from the first orbit's angular momentum, with the {burns}, the thrust direction"
    " at equal times{where}."
)
HISTORY = (
    "What {what}, as flown by the independent integrator: altitude, osculating perigee and apogee, mass, and the Δv of the"
    " engine{share}."
)


def draw_programme(
    scenario: Scenario, titles: tuple[str, str], arcs: Arcs, folder: Path
) -> tuple[FigureFile, ...]:
    """Write the orbits and the history of coasts and burns; of a burn of 0 s the orbit alone."""
    one = len(arcs.burns) == 1
    start = scenario.launch_inertial(scenario.initial)
    words = ("", "burn", "; enlarged, inside the Earth or in a corner") if one else (", between", "burns", "")
    caption = ORBIT.format(between=words[0], burns=words[1], where=words[2])
    found = draw_in_space(scenario, titles[0], start, arcs, folder)
    found.append(write_png(orbit_figure(titles[0], start, arcs), folder, "orbit.png", caption))
    if arcs.burns[-1].times_s[-1] > 0.0:
        share = " as change of speed, gravity's share and what is spent on turning the velocity"
        caption = HISTORY.format(
            what="the burn does" if one else "happens over time", share=share if one else "; burns are shaded"
        )
        figure = history_figure(titles[1], scenario.vehicle.thruster(), arcs)
        found.append(write_png(figure, folder, "history.png", caption))
    return tuple(found)


def draw_figures(plan: SearchResult, arcs: Arcs | None, folder: Path) -> tuple[FigureFile, ...]:
    """Write the figures of a plan with one burn that was flown into `folder`; empty when there is nothing to show."""
    found, scenario = plan.verification, plan.scenario
    if found is None or arcs is None:
        return ()
    import matplotlib as mpl

    spent = scenario.vehicle.thruster()
    exhaust_m_s = spent.thrust_n / spent.mass_flow_kg_s
    delta_v_m_s = -exhaust_m_s * np.log1p(-plan.propellant_kg / spent.mass_kg)
    titles = (
        f"{scenario.name}: the orbit before and after",
        f"{scenario.name}: {delta_v_m_s:.1f} m/s, {plan.propellant_kg:.1f} kg of propellant",
    )
    with mpl.rc_context(STYLE):
        told = draw_programme(scenario, titles, arcs, folder)
        if plan.time_of_flight_s == 0.0:
            return told
        velocity = _components(plan, found, folder, "velocity", ("vx", "vy", "vz"), slice(3, 6), "/s")
        position = _components(plan, found, folder, "position", ("x", "y", "z"), slice(0, 3), "")
        return (*told, velocity, position, _attitude(plan, found, folder))


def _components(
    plan: SearchResult,
    found: Verification,
    folder: Path,
    what: str,
    names: Sequence[str],
    part: slice,
    per: str,
) -> FigureFile:
    """Three stacked panels, one per component, and the difference of planned and propagated below."""
    figure, axes = _panels((1.0, 1.0, 1.0, 0.8), 7.4)
    flight, nodes = found.flight, plan.setup.units.state_to_si(plan.trajectory.states)[:, part] / 1e3
    curve, error = flight.propagated[:, part] / 1e3, (flight.planned - flight.propagated)[:, part]
    for k, (name, colour) in enumerate(zip(names, COLOURS, strict=True)):
        axes[k].plot(flight.times_s, curve[:, k], color=colour, label="propagated (DOP853)")
        _dots(axes[k], plan, nodes[:, k], colour)
        axes[k].set_ylabel(f"{name} (km{per})")
        axes[3].plot(flight.times_s, error[:, k], color=colour, linewidth=1.2, label=name)
    axes[3].set_ylabel(f"planned −\npropagated (m{per})")
    _finish(figure, axes, plan, legends=(0, 3))
    caption = (
        f"{what.capitalize()} over the burn{_paper(plan, '5a' if per else '5b')}: collocation nodes on the independently"
        f" propagated curves, {'' if per else 'Earth-centred '}{_axes_of(plan)}, and their difference."
    )
    return write_png(figure, folder, f"{what}.png", caption, appendix=True)


def _attitude(plan: SearchResult, found: Verification, folder: Path) -> FigureFile:
    figure, axes = _panels((1.0, 1.0, 0.7), 6.2)
    flight, limit = found.flight, plan.scenario.verification.thrust_excess
    flown, nodal = pitch_yaw(flight.direction), pitch_yaw(plan.trajectory.controls)
    for k, (name, colour) in enumerate(zip(("pitch", "yaw"), COLOURS, strict=False)):
        axes[k].plot(flight.times_s, np.rad2deg(flown[k]), color=colour, label="commanded and flown")
        _dots(axes[k], plan, np.rad2deg(nodal[k]), colour)
        axes[k].set_ylabel(f"{name} (°)")
        axes[k].margins(y=0.12)
    axes[2].plot(flight.times_s, flight.raw_norm - 1.0, color="#444444", linewidth=1.2)
    if found.thrust_excess > 0.1 * limit:
        axes[2].axhline(limit, color=VERMILION, linewidth=1.0, linestyle="--", label="limit")
    axes[2].set_ylabel("‖u‖ − 1\nbefore normalising")
    _finish(figure, axes, plan, legends=(0, 2) if found.thrust_excess > 0.1 * limit else (0,))
    number = "6" if plan.scenario.problem == "min_time" else "7"
    caption = (
        f"Thrust attitude over the burn{_paper(plan, number)}: pitch = atan2(u_y, u_x) and yaw = −asin(u_z) in"
        f" {_axes_of(plan)}, at the nodes and as commanded between them; below, how far the interpolated thrust is from unit"
        " length before it is normalised."
    )
    return write_png(figure, folder, "attitude.png", caption, appendix=True)


def _paper(plan: SearchResult, figure: str) -> str:
    """The figure of the paper that this one is after, for the paper's own scenarios."""
    return f" (the paper's figure {figure})" if plan.scenario.compare_with else ""


def _axes_of(plan: SearchResult) -> str:
    launch = "launch-inertial axes (x downrange, y up, z right)"
    return "ECI axes" if plan.scenario.plan_axes == "eci" else launch


def _panels(heights: Sequence[float], height: float) -> tuple[Figure, list[Axes]]:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7.2, height))
    place = {"left": 0.15, "right": 0.97, "bottom": 0.08, "top": 0.93, "hspace": 0.3}
    grid = {
        "height_ratios": heights,
        **place,
    }  # fixed: a layout that is worked out takes as long as the drawing
    return figure, list(figure.subplots(len(heights), 1, sharex=True, gridspec_kw=grid))


def _dots(axes: Axes, plan: SearchResult, values: Array, colour: str) -> None:
    times = plan.trajectory.elapsed() * plan.setup.units.time_s
    shape: Any = {
        "markersize": 5.5,
        "markerfacecolor": "white",
        "markeredgecolor": colour,
        "markeredgewidth": 1.4,
    }
    axes.plot(times, values, "o", **shape, label="collocation nodes", clip_on=False, zorder=3)


def _finish(figure: Figure, axes: Sequence[Axes], plan: SearchResult, legends: Sequence[int]) -> None:
    from matplotlib.ticker import MaxNLocator

    for panel in axes:
        panel.yaxis.set_major_locator(MaxNLocator(nbins=5, min_n_ticks=3))
    axes[-1].ticklabel_format(axis="y", style="sci", scilimits=(-2, 3))
    for k in legends:  # a line over the panel's right end, where it hides no curve
        axes[k].legend(
            loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=3, borderaxespad=0.1, handlelength=1.5
        )
    axes[-1].set_xlabel("time since ignition (s)")
    axes[-1].set_xlim(0.0, plan.time_of_flight_s)
    labels_in_line(axes)
    scenario, what = (
        plan.scenario,
        "shortest burn" if plan.scenario.problem == "min_time" else "largest orbit",
    )
    if scenario.problem == "max_energy" and scenario.target.perigee_direction == "free":
        what += ", perigee direction free"
    title = f"{scenario.name}: {what}, {plan.trajectory.grid.size} nodes"
    figure.suptitle(title, x=0.01, ha="left", fontweight="bold")
