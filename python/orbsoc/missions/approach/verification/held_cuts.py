"""Thrust that is held and cut at any instant, about a circular target: how near the drift after it comes, with a proof.

A drift is told by when the thrust was cut and by how long ago. Over a rectangle of both its places are within the bends in either
direction of a bilinear patch between the four corners, and no point of that is nearer than the plane through its nearest corner, across
the direction of the patch. Rectangles that may hold less than what is known are cut in pieces, until the nearest is known to `WITHIN_M`.
In the direction of the cut the bend is that of the flight while thrust is held, carried on: its second derivative is the speed of a drift.
Distances are ‖p / semi-axes‖ times the least semi-axis: of a sphere metres from the target.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from orbsoc.guidance.impulses import ImpulseProgramme
from orbsoc.guidance.safety import UNSAFE_M, CutBurn
from orbsoc.orbit.array import Array, Index
from orbsoc.orbit.relative import ClohessyWiltshire

from ..model.approach import Approach
from .cuts import FRACTIONS, WITHIN_M
from .linear import Arc, largest_acceleration, largest_speed, pushed_rate

CUTS, CUT_PIECES, LAPSE_PIECES = 32, 4, 2
"""Spans of the cut at first, and into how many of each direction a rectangle is cut."""
ROUNDS, MOST = 10, 400_000
"""Of cutting, and rectangles that are looked at in one of them: then what is known of the nearest is what it is."""
LOOKED_AT = 2
"""Of the common instants each second is a sample by fraction."""


@dataclass(frozen=True, slots=True)
class _Nearest:
    distance_m: float
    at_least_m: float
    cut_s: float
    after_s: float


def audit_held(
    approach: Approach, programme: ImpulseProgramme, flown: tuple[Arc, ...], which: Index
) -> tuple[CutBurn, ...]:
    """Of the arcs `which` (S,), how near the drift comes, after thrust that was cut, or not, for the scenario's orbits after it."""
    return tuple(_audited(approach, programme, flown[k], k) for k in which.tolist())


def _audited(approach: Approach, programme: ImpulseProgramme, arc: Arc, k: int) -> CutBurn:
    start, whole = float(arc.times_s[0]), float(arc.times_s[-1] - arc.times_s[0])
    thrust = _Thrust(approach, arc.states[0], programme.dv_m_s[k] / whole)
    cut, completed = (_nearest(thrust, first, whole, approach.horizon_s) for first in (0.0, whole))
    lapses = approach.instants(0.0, approach.horizon_s, LOOKED_AT)
    fractions = np.linspace(0.0, 1.0, FRACTIONS)
    every, each = (part.ravel() for part in np.meshgrid(fractions * whole, lapses, indexing="ij"))
    away = np.linalg.norm(thrust.places(every, each), axis=1).reshape(FRACTIONS, -1).min(axis=1)
    least = float(approach.axes_m.min())
    safe = cut.at_least_m >= least - UNSAFE_M
    return CutBurn(
        number=k + 1, time_s=start, fraction=cut.cut_s / whole, distance_m=cut.distance_m,
        at_least_m=cut.at_least_m, after_s=cut.after_s, unsafe_share=float((away < least - UNSAFE_M).mean()),
        unsafe_share_at_least=0.0 if safe else None, half_m=float(away[FRACTIONS // 2]),
        completed_m=completed.distance_m, completed_at_least_m=completed.at_least_m,
        completed_after_s=completed.after_s, missed_m=float(away[0]), by_fraction_m=away,
    )  # fmt: skip


class _Thrust:
    """The flight from a state (6,) under an acceleration (3,), and drifts after it."""

    def __init__(self, approach: Approach, state: Array, push: Array) -> None:
        assert isinstance(approach.motion, ClohessyWiltshire)  # the scenario checks it
        self.approach, self.motion, self.state, self.push = approach, approach.motion, state, push
        rate = pushed_rate(approach.mean_motion_rad_s, state, push)
        self.cut_bend_m_s2 = largest_speed(approach.mean_motion_rad_s, rate)
        """Above the second derivative of a drift's place by when the thrust was cut."""

    def states(self, cuts_s: Array) -> Array:
        """Where thrust is cut at times (S,), (S, 6)."""
        found = self.motion.transitions(cuts_s) @ self.state + self.motion.held(cuts_s) @ self.push
        return np.asarray(found)

    def lapse_bend_m_s2(self, states: Array) -> float:
        """Above the acceleration of drifts from states (S, 6)."""
        n = self.approach.mean_motion_rad_s
        return max(largest_acceleration(n, state) for state in states)

    def places(self, cuts_s: Array, lapses_s: Array) -> Array:
        """Scaled places (S, 3) so long after cuts (S,)."""
        scale = self.approach.axes_m.min() / self.approach.axes_m
        cuts, which = np.unique(cuts_s, return_inverse=True)
        lapses, when = np.unique(lapses_s, return_inverse=True)
        states, to = self.states(cuts), self.motion.transitions(lapses)[:, :3]
        return np.asarray(np.einsum("sij,sj->si", to[when], states[which]) * scale)


def _nearest(thrust: _Thrust, first_s: float, last_s: float, horizon_s: float) -> _Nearest:
    """Of drifts after thrust that is cut between two times, for a time after it."""
    pieces = (CUT_PIECES if last_s > first_s else 1, LAPSE_PIECES)
    cuts = np.linspace(first_s, last_s, CUTS + 1) if last_s > first_s else np.full(2, last_s)
    lapses = thrust.approach.instants(0.0, horizon_s)
    rectangles = _all(np.stack([cuts[:-1], cuts[1:]], axis=1), np.stack([lapses[:-1], lapses[1:]], axis=1))
    lapse_bend = thrust.lapse_bend_m_s2(thrust.states(cuts))
    found, left = (np.inf, 0.0, 0.0), np.inf
    for _ in range(ROUNDS):
        corners = np.stack(
            [thrust.places(rectangles[:, 0, a], rectangles[:, 1, b]) for a in (0, 1) for b in (0, 1)], axis=1
        )
        away = np.linalg.norm(corners, axis=2)
        best, at = np.unravel_index(int(away.argmin()), away.shape)
        if away[best, at] < found[0]:
            cut, lapse = rectangles[best, 0, at // 2], rectangles[best, 1, at % 2]
            found = float(away[best, at]), float(cut), float(lapse)
        middle = corners.mean(axis=1)
        along = middle / np.maximum(np.linalg.norm(middle, axis=1, keepdims=True), 1e-9)
        spans = np.diff(rectangles, axis=2)[:, :, 0]
        bent = (spans[:, 0] ** 2 * thrust.cut_bend_m_s2 + spans[:, 1] ** 2 * lapse_bend) / 8.0
        bound = np.maximum(np.einsum("sci,si->sc", corners, along).min(axis=1), 0.0) - bent
        open_ = bound < found[0] - WITHIN_M
        if not open_.any():
            return _Nearest(found[0], found[0] - WITHIN_M, *found[1:])
        left = float(bound[open_].min())
        if open_.sum() * pieces[0] * pieces[1] > MOST:
            break
        rectangles = _cut(rectangles[open_], pieces)
    return _Nearest(found[0], left, *found[1:])


def _all(cuts: Array, lapses: Array) -> Array:
    """Every span of the cut with every span of the time since, (S, 2, 2)."""
    a, b = np.meshgrid(np.arange(len(cuts)), np.arange(len(lapses)), indexing="ij")
    return np.stack([cuts[a.ravel()], lapses[b.ravel()]], axis=1)


def _cut(rectangles: Array, pieces: tuple[int, int]) -> Array:
    """Each in pieces of both directions."""
    parts = []
    for d, count in enumerate(pieces):
        low, high = rectangles[:, d, 0], rectangles[:, d, 1]
        edges = low[:, None] + np.linspace(0.0, 1.0, count + 1) * (high - low)[:, None]
        parts.append(np.stack([edges[:, :-1], edges[:, 1:]], axis=2))
    a, b = np.meshgrid(np.arange(pieces[0]), np.arange(pieces[1]), indexing="ij")
    return np.stack([parts[0][:, a.ravel()], parts[1][:, b.ravel()]], axis=2).reshape(-1, 2, 2)
