"""Figures of two burns: the orbits before, between and after with both burn arcs, and what happens over time."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from orbsoc.guidance.figure_style import STYLE, write_png
from orbsoc.guidance.mission import FigureFile
from orbsoc.guidance.orbit_drawing import draw_earth, draw_orbit, plane_of
from orbsoc.orbit import EARTH, elements_from_state, pitch_yaw

from ..figures.history import History
from ..figures.orbit import AFTER, BEFORE, BURN, COAST, FAR
from ..verification import shape_of
from .transfer_plan import TransferPlan
from .verification import Verification

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

BETWEEN = "#CC79A7"
"""Okabe–Ito reddish purple, of the transfer orbit."""
ARROWS = 3
MARGINS = {"left": 0.12, "right": 0.97, "bottom": 0.07, "top": 0.94}


def draw_figures(plan: TransferPlan, folder: Path) -> tuple[FigureFile, ...]:
    """Write the figures of a plan that was flown into `folder`; empty when there is nothing to show."""
    found = plan.verification
    if found is None:
        return ()
    import matplotlib as mpl

    drawn_by = (
        (
            orbit_figure,
            "orbit.png",
            "The orbits before, between and after the burns, seen from the first orbit's angular momentum, with both burn arcs"
            " and the thrust direction at equal times.",
        ),
        (
            history_figure,
            "history.png",
            "What happens over time, as flown by the independent integrator: altitude, osculating perigee and apogee, mass, and"
            " the Δv of the engine; burns are shaded.",
        ),
        (
            attitude_figure,
            "attitude.png",
            "The thrust direction over each burn, as commanded and flown, with the nodes of its grid:"
            " right ascension atan2(u_y, u_x) and elevation asin(u_z) in the axes of the plan.",
        ),
    )
    with mpl.rc_context(STYLE):
        return tuple(write_png(draw(plan, found), folder, name, caption) for draw, name, caption in drawn_by)


def orbit_figure(plan: TransferPlan, found: Verification) -> Figure:
    """The plane of the first orbit as seen from its angular momentum."""
    from matplotlib.figure import Figure

    flight = found.flight
    start = flight.coasts[0].states[0]
    axes = plane_of(start)
    figure = Figure(figsize=(7.2, 7.6))
    panel = figure.add_axes((0.15, 0.255, 0.8, 0.69))
    draw_earth(panel)
    arcs = [each.propagated for each in flight.burns]
    reach = FAR * max(float(np.linalg.norm(arc[:, :3], axis=1).max()) for arc in arcs) / 1e3
    for name, state, colour, style in (
        ("before", start, BEFORE, "-"),
        ("between", arcs[0][-1], BETWEEN, ":"),
        ("after", arcs[1][-1], AFTER, "-"),
    ):
        orbit = elements_from_state(state[:3], state[3:])
        panel.plot(
            *draw_orbit(orbit, axes, reach),
            color=colour,
            linestyle=style,
            linewidth=1.4,
            label=f"{name}: {shape_of(orbit)}",
        )
    for coast, colour in zip(flight.coasts, (COAST, BETWEEN), strict=True):
        if coast.times_s[-1] > 0.0:
            way = coast.states[:, :3] @ axes.T / 1e3
            label = f"coast, {coast.times_s[-1]:.0f} s"
            panel.plot(way[:, 0], way[:, 1], color=colour, linewidth=2.6, alpha=0.75, label=label)
    span = float(np.ptp(panel.get_xlim()))
    for k, burn in enumerate(flight.burns):
        way = burn.propagated[:, :3] @ axes.T / 1e3
        u = burn.direction @ axes.T
        label = f"burn {k + 1}, {burn.times_s[-1]:.1f} s, up to {_out_of_plane_deg(u):.1f}° out of the first orbit's plane"
        panel.plot(way[:, 0], way[:, 1], color=BURN, linewidth=4.5, label=label, solid_capstyle="round")
        chosen = np.linspace(0, len(way) - 1, ARROWS).astype(int)
        panel.quiver(
            way[chosen, 0], way[chosen, 1], 0.09 * span * u[chosen, 0], 0.09 * span * u[chosen, 1],
            angles="xy", scale_units="xy", scale=1.0, width=0.005, color="#222222", zorder=3,
        )  # fmt: skip
        middle = way[len(way) // 2, :2]
        across, up = -16.0 * middle / np.linalg.norm(middle)
        panel.annotate(
            f"{k + 1}", (middle[0], middle[1]), xytext=(float(across), float(up)), textcoords="offset points", ha="center", va="center",
            fontweight="bold", color=BURN,
        )  # fmt: skip
    panel.set_aspect("equal", adjustable="datalim")
    panel.set_xlabel("along the first position, in the first orbit's plane (km)")
    panel.set_ylabel("ahead of it (km)")
    panel.legend(loc="upper center", bbox_to_anchor=(0.45, -0.085), ncols=2, fontsize=8.5)
    figure.suptitle(
        f"{plan.scenario.name}: two burns, {plan.delta_v_m_s:.1f} m/s", x=0.01, ha="left", fontweight="bold"
    )
    return figure


def history_figure(plan: TransferPlan, found: Verification) -> Figure:
    """Altitude, perigee and apogee, mass and Δv from the scenario's state to the last cut-off."""
    from matplotlib.figure import Figure

    flight, thruster = found.flight, plan.scenario.vehicle.thruster()
    figure = Figure(figsize=(7.2, 8.0))
    grid = {"height_ratios": (1.2, 1.4, 0.8, 1.0), "hspace": 0.22, **MARGINS}
    panels = list(figure.subplots(4, 1, sharex=True, gridspec_kw=grid))
    mass_kg = thruster.mass_kg
    spent = 0.0
    columns: list[tuple[Array, Array, Array, Array, Array, Array]] = []
    for k, (coast, burn) in enumerate(zip(flight.coasts, flight.burns, strict=True)):
        states = coast.states
        heights = np.array([_heights(state) for state in states])
        still = np.full(len(states), 1.0)
        times = coast.times_s + flight.starts_s[2 * k]
        altitude = np.linalg.norm(states[:, :3], axis=1) - EARTH.earth_radius_m
        columns.append((times, altitude, heights[:, 0], heights[:, 1], mass_kg * still, spent * still))
        engine = type(thruster)(mass_kg, thruster.thrust_n, thruster.mass_flow_kg_s)
        told = History.of(engine, burn)
        start_s = flight.starts_s[2 * k + 1]
        columns.append((
            told.times_s + start_s, told.altitude_m, told.perigee_height_m, told.apogee_height_m, told.mass_kg,
            spent + told.delta_v_m_s,
        ))  # fmt: skip
        mass_kg, spent = float(told.mass_kg[-1]), spent + float(told.delta_v_m_s[-1])
        for panel in panels:
            panel.axvspan(start_s, start_s + float(burn.times_s[-1]), color=BURN, alpha=0.25, linewidth=0.0)
    time, altitude, perigee, apogee, mass, delta_v = (
        np.concatenate(each) for each in zip(*columns, strict=True)
    )
    panels[0].plot(time, altitude / 1e3, color="#222222")
    panels[0].set_ylabel("altitude (km)")
    panels[1].plot(time, perigee / 1e3, color=BEFORE, label="perigee height")
    panels[1].plot(
        time, np.where(np.isfinite(apogee), apogee, np.nan) / 1e3, color=AFTER, label="apogee height"
    )
    panels[1].set_ylabel("osculating (km)")
    panels[1].legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, borderaxespad=0.1)
    panels[2].plot(time, mass, color="#444444")
    panels[2].set_ylabel("mass (kg)")
    panels[3].plot(time, delta_v, color="#222222")
    panels[3].set_ylabel("spent Δv (m/s)")
    panels[3].set_xlabel("time from the first state (s)")
    panels[3].set_xlim(0.0, time[-1])
    figure.align_ylabels(panels)
    title = f"{plan.scenario.name}: {plan.delta_v_m_s:.1f} m/s, {plan.propellant_kg:.1f} kg in {plan.total_time_s:.0f} s"
    figure.suptitle(title, x=0.01, ha="left", fontweight="bold")
    return figure


def attitude_figure(plan: TransferPlan, found: Verification) -> Figure:
    """The direction of thrust over each burn, one column a burn."""
    from matplotlib.figure import Figure

    transfer = plan.transfer
    assert transfer is not None
    figure = Figure(figsize=(7.2, 4.8))
    grid = {"wspace": 0.38, "hspace": 0.15, "left": 0.14, "right": 0.98, "bottom": 0.12, "top": 0.86}
    panels = figure.subplots(2, 2, sharex="col", gridspec_kw=grid)
    for k, (burn, controls) in enumerate(zip(found.flight.burns, transfer.controls, strict=True)):
        at = 0.5 * float(burn.times_s[-1]) * (transfer.grid.nodes + 1.0)
        flown, nodal = _angles_deg(burn.direction), _angles_deg(controls)
        for row, (name, colour) in enumerate((("right ascension", BEFORE), ("elevation", BURN))):
            panel: Axes = panels[row, k]
            panel.plot(burn.times_s, flown[row], color=colour)
            panel.plot(at, nodal[row], "o", markerfacecolor="white", markeredgecolor=colour, markersize=4.5)
            panel.margins(y=0.12)
            panel.ticklabel_format(axis="y", useOffset=False)
            if k == 0:
                panel.set_ylabel(f"{name} (°)")
        panels[0, k].set_title(f"burn {k + 1}", fontsize=10)
        panels[1, k].set_xlabel("time since its ignition (s)")
    figure.suptitle(
        f"{plan.scenario.name}: thrust direction, {transfer.grid.size} nodes a burn",
        x=0.01,
        ha="left",
        fontweight="bold",
    )
    return figure


def _angles_deg(u: Array) -> tuple[Array, Array]:
    """Right ascension without jumps, and elevation."""
    pitch, yaw = pitch_yaw(u)
    return np.rad2deg(np.unwrap(pitch)), -np.rad2deg(yaw)


def _heights(state: Array) -> tuple[float, float]:
    orbit = elements_from_state(state[:3], state[3:])
    return orbit.perigee_height_m(), orbit.apogee_height_m()


def _out_of_plane_deg(u: Array) -> float:
    return float(np.rad2deg(np.arcsin(np.clip(np.abs(u[:, 2]).max(), 0.0, 1.0))))
