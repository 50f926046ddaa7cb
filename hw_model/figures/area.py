"""What an engine takes of a device, as bars against the ceilings."""

# matplotlib leaves its keyword arguments untyped:
# pyright: reportUnknownMemberType=false

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING

from .drawing import GREEN, RED, blank, finished, note

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from hw_model.area.budget import Budget


def area_figure(found: Budget, title: str, path: str | Path | None = None) -> Figure:
    """A bar per resource, percent of the device; a tick marks its ceiling, red is over it."""
    figure = blank(6.4, 3.0)
    axes = figure.add_subplot()
    shares = [100.0 * use.share for use in found.uses]
    longest = max(100.0, *(share for share in shares if math.isfinite(share)))
    for place, (use, share) in enumerate(zip(found.uses, shares, strict=True)):
        percent = min(share, 1.25 * longest)  # of a device that has none of it, any use is infinite
        axes.barh(place, percent, height=0.6, color=GREEN if use.fits else RED)
        axes.plot([100 * use.ceiling] * 2, [place - 0.4, place + 0.4], color="black", linewidth=1.5)
        amounts = f"{use.used:,} of {use.available:,}".replace(",", " ")
        note(axes, amounts, (max(percent, 100 * use.ceiling), place), (5, 0), va="center")
    axes.set_yticks(range(len(found.uses)), [use.kind.upper() for use in found.uses])
    axes.invert_yaxis()
    axes.set_xlim(0.0, 1.25 * longest)
    axes.set_xlabel("modelled share of the device, % (black: ceiling)")
    axes.set_title(f"Modelled resources: {title}", fontsize=10)
    return finished(figure, path)
