"""Figures of a reachable domain: maps, boundary curves, the band around the Earth and its equatorial projection.

Drawn with Matplotlib's Agg canvas, without pyplot: no global state, no display.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from orbsoc.guidance.figure_style import PLAIN, write_png
from orbsoc.guidance.mission import FigureFile

from ..search.continuation.boundary import edge_note
from ..search.query.results import ReachableDomain
from .orbits import draw_band, draw_projection
from .planes import draw_boundary, draw_maps

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def draw_figures(domain: ReachableDomain, folder: Path) -> tuple[FigureFile, ...]:
    """Write all figures into `folder`."""
    import matplotlib as mpl
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    note = edge_note(domain.domain)
    plots: list[tuple[Callable[[Figure, ReachableDomain], None], tuple[float, float], str, str]] = [
        (draw_maps, (11.0, 6.8), "apogee_maps.png", "Largest apogee height on each plane, for several bounds on the perigee height."
         " White: not reached; purple, where there is any: the vehicle escapes."
         f" {note or 'The line is the edge found without the grid.'}"),
        (draw_boundary, (8.2, 6.4), "boundary.png", "The edge of the reachable planes for several perigee bounds. Solid inside the"
         " grid's search box, dashed where the box would cut it off."),
        (draw_projection, (8.8, 5.0), "projection.png", "Largest orbits of all reached planes at the lowest perigee bound, projected"
         " on the equator (after figure 4 of the paper), seen from over the north pole: lines on the Earth's disc pass over the"
         " northern hemisphere, what the Earth hides is left out. Colour: apogee height."),
        (draw_band, (9.6, 5.4), "band.png", "The same orbits in space (after figure 3 of the paper); band.html turns."),
    ]  # fmt: skip
    written = []
    for draw, size, name, caption in plots:
        if draw is draw_boundary and note:
            continue
        with mpl.rc_context(PLAIN):
            figure = Figure(figsize=size, layout=None if draw is draw_band else "constrained")
            FigureCanvasAgg(figure)
            draw(figure, domain)
            written.append(write_png(figure, folder, name, caption))
    return tuple(written)
