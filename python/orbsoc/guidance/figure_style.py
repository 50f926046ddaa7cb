"""The style of every mission's figures, for `matplotlib.rc_context`."""

from __future__ import annotations

from typing import Any

PLAIN: Any = {
    "font.size": 10.5,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.axisbelow": True,
    "legend.frameon": False,
    "figure.titlesize": 11,
}
"""Maps and curves in space."""

STYLE: Any = PLAIN | {
    "axes.grid": True,
    "grid.color": "#d9d9d9",
    "grid.linewidth": 0.6,
    "lines.linewidth": 1.8,
}
"""Curves over time: with a grid."""
