"""Passive safety: how near to the target a chaser comes by itself, after every impulse and when one stops half-way.

About a circular target the answer holds for all time, of drifts that move by `STILL_M` a revolution or more; slower ones
count as closed, which is wrong by `STILL_M` after a revolution and by a metre after a thousand. A free drift repeats R and N
each revolution while T moves on by one step, so that of every phase the nearest revolution is known: least distance = min
over phases alone. Over phases and fractions of an impulse it is searched, and bounded from below by `safety_bound`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from math import inf, pi
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from orbsoc.orbit.array import Array
from orbsoc.orbit.relative import LinearMotion

from .claims import Claim, Kind
from .impulses import ImpulseProgramme
from .safety_bound import STILL_M, DriftFamily, Least, least_bound, unsafe_shares

PHASES = 1440
"""Of a revolution, at which distances are looked at before the least is refined."""
FRACTIONS = 101
"""Of an impulse, from 0 to 1, at which it may stop."""
REFINEMENTS = 4
"""Each narrows the phase by a factor of 10."""
UNSAFE_M = 1e-3
"""Nearer than the keep-out by more than this counts as unsafe: a plan may lie on it."""
WELLS, CUT_REFINEMENTS = 8, 5
"""Local minima of the fraction that are refined, and how often: each narrows the fraction by a factor of 10."""


@dataclass(frozen=True, slots=True, eq=False)
class Clearance:
    """Least distances from the target (B,), m, and when, s after the states that drift."""

    distance_m: Array
    at_s: Array


def drift_clearance(states: ArrayLike, mean_motion_rad_s: float, horizon_s: float = inf) -> Clearance:
    """How near free drifts about a circular target come, from states (B, 6) or (6,) on; for all time by default.

    >>> below = [-100.0, 0.0, 0.0, 0.0, 0.15, 0.0]  # on the slow way past, at the speed of a circular orbit
    >>> drift_clearance(below, 1e-3).distance_m.round(6)
    array([100.])
    """
    n, period = mean_motion_rad_s, 2.0 * pi / mean_motion_rad_s
    x, y, z, vx, vy, vz = np.atleast_2d(np.asarray(states, np.float64)).T[:, :, None]
    centre, along = 4.0 * x + 2.0 * vy / n, y - 2.0 * vx / n
    step = np.where(np.abs(3.0 * pi * centre) < STILL_M, 0.0, -3.0 * pi * centre)  # T by revolution

    def at_phases(angles: Array) -> tuple[Array, Array]:
        """Squared distances (B, K) at angles nt (B, K) of the nearest revolution, and its times."""
        s, c = np.sin(angles), np.cos(angles)
        radial = centre + (x - centre) * c + vx / n * s
        normal = z * c + vz / n * s
        first = along + step * angles / (2.0 * pi) + 2.0 * (vx / n * c - (x - centre) * s)
        with np.errstate(divide="ignore", invalid="ignore"):
            nearest = np.where(step != 0.0, -first / step, 0.0)
        last = np.floor(np.maximum((horizon_s - angles / n) / period, 0.0)) if horizon_s < inf else inf
        low = np.clip(np.floor(nearest), 0.0, last)
        high = np.clip(low + 1.0, 0.0, last)
        options = np.stack([first + low * step, first + high * step])
        which = np.abs(options[0]) <= np.abs(options[1])
        tangential = np.where(which, options[0], options[1])
        turns = np.where(which, low, high)
        return radial**2 + normal**2 + tangential**2, angles / n + turns * period

    end = 2.0 * pi if horizon_s >= period else n * horizon_s
    angles = np.broadcast_to(np.linspace(0.0, end, PHASES + 1), (len(x), PHASES + 1))
    squares, times = at_phases(angles)
    width = end / PHASES
    for _ in range(REFINEMENTS):
        best = squares.argmin(axis=1)[:, None]
        middle = np.take_along_axis(angles, best, axis=1)
        angles = np.clip(middle + width * np.linspace(-1.0, 1.0, 21), 0.0, end)
        squares, times = at_phases(angles)
        width /= 10.0
    best = squares.argmin(axis=1)[:, None]
    return Clearance(
        np.sqrt(np.take_along_axis(squares, best, axis=1)[:, 0]),
        np.take_along_axis(times, best, axis=1)[:, 0],
    )


def drift_least(state: Array, mean_motion_rad_s: float, horizon_s: float = inf) -> Least:
    """The same of one state (6,), with a bound below it."""
    found = drift_clearance(state, mean_motion_rad_s, horizon_s)
    known = Least(float(found.distance_m[0]), None, 0.0, float(found.at_s[0]))
    return least_bound(DriftFamily(state, np.zeros(3), mean_motion_rad_s, horizon_s), known)


def sampled_clearance(motion: LinearMotion, states: ArrayLike, at_s: float, times_s: ArrayLike) -> Clearance:
    """The same of any motion, at times_s (K,) at or after at_s, at which the states (B, 6) or (6,) are."""
    rows, times = np.atleast_2d(np.asarray(states, np.float64)), np.asarray(times_s, np.float64)
    matrices = np.array([motion.transition(float(t), at_s)[:3] for t in times])
    distances = np.linalg.norm(np.einsum("kij,bj->bki", matrices, rows), axis=2)
    best = distances.argmin(axis=1)
    return Clearance(distances[np.arange(len(rows)), best], times[best] - at_s)


@dataclass(frozen=True, slots=True, eq=False)
class CutBurn:
    """What follows when an impulse stops at a fraction of itself and none comes after it.

    The worst fraction, how near to the target its drift comes and how long after, and which share of the fractions, at
    most, comes nearer than the keep-out by more than `UNSAFE_M`. `half_m`: cut at one half; `completed_m`,
    `completed_after_s`: of the whole impulse; `missed_m`: of none of it. What a name with `at_least` tells is proved, by
    the linear motion; None about an eccentric target, where all is sampled.
    """

    number: int
    time_s: float
    fraction: float
    distance_m: float
    at_least_m: float | None
    after_s: float
    unsafe_share: float
    unsafe_share_at_least: float | None
    half_m: float
    completed_m: float
    completed_at_least_m: float | None
    completed_after_s: float
    missed_m: float
    by_fraction_m: Array = field(repr=False)
    """Least distances (FRACTIONS,) at fractions from 0 to 1."""

    def to_dict(self) -> dict[str, Any]:
        """A row of `audits` in plan.json."""
        return {name: getattr(self, name) for name in self.__dataclass_fields__ if name != "by_fraction_m"}


def nearest_claim(cuts: Sequence[CutBurn], how_long: str) -> Claim:
    """What is known of the drifts after burns, whole or cut, for a time in words."""
    found = [each for cut in cuts for each in (cut.at_least_m, cut.completed_at_least_m) if each is not None]
    class_ = f"drifts after any burn, cut anywhere or whole, {how_long}, by the linear model"
    if len(found) < 2 * len(cuts):
        words = f"nearest of those looked at: {min(cut.distance_m for cut in cuts):.3f} m"
        return Claim(
            Kind.SAMPLED, words, class_, f"{FRACTIONS} fractions, refined, at {PHASES} times of an orbit"
        )
    words = f"none comes nearer than {min(found):.3f} m"
    checked = (
        f"branch and bound over fraction and phase; below {1e3 * STILL_M:g} mm a revolution counts as closed"
    )
    return Claim(Kind.BOUND, words, class_, checked)


def states_after(
    programme: ImpulseProgramme, start: ArrayLike, motion: LinearMotion, start_s: float = 0.0
) -> Array:
    """States just after each impulse, (N, 6), from `start` (6,) at start_s."""
    state, at = np.asarray(start, np.float64), start_s
    found = []
    for t, dv in zip(programme.times_s, programme.dv_m_s, strict=True):
        state = motion.transition(float(t), at) @ state
        state[3:] += dv
        at = float(t)
        found.append(state)
    return np.array(found).reshape(-1, 6)


def audit_cut_burns(
    programme: ImpulseProgramme,
    start: ArrayLike,
    motion: LinearMotion,
    keep_out_m: float,
    *,
    mean_motion_rad_s: float,
    orbits: float = inf,
    circular: bool = True,
    start_s: float = 0.0,
) -> tuple[CutBurn, ...]:
    """Every impulse cut at every fraction: the engine stops inside it, or is out from there on.

    For all time about a circular target, or for some orbits; one orbit, sampled, about any other.
    """
    n = mean_motion_rad_s
    period = 2.0 * pi / n
    after = states_after(programme, start, motion, start_s)
    found = []
    for k, (t, dv) in enumerate(zip(programme.times_s.tolist(), programme.dv_m_s, strict=True)):
        before = after[k].copy()
        before[3:] -= dv

        def clearance(fractions: Array, t: float = t, before: Array = before, dv: Array = dv) -> Clearance:
            states = np.tile(before, (fractions.size, 1))
            states[:, 3:] += fractions[:, None] * dv
            if circular:
                return drift_clearance(states, n, orbits * period)
            span = period * min(orbits, 1.0)
            return sampled_clearance(motion, states, t, t + np.linspace(0.0, span, PHASES + 1))

        coarse = np.linspace(0.0, 1.0, FRACTIONS)
        first = clearance(coarse)
        fractions, distances, later = _refined(coarse, first, clearance)
        at, limit = int(distances.argmin()), keep_out_m - UNSAFE_M
        worst = Least(float(distances[at]), None, float(fractions[at]), float(later[at]))
        whole = Least(float(first.distance_m[-1]), None, 1.0, float(first.at_s[-1]))
        shares: tuple[float, float | None] = _share_below(fractions, distances, limit), None
        if circular:
            family = DriftFamily(before, dv, n, orbits * period)
            worst = least_bound(family, worst)
            whole = drift_least(after[k], n, orbits * period)
            safe = (worst.at_least_m or 0.0) >= limit
            shares = (0.0, 0.0) if safe else unsafe_shares(family, limit)
        found.append(
            CutBurn(
                number=k + 1,
                time_s=t,
                fraction=worst.fraction,
                distance_m=worst.distance_m,
                at_least_m=worst.at_least_m,
                after_s=worst.after_s,
                unsafe_share=shares[0],
                unsafe_share_at_least=shares[1],
                half_m=float(first.distance_m[FRACTIONS // 2]),
                completed_m=whole.distance_m,
                completed_at_least_m=whole.at_least_m,
                completed_after_s=whole.after_s,
                missed_m=float(first.distance_m[0]),
                by_fraction_m=first.distance_m,
            )
        )
    return tuple(found)


def _refined(
    fractions: Array, found: Clearance, clearance: Callable[[Array], Clearance]
) -> tuple[Array, Array, Array]:
    """Fractions, distances and times with those about the deepest local minima added, in order of the fraction."""
    distances = found.distance_m
    padded = np.concatenate([[inf], distances, [inf]])
    wells = np.flatnonzero((distances <= padded[:-2]) & (distances <= padded[2:]))
    pieces = [np.stack([fractions, distances, found.at_s])]
    for k in wells[np.argsort(distances[wells])][:WELLS].tolist():
        middle, width = float(fractions[k]), 1.0 / (FRACTIONS - 1)
        for _ in range(CUT_REFINEMENTS):
            fine = np.unique(np.clip(middle + width * np.linspace(-1.0, 1.0, 21), 0.0, 1.0))
            there = clearance(fine)
            pieces.append(np.stack([fine, there.distance_m, there.at_s]))
            middle, width = float(fine[there.distance_m.argmin()]), width / 10.0
    rows = np.hstack(pieces)
    rows = rows[:, np.argsort(rows[0], kind="stable")]
    return rows[0], rows[1], rows[2]


def _share_below(fractions: Array, distances: Array, limit: float) -> float:
    """Of the fractions from 0 to 1, the share whose distance is below a limit, straight between neighbours."""
    low, high = np.minimum(distances[:-1], distances[1:]), np.maximum(distances[:-1], distances[1:])
    rise = np.where(high > low, high - low, 1.0)
    share = np.where(high <= limit, high < limit, np.clip((limit - low) / rise, 0.0, 1.0))
    share = np.where((high == low) & (low < limit), 1.0, share)
    return float(share @ np.diff(fractions))
