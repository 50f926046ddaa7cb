"""The band of largest orbits around the Earth, to turn in a browser: one self-contained page."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ..search.query.results import ReachableDomain
from .ellipses import EARTH_KM, band_title, largest_ellipses

SHADES = 12
"""Groups of one colour in which orbits are drawn: a trace a line would be slow to turn."""


def write_band(domain: ReachableDomain, path: Path) -> None:
    """Write the page; it holds everything it needs and fetches nothing."""
    import plotly.graph_objects as go
    from plotly.colors import sample_colorscale

    orbits = largest_ellipses(domain, samples=121)
    u, v = np.meshgrid(np.linspace(0.0, 2.0 * np.pi, 61), np.linspace(0.0, np.pi, 31))
    ball = EARTH_KM * np.stack([np.cos(u) * np.sin(v), np.sin(u) * np.sin(v), np.cos(v)])
    traces: list[Any] = [
        go.Surface(
            x=ball[0],
            y=ball[1],
            z=ball[2],
            showscale=False,
            colorscale=[[0.0, "#b9c6d2"], [1.0, "#b9c6d2"]],
            hoverinfo="skip",
            name="Earth",
        )
    ]
    if orbits.curves:
        apogees = orbits.apogees
        logs = np.log10(apogees)
        group = np.minimum(
            ((logs - logs.min()) / max(float(np.ptp(logs)), 1e-12) * SHADES).astype(int), SHADES - 1
        )
        for shade in np.unique(group):
            members = np.flatnonzero(group == shade)
            gap = np.full((1, 3), np.nan)
            line = np.concatenate([np.vstack([orbits.curves[k], gap]) for k in members]).round(1)
            low, high = apogees[members].min(), apogees[members].max()
            colour = sample_colorscale("Viridis", (shade + 0.5) / SHADES)[0]
            traces.append(
                go.Scatter3d(
                    x=line[:, 0],
                    y=line[:, 1],
                    z=line[:, 2],
                    mode="lines",
                    line={"color": colour, "width": 2},
                    name=f"apogee {low:.0f}–{high:.0f} km",
                    hoverinfo="name",
                )
            )
    figure = go.Figure(traces)
    figure.update_layout(
        title=band_title(domain, orbits, gap="<br>"),
        scene={
            "aspectmode": "data",
            "xaxis_title": "x (km)",
            "yaxis_title": "y (km)",
            "zaxis_title": "z (km)",
        },
        legend={"title": "click to hide"},
        margin={"l": 0, "r": 0, "t": 48, "b": 0},
    )
    figure.write_html(path, include_plotlyjs=True, full_html=True)
