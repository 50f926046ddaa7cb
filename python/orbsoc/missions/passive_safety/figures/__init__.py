"""The figures of a plan: the V-bar/R-bar plane first, then margins, cut burns, the front and flights with errors; how the
times were found, and the primer, stand in the appendix. Matplotlib is imported when a figure is drawn."""

from __future__ import annotations

from pathlib import Path

from orbsoc.guidance.figure_style import STYLE
from orbsoc.guidance.mission import FigureFile

from ..planner import ApproachPlan
from . import charts
from .plane import plane


def draw_figures(plan: ApproachPlan, folder: Path) -> tuple[FigureFile, ...]:
    """Write the figures of a plan that was flown into `folder`; empty when there is nothing to show."""
    if plan.verification is None or plan.programme is None:
        return ()
    import matplotlib as mpl

    solved = plan.timed is not None and plan.timed.best is not None
    wanted = (
        (plane, True),
        (charts.margins, True),
        (charts.cut_burns, plan.approach.guarded),
        (charts.front, bool(plan.front)),
        (charts.flights, bool(plan.flights)),
        (charts.primer, solved),
        (charts.scan, solved and plan.timed is not None and plan.timed.scanned > 0),
    )
    with mpl.rc_context(STYLE):
        return tuple(draw(plan, folder) for draw, shown in wanted if shown)
