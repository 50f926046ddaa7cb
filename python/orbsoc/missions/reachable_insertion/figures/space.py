"""The orbits with coasts and burns in space about the body, and of a scenario with a date the track on the ground."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from orbsoc.guidance.figure_style import write_png
from orbsoc.guidance.mission import FigureFile
from orbsoc.guidance.orbit_space import Curve, Whole, ground_figure, space_figure
from orbsoc.orbit import elements_from_state, rotate_state
from orbsoc.orbit.array import Array

from ..scenario import Scenario
from ..verification import Arcs
from .orbit import AFTER, BEFORE, BETWEEN, BURN, COAST

SPACE = "The orbits with coasts and burns in space, about the body with its equator, graticule of 30° and pole; dotted behind it."
GROUND = "The track on the ground of coasts and burns, on a graticule of 30°, with launch sites."


def draw_in_space(scenario: Scenario, title: str, start: Array, arcs: Arcs, folder: Path) -> list[FigureFile]:
    """Write `space.png` and, with a date, `ground.png`; `start` (6,) and arcs are in the axes of plans."""
    to_eci = scenario.eci_rotation
    states = [start, *(burn.propagated[-1] for burn in arcs.burns)]
    names = [("before", BEFORE, "-"), *[("between", BETWEEN, ":")] * (len(states) - 2), ("after", AFTER, "-")]
    orbits = []
    for state, (name, colour, style) in zip(states, names, strict=True):
        turned = rotate_state(to_eci, state)
        orbits.append(
            Whole(name, colour, elements_from_state(turned[:3], turned[3:], scenario.constants), style)
        )
    burns, coasts = [], []
    for k, burn in enumerate(arcs.burns):
        label = f"burn {k + 1}" if len(arcs.burns) > 1 else "burn"
        way, times_s = burn.propagated[:, :3] @ to_eci.T, arcs.starts_s[2 * k + 1] + burn.times_s
        if burn.times_s[-1] > 0.0:
            burns.append(Curve(f"{label}, {burn.times_s[-1]:.1f} s", BURN, way, times_s, width=4.2))
    for k, coast in enumerate(arcs.coasts):
        if coast.times_s.size and coast.times_s[-1] > 0.0:
            way, times_s = coast.states[:, :3] @ to_eci.T, arcs.starts_s[2 * k] + coast.times_s
            coasts.append(Curve(f"coast, {coast.times_s[-1]:.0f} s", COAST, way, times_s, width=2.2))
    here = Curve("start", BEFORE, (to_eci @ start[:3])[None], np.zeros(1), style="")
    curves = [*(burns or [here]), *coasts, *([here] if burns else [])]
    found = [write_png(space_figure(title, scenario.constants, orbits, curves), folder, "space.png", SPACE)]
    frame, epoch = scenario.initial.axes_name, scenario.initial.epoch
    if frame is not None and epoch is not None:
        track = ground_figure(f"{scenario.name}: ground track", frame, epoch, curves)
        found.append(write_png(track, folder, "ground.png", GROUND))
    return found
