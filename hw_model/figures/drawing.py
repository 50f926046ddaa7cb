"""What every figure of the model shares: an empty canvas, colours that the colour-blind tell apart, a legend, a file.

matplotlib is imported when a figure is drawn, not before.
"""

# matplotlib leaves its keyword arguments untyped:
# pyright: reportUnknownMemberType=false

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Okabe and Ito.
BLUE, GREEN, ORANGE, RED = "#0072B2", "#009E73", "#E69F00", "#D55E00"
SKY, PINK, YELLOW, GREY = "#56B4E9", "#CC79A7", "#F0E442", "#999999"
PLACES = {"PS": BLUE, "PL": GREEN, "link": ORANGE, "interrupt": RED}
"""Colours of `vocabulary.by_place`."""
SERIES = (BLUE, ORANGE, GREEN, RED, PINK, SKY, YELLOW, GREY)
PALE = "#BBBBBB"
_DPI = 150


def blank(width: float, height: float) -> Figure:
    """An empty figure without any window system behind it; inches."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def note(
    axes: Axes, text: str, at: tuple[float, float], offset: tuple[float, float] = (0, 3), **options: Any
) -> None:
    """Text beside a point, `offset` points away."""
    axes.annotate(text, at, offset, textcoords="offset points", **{"fontsize": 8, **options})


def legend(figure: Figure, colours: Mapping[str, str]) -> None:
    """One row under the axes, in the given order whatever was drawn."""
    from matplotlib.patches import Patch

    patches = [Patch(color=colour, label=name) for name, colour in colours.items()]
    columns = min(len(patches), 6)
    figure.legend(handles=patches, loc="outside lower center", ncols=columns, fontsize=8, frameon=False)


def finished(figure: Figure, path: str | Path | None) -> Figure:
    """The figure, saved as PNG where `path` is given."""
    for axes in figure.axes:
        axes.spines[["top", "right"]].set_visible(False)
    if path is not None:
        figure.savefig(path, dpi=_DPI)
    return figure
