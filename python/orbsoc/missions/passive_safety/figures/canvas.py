"""Colours, style and panels of the figures. Matplotlib is imported when a figure is drawn, with the Agg canvas and without
pyplot: no global state, no display."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..planner import ApproachPlan

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


COLOURS = ("#0072B2", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", "#000000")
"""Okabe–Ito without vermilion, which is for what is unsafe."""
UNSAFE = "#D55E00"
KEEP_OUT = "#f3c9b5"
SHOWN = 6
"""Impulses that are drawn with a drift of their own; of more, the first ones."""


def colour(k: int) -> str:
    return COLOURS[k % len(COLOURS)]


def title(plan: ApproachPlan) -> str:
    assert plan.programme is not None
    return f"{plan.scenario.name}: {plan.programme.words}"


def panels(
    size: tuple[float, float], heights: tuple[float, ...], *, share: bool = True
) -> tuple[Figure, list[Axes]]:
    from matplotlib.figure import Figure

    figure = Figure(figsize=size, layout="constrained")
    found = figure.subplots(
        len(heights), 1, sharex=share, squeeze=False, gridspec_kw={"height_ratios": heights}
    )
    return figure, list(found[:, 0])
