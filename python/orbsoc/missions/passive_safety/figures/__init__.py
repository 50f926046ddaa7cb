"""The figures of a plan."""

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

    with mpl.rc_context(STYLE):
        found = [plane(plan, folder), charts.margins(plan, folder)]
        if plan.approach.guarded:
            found.append(charts.cut_burns(plan, folder))
        if plan.timed is not None and plan.timed.best is not None:
            found.append(charts.primer(plan, folder))
            if plan.timed.scanned:
                found.append(charts.scan(plan, folder))
        if plan.front:
            found.append(charts.front(plan, folder))
        if plan.flights:
            found.append(charts.flights(plan, folder))
    return tuple(found)
