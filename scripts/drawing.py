"""What the drawing scripts share: the ground, colours, boxes, text and arrows in the picture's own units."""

from __future__ import annotations

from pathlib import Path

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import FancyArrowPatch, FancyBboxPatch, Rectangle

FOLDER = Path(__file__).resolve().parents[1] / "docs" / "figures"
GROUND, CARD, INK, SOFT, LINE = "#f7f5f0", "#ffffff", "#1f2733", "#5b6675", "#c9c3b6"
TEAL, BLUE, INDIGO, ORANGE = "#16807a", "#2c62a8", "#3f4a9c", "#c2611f"
PURPLE, RED, GREEN = "#7b3f98", "#b3364b", "#2f7d3b"

Box = tuple[float, float, float, float]
Point = tuple[float, float]


def canvas(width: float, height: float) -> tuple[Figure, Axes]:
    """A picture of that many units, y downwards, on its own light ground, for dark pages too."""
    mpl.rcParams.update({"svg.hashsalt": "orbsoc", "font.family": "DejaVu Sans"})
    figure = Figure(figsize=(width / 100, height / 100))
    axes = figure.add_axes((0, 0, 1, 1), xlim=(0, width), ylim=(height, 0))
    axes.set_axis_off()
    box(axes, (-20, -20, width + 40, height + 40), GROUND, GROUND)
    return figure, axes


def save(figure: Figure, name: str) -> None:
    """docs/figures/NAME.svg and .png, the same bytes each time."""
    figure.savefig(FOLDER / f"{name}.svg", metadata={"Date": None})
    figure.savefig(FOLDER / f"{name}.png", dpi=200, metadata={"Software": None})


def box(
    axes: Axes, place: Box, face: str, edge: str, *, radius: float = 10, dashed: bool = False, band: str = ""
) -> None:
    """A rounded box, with a band of colour along its top."""
    left, top, width, height = place
    style, line = f"round,pad=0,rounding_size={radius}", (0, (4, 3)) if dashed else "-"
    shape = FancyBboxPatch((left, top), width, height, boxstyle=style, fc=face, ec=edge, lw=0.9, ls=line)
    axes.add_patch(shape)
    if band:
        stripe = Rectangle((left, top), width, 6, facecolor=band, edgecolor="none")
        axes.add_patch(stripe)
        stripe.set_clip_path(shape)


def text(
    axes: Axes, place: Point, words: str, size: float, color: str = INK, *,
    weight: str = "normal", at: str = "center", mono: bool = False,
) -> None:  # fmt: skip
    """Text on a baseline; its size is in the picture's units."""
    family = "DejaVu Sans Mono" if mono else "DejaVu Sans"
    axes.text(
        *place,
        words,
        fontsize=0.72 * size,
        color=color,
        fontweight=weight,
        ha=at,
        va="baseline",
        family=family,
    )


def arrow(axes: Axes, start: Point, end: Point, color: str = INK) -> None:
    shape = FancyArrowPatch(
        start, end, arrowstyle="-|>", mutation_scale=9, lw=1.2, color=color, shrinkA=0, shrinkB=0
    )
    axes.add_patch(shape)
