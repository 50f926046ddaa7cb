"""Figures of two burns: those of every programme, and the thrust direction over each burn."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from orbsoc.guidance.figure_style import STYLE, write_png
from orbsoc.guidance.mission import FigureFile
from orbsoc.orbit import pitch_yaw
from orbsoc.orbit.array import Array

from ..figures.orbit import BEFORE, BURN
from ..figures.panels import draw_programme
from .transfer_plan import TransferPlan
from .verification import Verification

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def title_of(plan: TransferPlan) -> str:
    """Of the picture of the orbits."""
    return f"{plan.scenario.name}: two burns, {plan.delta_v_m_s:.1f} m/s"


def draw_figures(plan: TransferPlan, folder: Path) -> tuple[FigureFile, ...]:
    """Write the figures of a plan that was flown into `folder`; empty when there is nothing to show."""
    found = plan.verification
    if found is None:
        return ()
    import matplotlib as mpl

    spent = f"{plan.delta_v_m_s:.1f} m/s, {plan.propellant_kg:.1f} kg in {plan.total_time_s:.0f} s"
    caption = (
        "The thrust direction over each burn, as commanded and flown, with the nodes of its grid:"
        " right ascension atan2(u_y, u_x) and elevation asin(u_z) in the axes of the plan."
    )
    with mpl.rc_context(STYLE):
        titles = (title_of(plan), f"{plan.scenario.name}: {spent}")
        told = draw_programme(plan.scenario, titles, found.flight, folder)
        return (*told, write_png(attitude_figure(plan, found), folder, "attitude.png", caption))


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
