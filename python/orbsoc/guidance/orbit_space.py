"""Orbits in space about their body, and the track on the ground below: the first pictures of a report.

Space is drawn in parallel projection with hidden lines thin, so that no depth is guessed by the drawing library.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import TYPE_CHECKING

import numpy as np

from orbsoc.orbit import ConstantsSet, Elements, state_from_elements
from orbsoc.orbit.array import Array, Flags
from orbsoc.orbit.elements import at_true_anomaly
from orbsoc.orbit.reference_frames import FrameName, below_deg

from .figure_style import GREY
from .presets import presets

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

ASYMPTOTE = 0.9
"""Of the anomaly of a hyperbola's asymptote, to which it is drawn at most."""
FAR = 3.0
"""Of the farthest drawn arc, to which an open orbit is drawn."""
HIDDEN = 0.35
"""Opacity of what the body hides."""


@dataclass(frozen=True, slots=True)
class Curve:
    """Positions (K, 3), m, in inertial axes whose z is the pole, with times (K,), s; a burn is drawn thick."""

    label: str
    colour: str
    positions_m: Array
    times_s: Array
    width: float = 1.6
    style: str = "-"


@dataclass(frozen=True, slots=True)
class Whole:
    """A whole osculating orbit."""

    label: str
    colour: str
    orbit: Elements
    style: str = "-"


def space_figure(title: str, body: ConstantsSet, orbits: Sequence[Whole], curves: Sequence[Curve]) -> Figure:
    """Orbits and arcs of flight about a globe with its graticule, and the line of nodes of the last orbit.

    The first curve faces the reader; instants that are points are drawn as such.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7.2, 7.4), layout="constrained")
    panel = figure.add_subplot()
    view = _view(curves[0].positions_m, orbits[-1].orbit)
    radius_km = body.earth_radius_m / 1e3
    farthest_m = max(float(np.linalg.norm(curve.positions_m, axis=1).max()) for curve in curves)
    _globe(panel, view, radius_km)
    for each in orbits:
        points = _points(each.orbit, FAR * farthest_m) / 1e3
        _line(panel, view, points, radius_km, color=each.colour, linestyle=each.style, label=each.label)
    _nodes(panel, view, orbits[-1].orbit, radius_km, FAR * farthest_m / 1e3)
    for curve in curves:
        if len(curve.positions_m) == 1 or curve.style == "":
            seen = curve.positions_m @ view.T / 1e3
            hidden = _hidden(seen, radius_km)
            panel.plot(
                *seen[~hidden, :2].T, "o", color=curve.colour, markersize=6.0, label=curve.label, zorder=6
            )
            panel.plot(*seen[hidden, :2].T, "o", color=curve.colour, markersize=6.0, alpha=HIDDEN, mfc="none")
            continue
        _line(
            panel, view, curve.positions_m / 1e3, radius_km, color=curve.colour, linestyle=curve.style,
            linewidth=curve.width, label=curve.label, zorder=5,
        )  # fmt: skip
    panel.set_aspect("equal", adjustable="datalim")
    panel.set_axis_off()
    _scale(panel)
    figure.legend(loc="outside lower center", ncols=2, fontsize=9.5)
    figure.suptitle(title, x=0.01, ha="left", fontweight="bold")
    return figure


def ground_figure(title: str, frame: FrameName, epoch: datetime, curves: Sequence[Curve]) -> Figure:
    """The tracks below the curves on a graticule of the Earth, with the launch sites that presets name."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8.6, 4.9), layout="constrained")
    panel = figure.add_subplot()
    for site in presets("site").values():
        panel.plot(site["longitude_deg"], site["latitude_deg"], "^", color=GREY, markersize=3.5, zorder=1)
    panel.plot([], [], "^", color=GREY, markersize=3.5, linestyle="none", label="launch sites")
    for curve in curves:
        latitude, longitude = below_deg(frame, epoch, curve.times_s, curve.positions_m)
        if len(latitude) == 1 or curve.style == "":
            panel.plot(
                longitude, latitude, "o", color=curve.colour, markersize=6.0, label=curve.label, zorder=4
            )
            continue
        jump = np.flatnonzero(np.abs(np.diff(longitude)) > 180.0) + 1
        panel.plot(
            np.insert(longitude, jump, np.nan), np.insert(latitude, jump, np.nan), color=curve.colour,
            linewidth=curve.width, linestyle=curve.style, label=curve.label, zorder=3,
        )  # fmt: skip
    panel.axhline(0.0, color=GREY, linewidth=0.9)
    panel.set(
        xlim=(-180.0, 180.0), ylim=(-90.0, 90.0), xticks=range(-180, 181, 30), yticks=range(-90, 91, 30)
    )
    panel.set(xlabel="longitude (° east)", ylabel="geocentric latitude (°)", aspect="equal")
    panel.grid(visible=True, color="#d9d9d9", linewidth=0.6)
    figure.legend(loc="outside lower center", ncols=3, fontsize=9.5)
    figure.suptitle(title, x=0.01, ha="left", fontweight="bold")
    return figure


def _view(facing: Array, orbit: Elements) -> Array:
    """Rows: to the right, upwards, towards the reader: the middle of an arc in front, the orbit's plane seen aslant."""
    middle = facing[len(facing) // 2] / np.linalg.norm(facing[len(facing) // 2])
    position, velocity = state_from_elements(orbit)
    normal = np.cross(position, velocity)
    normal /= np.linalg.norm(normal)
    towards = 0.75 * middle + 0.6 * normal + np.array([0.0, 0.0, 0.35])
    towards /= np.linalg.norm(towards)
    right = np.cross([0.0, 0.0, 1.0], towards)
    right = right / np.linalg.norm(right) if np.linalg.norm(right) > 1e-6 else np.array([1.0, 0.0, 0.0])
    return np.array([right, np.cross(towards, right), towards])


def _points(orbit: Elements, reach_m: float) -> Array:
    """A whole ellipse, or of a hyperbola what lies within reach, (K, 3), m."""
    widest = np.pi if orbit.ecc < 1.0 else ASYMPTOTE * float(np.arccos(-1.0 / orbit.ecc))
    anomalies = np.linspace(-widest, widest, 721)
    points = np.array([state_from_elements(at_true_anomaly(orbit, nu))[0] for nu in anomalies])
    if orbit.ecc >= 1.0:
        points = points[np.linalg.norm(points, axis=1) <= reach_m]
    return points


def _line(panel: Axes, view: Array, points: Array, radius_km: float, **style: object) -> None:
    """A curve (K, 3), km: thin and faint where the globe hides it."""
    seen = points @ view.T
    hidden = _hidden(seen, radius_km)
    front, back = seen[:, :2].copy(), seen[:, :2].copy()
    front[hidden] = np.nan
    back[~(hidden | np.roll(hidden, 1) | np.roll(hidden, -1))] = np.nan
    order = style.pop("zorder", 3)
    panel.plot(*front.T, **{"linewidth": 1.6, "zorder": order, **style})  # type: ignore[arg-type]
    faint = {**style, "label": None, "linestyle": ":", "linewidth": 1.2, "alpha": HIDDEN, "zorder": 2}
    panel.plot(*back.T, **faint)  # type: ignore[arg-type]


def _hidden(seen: Array, radius_km: float) -> Flags:
    """Which points (K, 3), in the view's axes, lie behind the globe."""
    return np.asarray((seen[:, 2] < 0.0) & (np.hypot(seen[:, 0], seen[:, 1]) < radius_km), np.bool_)


def _globe(panel: Axes, view: Array, radius_km: float) -> None:
    """The disc, the front half of a graticule of 30°, and the pole's axis."""
    from matplotlib.patches import Circle

    panel.add_patch(Circle((0.0, 0.0), radius_km, facecolor="#e8eef4", edgecolor="#9fb3c8", zorder=0))
    turn = np.linspace(0.0, 2.0 * np.pi, 241)
    rings = [
        np.stack(
            [np.cos(lat) * np.cos(turn), np.cos(lat) * np.sin(turn), np.full_like(turn, np.sin(lat))], axis=1
        )
        for lat in np.deg2rad(np.arange(-60, 61, 30))
    ]
    rings += [
        np.stack([np.cos(lon) * np.cos(turn), np.sin(lon) * np.cos(turn), np.sin(turn)], axis=1)
        for lon in np.deg2rad(np.arange(0, 180, 30))
    ]
    for k, ring in enumerate(rings):
        seen = radius_km * ring @ view.T
        seen[seen[:, 2] < 0.0] = np.nan
        equator = k == 2
        panel.plot(
            seen[:, 0],
            seen[:, 1],
            color="#7f97ad" if equator else "#c3d0dc",
            linewidth=1.1 if equator else 0.6,
            zorder=1,
        )
    for pole in (1.0, -1.0):
        ends = np.array([[0.0, 0.0, pole], [0.0, 0.0, 1.18 * pole]]) * radius_km @ view.T
        shown = pole * view[2, 2] > 0.0
        panel.plot(ends[:, 0], ends[:, 1], color="#7f97ad", linewidth=1.1, zorder=1 if shown else -1)


def _nodes(panel: Axes, view: Array, orbit: Elements, radius_km: float, reach_km: float) -> None:
    """The line of nodes out to the orbit, its ascending end named; none of an equatorial orbit."""
    if abs(np.sin(orbit.inc_rad)) < 1e-6:
        return
    along = np.array([np.cos(orbit.raan_rad), np.sin(orbit.raan_rad), 0.0])
    ends = []
    for anomaly, sign in ((-orbit.argp_rad, 1.0), (np.pi - orbit.argp_rad, -1.0)):
        there = 1.0 + orbit.ecc * np.cos(anomaly)
        met_km = orbit.semilatus_rectum_m / there / 1e3 if there > 0.0 else np.inf
        outer = met_km if orbit.ecc < 1.0 else min(met_km, reach_km)
        ends.append(sign * outer * along)
    points = np.linspace(ends[0], ends[1], 201)
    _line(panel, view, points, radius_km, color=GREY, linewidth=0.9, linestyle="--", label="line of nodes")
    tip = ends[0] @ view[:2].T
    panel.annotate(
        "ascending node",
        (float(tip[0]), float(tip[1])),
        (6, 6),
        textcoords="offset points",
        fontsize=8.5,
        color=GREY,
    )


def _scale(panel: Axes) -> None:
    """A bar of a round length in the lower left corner."""
    panel.apply_aspect()
    low, high = panel.get_xlim()
    length = 10.0 ** np.floor(np.log10(0.3 * (high - low)))
    length *= max(step for step in (1.0, 2.0, 5.0) if step * length <= 0.3 * (high - low))
    bottom = panel.get_ylim()[0]
    panel.plot([low, low + length], [bottom, bottom], color="#222222", linewidth=2.0, solid_capstyle="butt")
    panel.annotate(f"{length:.0f} km", (low, bottom), (0, 5), textcoords="offset points", fontsize=8.5)
