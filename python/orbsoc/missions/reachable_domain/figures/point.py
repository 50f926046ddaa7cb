"""The picture of one point: the orbit before, the largest orbit in its plane, and the burn between them."""

from __future__ import annotations

from pathlib import Path

import matplotlib as mpl
import numpy as np
from numpy.typing import NDArray

from orbsoc.guidance.collocation import legendre_gauss
from orbsoc.guidance.figure_style import BLUE, GREEN, PLAIN, VERMILION, panels, write_png
from orbsoc.guidance.mission import FigureFile
from orbsoc.guidance.orbit_drawing import draw_earth, draw_orbit, plane_of
from orbsoc.guidance.orbit_space import Curve, Whole, space_figure
from orbsoc.guidance.powered_flight import commanded
from orbsoc.orbit import EARTH, elements_from_state, propagate_burn

from ..planner import PointPlan

Array = NDArray[np.float64]

STATES = 121
FAR = 4.0
"""Start radii, to which a hyperbola is drawn."""


def draw_point(plan: PointPlan, folder: Path) -> tuple[FigureFile, ...]:
    """Write `space.png` and `orbit.png` of a point that is reached, the latter in the plane of its largest orbit."""
    states = _flown(plan)
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
        duration_s = plan.scenario.burn.duration_s
        panel.plot(burn[:, 0], burn[:, 1], color=VERMILION, linewidth=4.0, label=f"burn, {duration_s:.1f} s")
        panel.set_aspect("equal", adjustable="datalim")
        panel.set_xlabel("along the last position of the burn (km)")
        panel.set_ylabel("ahead of it (km)")
        figure.legend(loc="outside lower center", ncols=3)
        figure.suptitle(f"{plan.scenario.name}: the largest orbit in one plane")
        words = "The orbit before, the burn and the largest orbit, seen along the normal of its plane."
        return write_png(figure, folder, "orbit.png", words)


def _flown(plan: PointPlan) -> Array:
    """States of the burn, (K, 6), ECI, SI, by the attitude programme normalised."""
    assert plan.programme is not None
    scenario = plan.scenario
    times_s = np.linspace(0.0, scenario.burn.duration_s, STATES)
    programme = commanded(legendre_gauss(len(plan.programme)), plan.programme, times_s[-1])

    def steering(t_s: float, state: Array) -> Array:
        vector = np.asarray(programme(t_s, state))
        return np.asarray(vector / np.linalg.norm(vector))

    return propagate_burn(scenario.initial_eci(), scenario.vehicle.thruster(), steering, times_s)
