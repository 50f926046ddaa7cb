"""The picture of a search for an engine: every design in time and area, the front, and the paper's."""

# matplotlib leaves its keyword arguments untyped:
# pyright: reportUnknownMemberType=false

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from .drawing import BLUE, GREY, PALE, RED, blank, finished
from .study import log_axis

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from hw_model.report.design import Row


def design_figure(
    rows: Sequence[Row], front: Sequence[Row], paper: Row, title: str, path: str | Path | None = None
) -> Figure:
    """Time against the tightest resource: all designs, the front with its band, the paper's design, the PS alone."""
    figure = blank(7.2, 4.8)
    axes = figure.add_subplot()
    axes.plot(*_places(rows), ".", color=PALE, markersize=2, label="a design", zorder=1)
    low = [row.time_ms - row.time_low_ms for row in front]
    high = [row.time_high_ms - row.time_ms for row in front]
    axes.errorbar(
        *_places(front), yerr=[low, high], fmt="o-", color=BLUE, markersize=4, capsize=2, linewidth=0.8,
        label="the front, with its band", zorder=3,
    )  # fmt: skip
    axes.plot(*_places([paper]), "X", color=RED, markersize=9, label="the paper's design", zorder=4)
    axes.axhline(paper.baseline_ms, color=GREY, linewidth=0.9, label="all on one core of the PS")
    axes.axvline(100.0, color="black", linestyle="--", linewidth=0.8)
    times = [row.time_ms for row in (*rows, paper)]
    ends = [end for row in front for end in (row.time_low_ms, row.time_high_ms)]
    log_axis(axes.yaxis, [*times, paper.baseline_ms, *ends])
    widest = min(
        300.0, 1.05 * max(100.0, 100.0 * paper.area_share, *(100.0 * row.area_share for row in rows))
    )
    axes.set_xlim(0.0, widest)
    axes.set_xlabel(
        "tightest resource, % of its ceiling (right of the dashed line it does not fit)", fontsize=8
    )
    axes.set_ylabel("modelled time, ms")
    axes.set_title(title, fontsize=10)
    axes.legend(fontsize=8, edgecolor="none", loc="upper right")
    return finished(figure, path)


def _places(rows: Sequence[Row]) -> tuple[list[float], list[float]]:
    return [100.0 * row.area_share for row in rows], [row.time_ms for row in rows]
