"""The band of largest orbits around the Earth, to turn in a browser: one self-contained page."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from orbsoc.orbit.array import Array

from ..search.query.results import ReachableDomain
from .ellipses import EARTH_KM, band_title, largest_ellipses, sphere

SHADES = 12
"""Groups of one colour in which orbits are drawn: a trace a line would be slow to turn."""


def write_band(domain: ReachableDomain, path: Path) -> None:
    """Write the page; it holds everything it needs and fetches nothing."""
    import plotly.graph_objects as go
    from plotly.colors import sample_colorscale

    orbits = largest_ellipses(domain, samples=121)
    grey = [[0.0, "#b9c6d2"], [1.0, "#b9c6d2"]]
    ball = _coordinates(EARTH_KM * sphere(61, 31))
    traces: list[Any] = [go.Surface(ball, showscale=False, colorscale=grey, hoverinfo="skip", name="Earth")]
    if orbits.curves:
        apogees = orbits.apogees
        logs = np.log10(apogees)
        shares = (logs - logs.min()) / max(float(np.ptp(logs)), 1e-12)
        group = np.minimum((shares * SHADES).astype(int), SHADES - 1)
        for shade in np.unique(group):
            members = np.flatnonzero(group == shade)
            gap = np.full((1, 3), np.nan)
            line = np.concatenate([np.vstack([orbits.curves[k], gap]) for k in members]).round(1)
            low, high = apogees[members].min(), apogees[members].max()
            colour = sample_colorscale("Viridis", (shade + 0.5) / SHADES)[0]
            about = {"name": f"apogee {low:.0f}–{high:.0f} km", "hoverinfo": "name", "mode": "lines"}
            traces.append(go.Scatter3d(_coordinates(line), line={"color": colour, "width": 2}, **about))
    figure = go.Figure(traces)
    titles = {f"{axis}axis_title": f"{axis} (km)" for axis in "xyz"}
    figure.update_layout(
        title=band_title(domain, orbits, gap="<br>"),
        scene={"aspectmode": "data", **titles},
        legend={"title": "click to hide"},
        margin={"l": 0, "r": 0, "t": 48, "b": 0},
    )
    figure.write_html(path, include_plotlyjs=True, full_html=True)


def _coordinates(points: Array) -> dict[str, Array]:
    return dict(zip("xyz", np.moveaxis(points, -1, 0), strict=True))
