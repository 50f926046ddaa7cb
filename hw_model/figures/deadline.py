"""Modelled times of many cases against a deadline: nominal and worst, as two histograms."""

# matplotlib leaves its keyword arguments untyped:
# pyright: reportUnknownMemberType=false

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from hw_model.errors import HwModelError

from .drawing import BLUE, ORANGE, blank, finished, legend, note

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def deadline_figure(
    nominal_ms: Sequence[float],
    worst_ms: Sequence[float],
    deadline_ms: float,
    title: str,
    path: str | Path | None = None,
) -> Figure:
    """Histograms of nominal time and of each case's worst case; the black line is the deadline."""
    if not nominal_ms:
        raise HwModelError("`nominal_ms` is empty: there is no verified case to draw")
    figure = blank(7.2, 3.8)
    axes = figure.add_subplot()
    count = max(8, min(40, len(nominal_ms) // 4))
    ends = min(*nominal_ms, *worst_ms), max(*nominal_ms, *worst_ms)
    for times, colour in (
        (nominal_ms, BLUE),
        (worst_ms, ORANGE),
    ):  # the same bins, and neither hides the other
        axes.hist(times, bins=2 * count, range=ends, color=colour, alpha=0.75)
    axes.axvline(deadline_ms, color="black", linewidth=1.5)
    right = axes.get_xaxis_transform()
    note(axes, f"deadline {deadline_ms:g} ms", (deadline_ms, 1.0), (4, -10), xycoords=right)
    axes.set_xlim(0.0, 1.15 * max(deadline_ms, *worst_ms))
    axes.set_xlabel("modelled time of all conic solves of a plan, ms")
    axes.set_ylabel("cases")
    axes.set_title(title, fontsize=10)
    legend(figure, {"nominal": BLUE, "worst case: slow end, every jitter at its bound": ORANGE})
    return finished(figure, path)
