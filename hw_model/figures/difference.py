"""The difference of two configurations as a waterfall: from A, cause by cause, to B."""

# matplotlib leaves its keyword arguments untyped:
# pyright: reportUnknownMemberType=false

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from .drawing import GREEN, GREY, RED, blank, finished, legend, note

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from hw_model.report.explain import Difference


def difference_figure(found: Difference, path: str | Path | None = None) -> Figure:
    """Bars of A and B in grey, between them what each cause adds or saves."""
    changes = {cause: (b - a) / 1e9 for cause, (a, b) in found.by_cause.items() if a != b}
    figure = blank(max(6.0, 2.4 + 0.9 * len(changes)), 4.0)
    axes = figure.add_subplot()
    level = found.a_picoseconds / 1e9
    axes.bar(0, level, color=GREY)
    note(axes, f"{level:.2f}", (0, level), ha="center")
    for place, (_, change) in enumerate(changes.items(), 1):
        axes.bar(place, abs(change), bottom=min(level, level + change), color=RED if change > 0 else GREEN)
        axes.plot([place - 1.4, place + 0.4], [level, level], color="black", linewidth=0.6)
        level += change
        top = max(level, level - change)
        note(axes, f"{change:+.2f}", (place, top), ha="center")
    last = len(changes) + 1
    end = found.b_picoseconds / 1e9
    axes.bar(last, end, color=GREY)
    note(axes, f"{end:.2f}", (last, end), ha="center")
    axes.set_xticks(range(last + 1), ["A", *(name.replace("_", " ") for name in changes), "B"], fontsize=8)
    axes.set_ylabel("modelled time, ms")
    axes.margins(y=0.12)
    axes.set_title(f"Modelled: A = {found.a}\nB = {found.b}", fontsize=9, loc="left")
    legend(figure, {"takes longer": RED, "saves": GREEN})
    return finished(figure, path)
