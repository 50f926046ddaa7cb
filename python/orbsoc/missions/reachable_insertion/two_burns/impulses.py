"""Two impulses between two orbits: all transfers of a grid at once, and the cheapest of every neighbourhood, refined.

Between positions r₁ and r₂ every semi-latus rectum p names one transfer each way round, with v₁ = (r₂ − f r₁)/g,
v₂ = (ġ r₂ − r₁)/g, f = 1 − r₂(1 − cos θ)/p, ġ = 1 − r₁(1 − cos θ)/p, g = r₁ r₂ sin θ/√p: no equation is solved (Battin 1999,
7.1). A grid of p is some 5 % apart, 200 m/s of a low orbit: the best p of every pair, and then the times of the best pairs, are
sought between its points. Units where μ = 1.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from orbsoc.orbit.array import Array, Flags

from ..targets.target_orbit import TargetOrbit

Orbit = Callable[[Array], Array]
"""States (..., 6) at times (...)."""


@dataclass(frozen=True, slots=True, eq=False)
class Fineness:
    """Of a grid: points on the target orbit, and semi-latera recta in units of that of least energy, r₁ r₂ (1 − cos θ)/c."""

    arrivals: int
    shapes: Array


FINE = Fineness(90, np.exp(np.linspace(-1.2, 1.2, 33)))
COARSE = Fineness(36, np.exp(np.linspace(-1.0, 1.0, 15)))
BETWEEN = np.linspace(-0.75, 0.75, 7)
"""Of the step to the neighbours, at which p is sought between points of the grid."""
ROUNDS, CLOSER = 16, 0.5
"""In which the best pairs are moved, and the factor on the steps of one that has no better neighbour."""
SAME = 0.02
"""Of the cost, and canonical time, within which two pairs are one."""
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


def anomalies_of(target: TargetOrbit, count: int) -> Array:
    """True anomalies (A,) all around an orbit; of a hyperbola as far as it is of use."""
    widest = np.pi
    if target.eccentricity >= 1.0:
        farthest = (target.momentum**2 / FARTHEST - 1.0) / target.eccentricity
        widest = min(WIDEST * np.arccos(-1.0 / target.eccentricity), np.arccos(np.clip(farthest, -1.0, 1.0)))
    return np.linspace(-widest, widest, count, endpoint=False)


def points_on(target: TargetOrbit, anomaly: Array) -> Array:
    """States (..., 6) at true anomalies."""
    cosine, sine = np.cos(anomaly)[..., None], np.sin(anomaly)[..., None]
    outwards = cosine * target.perigee + sine * target.ahead
    radius = target.momentum**2 / (1.0 + target.eccentricity * cosine)
    velocity = np.cross(target.normal, target.eccentricity * target.perigee + outwards) / target.momentum
    return np.concatenate([radius * outwards, velocity], axis=-1)


@dataclass(frozen=True, slots=True, eq=False)
class Rules:
    """What a transfer has to keep to: its longest flight and least radius; `allowed` says which first impulses may be given at
    which departures."""

    longest: float
    lowest: float
    allowed: Callable[[Array, Array], Flags]


def cheapest(
    departures: Array, first_orbit: Orbit, target: TargetOrbit, rules: Rules, *, fineness: Fineness = FINE
) -> list[Impulses]:
    """The cheapest transfer of every local minimum over departure and arrival, cheapest first.

    `departures` (D,) are the times of a grid on the first orbit.
    """
    states = first_orbit(departures)
    anomalies = anomalies_of(target, fineness.arrivals)
    first = states[:, None, None, None, :]
    last = points_on(target, anomalies)[None, :, None, None, :]
    way = np.array([1.0, -1.0])[:, None]
    when = departures[:, None, None, None]
    table = _transfers(when, first, last, way, fineness.shapes, rules).cost.reshape(
        len(states), len(anomalies), -1
    )
    best = table.argmin(axis=2)
    ways, kinds = np.divmod(best, len(fineness.shapes))
    finer = np.log(fineness.shapes[1] / fineness.shapes[0])
    shapes = fineness.shapes[kinds]
    for step in (finer, finer / 4.0):
        tried = shapes[..., None, None] * np.exp(step * BETWEEN)
        found = _transfers(when, first, last, way[ways][..., None], tried, rules).cost[..., 0, :]
        shapes = np.take_along_axis(tried[..., 0, :], found.argmin(axis=2)[..., None], axis=2)[..., 0]
    costs = found.min(axis=2)
    chosen = np.array(_minima(costs, closed=target.eccentricity < 1.0), dtype=int).reshape(-1, 2).T
    at = np.stack([departures[chosen[0]], anomalies[chosen[1]], np.log(shapes[*chosen])], axis=1)
    steps = np.array([np.ptp(departures) / (len(departures) - 1), anomalies[1] - anomalies[0], finer])
    return _refined(departures, first_orbit, target, rules, at, way[:, 0][ways[*chosen]], 0.5 * steps)


def _refined(
    departures: Array,
    first_orbit: Orbit,
    target: TargetOrbit,
    rules: Rules,
    at: Array,
    way: Array,
    steps: Array,
) -> list[Impulses]:
    """Pairs at [departure, anomaly, ln p] (M, 3), each moved to its cheapest neighbour by steps that shrink; each minimum once."""
    aside = np.stack(np.meshgrid(*([[-1.0, 0.0, 1.0]] * 3), indexing="ij"), axis=-1).reshape(-1, 3)
    width = np.ones(len(at))

    def transfers(points: Array) -> _Transfers:
        when = np.clip(points[..., 0], departures[0], departures[-1])
        ways = np.broadcast_to(way[:, None], when.shape)
        return _transfers(
            when, first_orbit(when), points_on(target, points[..., 1]), ways, np.exp(points[..., 2]), rules
        )

    for _ in range(ROUNDS):
        tried = at[:, None] + aside * width[:, None, None] * steps
        tried[..., 0] = np.clip(tried[..., 0], departures[0], departures[-1])
        best = transfers(tried).cost.argmin(axis=1)
        moved = np.any(aside[best] != 0.0, axis=1)
        at = np.where(moved[:, None], tried[np.arange(len(at)), best], at)
        width = np.where(moved, width, CLOSER * width)
    found = transfers(at[:, None])
    pairs = [
        Impulses(float(at[k, 0]), float(found.flight[k, 0]), found.velocities[k, 0], float(found.cost[k, 0]))
        for k in np.argsort(found.cost[:, 0], kind="stable")
        if np.isfinite(found.cost[k, 0])
    ]
    apart: list[Impulses] = []
    for pair in pairs:
        if not any(_same(pair, each) for each in apart):
            apart.append(pair)
    return apart


def _same(one: Impulses, other: Impulses) -> bool:
    near = abs(one.flight - other.flight) + abs(one.departure - other.departure) < SAME * one.flight
    apart = float(np.linalg.norm(one.velocities - other.velocities))
    return near and apart < SAME * one.cost


@dataclass(frozen=True, slots=True, eq=False)
class _Transfers:
    """Costs (...), infinite where a rule is not kept; times of flight (...), and both impulses (..., 2, 3)."""

    cost: Array
    flight: Array
    velocities: Array


def _transfers(when: Array, first: Array, last: Array, way: Array, shape: Array, rules: Rules) -> _Transfers:
    """Transfers from states `first` (..., 6) to `last` (..., 6), `way` ±1 round, with p in units of that of least energy; all
    broadcast."""
    r1, r2 = np.linalg.norm(first[..., :3], axis=-1), np.linalg.norm(last[..., :3], axis=-1)
    u1, u2 = first[..., :3] / r1[..., None], last[..., :3] / r2[..., None]
    cos = np.clip(np.einsum("...i,...i->...", u1, u2), -1.0, 1.0)
    sine = np.linalg.norm(np.cross(u1, u2), axis=-1)
    sin = way * np.maximum(sine, STRAIGHT)
    chord = np.sqrt(r1**2 + r2**2 - 2.0 * r1 * r2 * cos)
    p = np.maximum(r1 * r2 * (1.0 - cos) / np.maximum(chord, 1e-9) * shape, 1e-6)
    f, g_rate = 1.0 - r2 * (1.0 - cos) / p, 1.0 - r1 * (1.0 - cos) / p
    g = r1 * r2 * sin / np.sqrt(p)
    v1 = (last[..., :3] - f[..., None] * first[..., :3]) / g[..., None]
    v2 = (g_rate[..., None] * last[..., :3] - first[..., :3]) / g[..., None]
    given = np.stack([v1 - first[..., 3:], last[..., 3:] - v2], axis=-2)
    sizes = np.linalg.norm(given, axis=-1)
    radial = np.einsum("...i,...i->...", v1, np.broadcast_to(first[..., :3], v1.shape)) / r1
    flight, lowest = _flight(p, r1, radial, np.arctan2(sin, cos) % (2.0 * np.pi), r2)
    possible = (flight > 0.0) & (flight <= rules.longest) & (lowest >= rules.lowest) & (sine >= STRAIGHT)
    possible &= rules.allowed(when, sizes[..., 0])
    return _Transfers(np.where(possible, sizes.sum(axis=-1), np.inf), flight, given)


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
