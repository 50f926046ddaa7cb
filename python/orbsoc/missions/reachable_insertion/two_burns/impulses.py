"""Two impulses between two orbits: all transfers of a grid at once, and the cheapest of every neighbourhood.

Between positions r₁ and r₂ every semi-latus rectum p names one transfer each way round, with v₁ = (r₂ − f r₁)/g,
v₂ = (ġ r₂ − r₁)/g, f = 1 − r₂(1 − cos θ)/p, ġ = 1 − r₁(1 − cos θ)/p, g = r₁ r₂ sin θ/√p: no equation is solved (Battin 1999,
7.1). Units where μ = 1.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..targets.target_orbit import TargetOrbit

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Fineness:
    """Of a grid: points on the target orbit, and semi-latera recta in units of that of least energy, r₁ r₂ (1 − cos θ)/c."""

    arrivals: int
    shapes: Array


FINE = Fineness(90, np.exp(np.linspace(-1.2, 1.2, 33)))
COARSE = Fineness(36, np.exp(np.linspace(-1.0, 1.0, 15)))
WIDEST = 0.9
"""Of a hyperbola's asymptotic anomaly, up to which it is arrived at, and only up to `FARTHEST`."""
FARTHEST = 60.0
"""Canonical radius."""
STRAIGHT = 2e-3
"""|sin θ| below which the two positions do not span a plane."""


@dataclass(frozen=True, slots=True, eq=False)
class Impulses:
    """Two impulses (2, 3), canonical: when the first is given, how long the transfer takes, and what both cost."""

    departure: float
    flight: float
    velocities: Array
    cost: float


def points_on(target: TargetOrbit, count: int) -> Array:
    """States (A, 6) all around an orbit; of a hyperbola as far as it is of use."""
    widest = np.pi
    if target.eccentricity >= 1.0:
        farthest = (target.momentum**2 / FARTHEST - 1.0) / target.eccentricity
        widest = min(WIDEST * np.arccos(-1.0 / target.eccentricity), np.arccos(np.clip(farthest, -1.0, 1.0)))
    anomaly = np.linspace(-widest, widest, count, endpoint=False)
    outwards = np.outer(np.cos(anomaly), target.perigee) + np.outer(np.sin(anomaly), target.ahead)
    radius = target.momentum**2 / (1.0 + target.eccentricity * np.cos(anomaly))
    velocity = np.cross(target.normal, target.eccentricity * target.perigee + outwards) / target.momentum
    return np.hstack([radius[:, None] * outwards, velocity])


def cheapest(
    departures: Array,
    states: Array,
    target: TargetOrbit,
    longest: float,
    allowed: Callable[[Array, Array], NDArray[np.bool_]],
    *,
    fineness: Fineness = FINE,
) -> list[Impulses]:
    """The cheapest transfer of every local minimum over departure and arrival, cheapest first.

    `departures` (D,) are the times of `states` (D, 6) on the first orbit; no transfer takes more than `longest`, nor passes
    below the ground. `allowed` says which first impulses may be given at which departures.
    """
    arrivals = points_on(target, fineness.arrivals)
    first, last = states[:, None, None, None, :], arrivals[None, :, None, None, :]
    r1, r2 = np.linalg.norm(states[:, :3], axis=1), np.linalg.norm(arrivals[:, :3], axis=1)
    u1, u2 = states[:, :3] / r1[:, None], arrivals[:, :3] / r2[:, None]
    cosine = np.clip(u1 @ u2.T, -1.0, 1.0)
    sine = np.linalg.norm(np.cross(u1[:, None], u2[None]), axis=2)
    r1, r2 = r1[:, None, None, None], r2[None, :, None, None]
    way = np.array([1.0, -1.0])[None, None, :, None]
    cos, sin = cosine[:, :, None, None], way * np.maximum(sine, STRAIGHT)[:, :, None, None]
    chord = np.sqrt(r1**2 + r2**2 - 2.0 * r1 * r2 * cos)
    p = np.maximum(r1 * r2 * (1.0 - cos) / np.maximum(chord, 1e-9) * fineness.shapes, 1e-6)
    f, g_rate = 1.0 - r2 * (1.0 - cos) / p, 1.0 - r1 * (1.0 - cos) / p
    g = r1 * r2 * sin / np.sqrt(p)
    v1 = (last[..., :3] - f[..., None] * first[..., :3]) / g[..., None]
    v2 = (g_rate[..., None] * last[..., :3] - first[..., :3]) / g[..., None]
    dv1, dv2 = v1 - first[..., 3:], last[..., 3:] - v2
    first_cost = np.linalg.norm(dv1, axis=-1)
    cost = first_cost + np.linalg.norm(dv2, axis=-1)
    radial = np.einsum("...i,...i->...", v1, np.broadcast_to(first[..., :3], v1.shape)) / r1
    turn = np.arctan2(sin, cos) % (2.0 * np.pi)
    flight, lowest = _flight(p, r1, radial, turn, r2)
    possible = (flight > 0.0) & (flight <= longest) & (lowest >= 1.0)
    possible &= allowed(departures[:, None, None, None], first_cost)
    cost = np.where(possible, cost, np.inf)
    cost[np.broadcast_to((sine < STRAIGHT)[:, :, None, None], cost.shape)] = np.inf
    count = cost.shape[2] * cost.shape[3]
    flat = cost.reshape(len(states), len(arrivals), count)
    best = flat.argmin(axis=2)
    table = np.take_along_axis(flat, best[..., None], axis=2)[..., 0]
    found = []
    for d, a in _minima(table, closed=target.eccentricity < 1.0):
        w, s = divmod(int(best[d, a]), cost.shape[3])
        at = (d, a, w, s)
        found.append(
            Impulses(float(departures[d]), float(flight[at]), np.array([dv1[at], dv2[at]]), float(cost[at]))
        )
    return sorted(found, key=lambda each: each.cost)


def _flight(p: Array, r1: Array, radial: Array, turn: Array, r2: Array) -> tuple[Array, Array]:
    """Times of flight, NaN where the transfer never arrives, and the lowest radius on the way."""
    along, across = p / r1 - 1.0, np.sqrt(p) * radial
    ecc = np.hypot(along, across)
    start = np.arctan2(across, along)
    end = start + turn
    energy = (1.0 - ecc**2) / p  # 1/a
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        low, high = np.sqrt(np.abs(1.0 - ecc)), np.sqrt(1.0 + ecc)
        ellipse = ecc < 1.0
        mean = [ecc, ecc]
        for k, nu in enumerate((start, end)):
            half = 0.5 * nu
            eccentric = 2.0 * np.arctan2(low * np.sin(half), high * np.cos(half))
            eccentric = eccentric + 2.0 * np.pi * np.round((nu - eccentric) / (2.0 * np.pi))
            closed = eccentric - ecc * np.sin(eccentric)
            ratio = low / high * np.tan(half)
            opened = 2.0 * np.arctanh(np.clip(ratio, -1.0, 1.0))
            escaping = ecc * np.sinh(np.clip(opened, -50.0, 50.0)) - opened
            mean[k] = np.where(ellipse, closed, escaping)
        time = (mean[1] - mean[0]) / np.abs(energy) ** 1.5
        beyond = ~ellipse & ((end > np.arccos(-1.0 / ecc)) | (start < -np.arccos(-1.0 / ecc)))
    time = np.where(beyond | ~np.isfinite(time), np.nan, time)
    through_perigee = (start < 0.0) & (end > 0.0) | (end > 2.0 * np.pi)
    return time, np.where(through_perigee, p / (1.0 + ecc), np.minimum(r1, r2))


def _minima(table: Array, *, closed: bool) -> list[tuple[int, int]]:
    """Where no neighbour in either direction is lower; arrivals of a closed orbit have no ends."""
    sides = (table[:, -1:], table[:, :1]) if closed else (np.full((len(table), 1), np.inf),) * 2
    padded = np.pad(np.hstack([sides[0], table, sides[1]]), ((1, 1), (0, 0)), constant_values=np.inf)
    rows, columns = table.shape
    lowest = np.isfinite(table)
    for i in (0, 1, 2):
        for j in (0, 1, 2):
            if (i, j) != (1, 1):
                lowest &= table <= padded[i : i + rows, j : j + columns]
    return [(int(i), int(j)) for i, j in np.argwhere(lowest)]
