"""Figures that tell the plan: the orbits before and after with the burn between them, and what the burn does over time."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from orbsoc.guidance.figure_style import BLUE, GREEN, VERMILION, labels_in_line, write_png
from orbsoc.guidance.mission import FigureFile
from orbsoc.guidance.orbit_drawing import draw_earth, draw_orbit, plane_of
from orbsoc.orbit import EARTH, elements_from_state

from ..model.coast import coasted
from ..search.result import SearchResult
from ..verification import Verification, shape_of
from .history import History

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

BEFORE, BURN, AFTER, COAST = BLUE, VERMILION, GREEN, "#7a7a7a"
ARROWS = 7
INSIDE = 0.5
"""Of a panel's side, that the Earth has to take for a close-up within it."""
FAR = 4.0
"""Start radii, to which a hyperbola is drawn."""
MARGINS = {"left": 0.12, "right": 0.97, "bottom": 0.07, "top": 0.94}
"""Fixed, for a layout that is worked out takes as long as the drawing."""


ROOM = 1.25
"""Factor on the panel's span where the close-up stands in a corner."""


def orbit_figure(plan: SearchResult, found: Verification) -> Figure:
    """The plane of the first orbit as seen from its angular momentum: both orbits, the coast, the burn, the thrust."""
    from matplotlib.figure import Figure

    flight = found.flight
    start = plan.scenario.launch_inertial(plan.scenario.initial)
    axes = plane_of(start)
    first, last = (elements_from_state(x[:3], x[3:]) for x in (start, flight.propagated[-1]))
    figure = Figure(figsize=(7.2, 7.2))
    panel = figure.add_axes((0.15, 0.215, 0.8, 0.73))
    draw_earth(panel)
    reach = FAR * float(np.linalg.norm(flight.propagated[:, :3], axis=1).max()) / 1e3
    shown = [draw_orbit(orbit, axes, reach) for orbit in (first, last)]
    for points, orbit, colour, name in zip(
        shown, (first, last), (BEFORE, AFTER), ("before", "after"), strict=True
    ):
        panel.plot(*points, color=colour, label=f"{name}: {shape_of(orbit)}")
    if plan.ignition_s > 0.0:
        way = coasted(plan.scenario, np.linspace(0.0, plan.ignition_s, 400))[:, :3] @ axes.T / 1e3
        panel.plot(
            way[:, 0],
            way[:, 1],
            color=COAST,
            linestyle=":",
            linewidth=2.4,
            label=f"coast, {plan.ignition_s:.0f} s",
        )
    burn = flight.propagated[:, :3] @ axes.T / 1e3
    if plan.time_of_flight_s > 0.0:
        panel.plot(
            burn[:, 0], burn[:, 1], color=BURN, linewidth=4.0, label=f"burn, {plan.time_of_flight_s:.1f} s"
        )
    panel.plot(*burn[0, :2], "o", color=BURN, markersize=6)
    panel.set_aspect("equal", adjustable="datalim")
    panel.set_xlabel("along the first position, in the first orbit's plane (km)")
    panel.set_ylabel("ahead of it (km)")
    panel.legend(loc="upper center", bbox_to_anchor=(0.5, -0.085), ncols=1, fontsize=9.5)
    if plan.time_of_flight_s > 0.0:
        _close_up(panel, burn, flight.direction @ axes.T, np.hstack(shown))
    figure.suptitle(f"{plan.scenario.name}: the orbit before and after", x=0.01, ha="left", fontweight="bold")
    return figure


def _close_up(panel: Axes, burn: Array, direction: Array, orbits: Array) -> None:
    """The burn arc with thrust arrows, in a panel of its own: inside the Earth, or in the emptiest corner."""
    span = max(float(np.ptp(burn[:, 0])), float(np.ptp(burn[:, 1])), 1e-3)
    panel.apply_aspect()
    corner, size = _free_place(panel, orbits)
    inset = panel.inset_axes((*corner, size, size))
    inset.plot(burn[:, 0], burn[:, 1], color=BURN, linewidth=3.0)
    chosen = np.linspace(0, len(burn) - 1, ARROWS).astype(int)
    length = 0.28 * span
    inset.quiver(
        burn[chosen, 0], burn[chosen, 1], length * direction[chosen, 0], length * direction[chosen, 1],
        angles="xy", scale_units="xy", scale=1.0, width=0.018, color="#222222", zorder=3,
    )  # fmt: skip
    middle, half = (burn.min(axis=0) + burn.max(axis=0))[:2] / 2, 0.5 * span + 1.15 * length
    inset.set_xlim(middle[0] - half, middle[0] + half)
    inset.set_ylim(middle[1] - half, middle[1] + half)
    inset.set_aspect("equal")
    inset.set_xticks([])
    inset.set_yticks([])
    inset.set_title("thrust over the burn", fontsize=8.5)
    out = float(np.rad2deg(np.arcsin(np.clip(np.abs(direction[:, 2]).max(), 0.0, 1.0))))
    inset.set_xlabel(f"{span:.0f} km across\nup to {out:.1f}° out of the plane", fontsize=8)


def _free_place(panel: Axes, orbits: Array) -> tuple[tuple[float, float], float]:
    """Lower left corner and size, in shares of the panel, of a square that hides little of the orbits (2, K)."""
    low, high = np.array([panel.get_xlim(), panel.get_ylim()]).T
    globe = 2e-3 * EARTH.earth_radius_m / (high - low)
    if globe.min() > INSIDE:
        size = 0.5 * float(globe.min()) * 0.6
        middle = -low / (high - low)
        return (float(middle[0]) - size / 2, float(middle[1]) - size / 2), size
    middle, half = (low + high) / 2, ROOM * (high - low) / 2
    low, high = middle - half, middle + half
    panel.set_xlim(low[0], high[0])
    panel.set_ylim(low[1], high[1])
    size = 0.23
    places = [(x, y) for x in (0.03, 0.97 - size) for y in (0.09, 0.94 - size)]
    at = (orbits - low[:, None]) / (high - low)[:, None]
    hidden = [
        sum(np.all(np.abs(at.T - np.array(place) - size / 2) < 0.85 * size, axis=1)) for place in places
    ]
    return places[int(np.argmin(hidden))], size


def history_figure(plan: SearchResult, found: Verification) -> Figure:
    """Altitude, mass, Δv and where it is lost, apogee and perigee over the burn."""
    from matplotlib.figure import Figure

    history = History.of(plan.scenario.vehicle.thruster(), found.flight)
    time = history.times_s
    figure = Figure(figsize=(7.2, 8.0))
    heights = {"height_ratios": (1.0, 1.2, 0.8, 1.6), "hspace": 0.22, **MARGINS}
    panels = figure.subplots(4, 1, sharex=True, gridspec_kw=heights)
    panels[0].plot(time, history.altitude_m / 1e3, color=BURN)
    panels[0].set_ylabel("altitude (km)")
    panels[1].plot(time, history.perigee_height_m / 1e3, color=BEFORE, label="perigee height")
    closed = np.where(np.isfinite(history.apogee_height_m), history.apogee_height_m, np.nan) / 1e3
    if np.isfinite(closed).any():
        panels[1].plot(time, closed, color=AFTER, label="apogee height")
        if np.nanmax(closed) > 20.0 * max(float(np.nanmin(closed)), 1.0):
            panels[1].set_yscale("symlog", linthresh=100.0)
    panels[1].set_ylabel("osculating (km)")
    panels[2].plot(time, history.mass_kg, color="#444444")
    panels[2].set_ylabel("mass (kg)")
    panels[3].plot(time, history.delta_v_m_s, color="#222222", linewidth=3.0, alpha=0.6, label="spent Δv")
    panels[3].plot(
        time, history.speed_change_m_s, color=AFTER, label=f"speed {'shed' if history.brakes else 'gained'}"
    )
    panels[3].plot(time, history.gravity_m_s, color=BEFORE, label="taken by gravity")
    panels[3].plot(time, history.steering_m_s, color=BURN, label="spent on turning")
    panels[3].set_ylabel("m/s")
    panels[3].set_xlabel("time since ignition (s)")
    panels[3].set_xlim(0.0, time[-1])
    for panel in (panels[1], panels[3]):
        panel.legend(
            loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=4, borderaxespad=0.1, handlelength=1.5
        )
    labels_in_line(panels)
    title = (
        f"{plan.scenario.name}: {history.delta_v_m_s[-1]:.1f} m/s, {plan.propellant_kg:.1f} kg of propellant"
    )
    figure.suptitle(title, x=0.01, ha="left", fontweight="bold")
    return figure


def draw(plan: SearchResult, found: Verification, folder: Path) -> tuple[FigureFile, ...]:
    """Write the figures; of a burn of 0 s the orbit alone."""
    orbit = write_png(
        orbit_figure(plan, found),
        folder,
        "orbit.png",
        "The orbit before and after, seen from the first orbit's angular momentum, with the burn between them; inside the Earth,"
        " the burn enlarged, with the thrust direction at equal times.",
    )
    if plan.time_of_flight_s == 0.0:
        return (orbit,)
    history = write_png(
        history_figure(plan, found),
        folder,
        "history.png",
        "What the burn does, as flown by the independent integrator: altitude, osculating perigee and apogee, mass, and the"
        " Δv of the engine as change of speed, gravity's share and what is spent on turning the velocity.",
    )
    return orbit, history
