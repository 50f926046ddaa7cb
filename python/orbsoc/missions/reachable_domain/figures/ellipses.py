"""The largest orbits of a domain at its lowest perigee bound, as curves in space, and what a picture of them leaves out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from orbsoc.orbit import EARTH, Elements, state_from_elements
from orbsoc.orbit.array import Array

from ..search.query.results import ReachableDomain

EARTH_KM = EARTH.earth_radius_m / 1e3
VIEW_KM = 120_000.0
"""From the Earth's centre, to where orbits are drawn: on the way to 4 million km the Earth would be a dot."""


def sphere(around: int, down: int) -> Array:
    """Unit vectors (down, around, 3) over a sphere, in equal steps of longitude and of the angle from the pole."""
    u, v = np.meshgrid(np.linspace(0.0, 2.0 * np.pi, around), np.linspace(0.0, np.pi, down))
    return np.stack([np.cos(u) * np.sin(v), np.sin(u) * np.sin(v), np.cos(v)], axis=-1)


@dataclass(frozen=True, slots=True, eq=False)
class Ellipses:
    """Curves (samples, 3) in km, NaN beyond `VIEW_KM`, and their apogee heights (K,) in km, smallest last so that it is
    drawn on top. `cut` of them run out of the picture; `escaping` planes, whose largest orbit is a hyperbola, have none."""

    curves: list[Array]
    apogees: Array
    cut: int
    escaping: int

    @property
    def omitted(self) -> str:
        """What the picture leaves out, in words; empty for nothing."""
        view = f"{VIEW_KM:,.0f} km".replace(",", " ")
        escaping = f"{self.escaping} escaping plane{'s' * (self.escaping != 1)} not drawn"
        cut = f"{self.cut} orbit{'s' * (self.cut != 1)} cut at {view}"
        return ", ".join([escaping] * bool(self.escaping) + [cut] * bool(self.cut))


def largest_ellipses(domain: ReachableDomain, samples: int = 241) -> Ellipses:
    """Of all reached planes at the lowest bound."""
    points = domain.points
    reached = points["status"] == "reached"
    rows = np.flatnonzero((points["perigee_bound_km"] == points["perigee_bound_km"].min()) & reached)
    closed = np.isfinite(points["apogee_km"][rows])
    escaping, rows = int((~closed).sum()), rows[closed]
    rows = rows[np.argsort(-points["apogee_km"][rows])]
    curves = [_curve([float(points[name][row]) for name in _ELEMENTS], samples) for row in rows]
    cut = sum(bool(np.isnan(curve).any()) for curve in curves)
    return Ellipses(curves, points["apogee_km"][rows], cut, escaping)


_ELEMENTS = ("a_km", "ecc", "inc_deg", "raan_deg", "argp_deg")


def _curve(elements: Sequence[float], samples: int) -> Array:
    """Of `_ELEMENTS`, in equal steps of eccentric anomaly, as dense at the apogee as at the perigee; of what lies within view
    if not all does."""
    a_km, ecc, inc_deg, raan_deg, argp_deg = elements
    inc, raan, argp = (float(np.deg2rad(angle)) for angle in (inc_deg, raan_deg, argp_deg))
    last = np.pi
    if a_km * (1.0 + ecc) > VIEW_KM:
        last = float(np.arccos(np.clip((1.0 - VIEW_KM / a_km) / ecc, -1.0, 1.0)))
    eccentric = np.linspace(-last, last, samples)
    r0, v0 = state_from_elements(Elements(1e3 * a_km, ecc, inc, raan, argp, 0.0))
    along, ahead = r0 / np.linalg.norm(r0), v0 / np.linalg.norm(v0)
    x, y = a_km * (np.cos(eccentric) - ecc), a_km * np.sqrt(1.0 - ecc**2) * np.sin(eccentric)
    curve = np.outer(x, along) + np.outer(y, ahead)
    return curve if last == np.pi else np.vstack([curve, np.full((1, 3), np.nan)])


def bound_words(domain: ReachableDomain, height_km: float) -> str:
    """What the scenario asks of the perigee at a bound: `perigee ≥ 100 km`."""
    sign = "≥" if domain.scenario.perigee.condition == "at_least" else "="
    return f"perigee {sign} {height_km:g} km"


def band_title(domain: ReachableDomain, orbits: Ellipses, *, gap: str = "\n") -> str:
    """Title of a picture of the orbits, with the bound they keep and what is left out."""
    lowest = float(domain.points["perigee_bound_km"].min())
    title = f"{domain.scenario.name}: largest orbits within reach, {bound_words(domain, lowest)}"
    return f"{title}{gap}({orbits.omitted})" if orbits.omitted else title
