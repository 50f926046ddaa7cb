"""The picture of one point: the orbit before, the largest orbit in its plane, and the burn between them."""

from __future__ import annotations

from pathlib import Path

import matplotlib as mpl
import numpy as np

from orbsoc.guidance.figure_style import BLUE, GREEN, PLAIN, VERMILION, panels, write_png
from orbsoc.guidance.mission import FigureFile
from orbsoc.guidance.orbit_drawing import draw_earth, draw_orbit, plane_of
from orbsoc.guidance.orbit_space import Curve, Whole, space_figure
from orbsoc.orbit import EARTH, elements_from_state
from orbsoc.orbit.array import Array

from ..planner import PointPlan

STATES = 121
FAR = 4.0
"""Start radii, to which a hyperbola is drawn."""


def draw_point(plan: PointPlan, folder: Path) -> tuple[FigureFile, ...]:
    """Write `space.png` and `orbit.png` of a point that is reached, the latter in the plane of its largest orbit."""
    assert plan.programme is not None
    times_s = np.linspace(0.0, plan.scenario.burn.duration_s, STATES)
    states = plan.scenario.flown(plan.programme, times_s)
    return (_in_space(plan, states, folder), _flat(plan, states, folder))


def _in_space(plan: PointPlan, states: Array, folder: Path) -> FigureFile:
    before, after = (elements_from_state(state[:3], state[3:]) for state in (states[0], states[-1]))
    duration_s = plan.scenario.burn.duration_s
    times_s = np.linspace(0.0, duration_s, len(states))
    burn = Curve(f"burn, {duration_s:.1f} s", VERMILION, states[:, :3], times_s, width=4.0)
    orbits = [Whole("before", BLUE, before), Whole("the largest", GREEN, after)]
    with mpl.rc_context(PLAIN):
        figure = space_figure(f"{plan.scenario.name}: the largest orbit in one plane", EARTH, orbits, [burn])
        words = "The orbit before, the burn and the largest orbit about the Earth with its equator and graticule of 30°; dotted behind it."
        return write_png(figure, folder, "space.png", words)


def _flat(plan: PointPlan, states: Array, folder: Path) -> FigureFile:
    axes, reach = plane_of(states[-1]), FAR * float(np.linalg.norm(states[:, :3], axis=1).max()) / 1e3
    with mpl.rc_context(PLAIN):
        figure, (panel,) = panels((6.6, 6.6))
        draw_earth(panel)
        for state, colour, name in ((states[0], BLUE, "before"), (states[-1], GREEN, "the largest")):
            panel.plot(
                *draw_orbit(elements_from_state(state[:3], state[3:]), axes, reach), color=colour, label=name
            )
        burn = states[:, :3] @ axes.T / 1e3
        panel.plot(
            burn[:, 0],
            burn[:, 1],
            color=VERMILION,
            linewidth=4.0,
            label=f"burn, {plan.scenario.burn.duration_s:.1f} s",
        )
        panel.set_aspect("equal", adjustable="datalim")
        panel.set(xlabel="along the last position of the burn (km)", ylabel="ahead of it (km)")
        figure.legend(loc="outside lower center", ncols=3)
        figure.suptitle(f"{plan.scenario.name}: the largest orbit in one plane")
        words = "The orbit before, the burn and the largest orbit, seen along the normal of its plane."
        return write_png(figure, folder, "orbit.png", words)
