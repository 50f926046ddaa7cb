"""Burns cut anywhere, about any target and for any keep-out, where the branch and bound of circular motion does not apply.

At a time the places of all fractions of a burn are a straight piece, whose nearest point is known. Between two times no place is
farther from one of its own at these than half the chord and what it bends. Intervals that may hold less than what is known are cut in
pieces, until the nearest is known to `WITHIN_M`. About an eccentric target the bend is told from differences, and nothing is bounded.
Distances are ‖p / semi-axes‖ times the least semi-axis: of a sphere metres from the target.
"""

from __future__ import annotations

import numpy as np

from orbsoc.guidance.impulses import ImpulseProgramme
from orbsoc.guidance.safety import CutBurn, states_after
from orbsoc.orbit.array import Array

from ..model.approach import Approach
from .linear import bends

PIECES, ROUNDS = 8, 8
WITHIN_M = 2e-3
FRACTIONS = 101


def audit_cuts(approach: Approach, programme: ImpulseProgramme, horizon_s: float) -> tuple[CutBurn, ...]:
    """Of every impulse, how near its drift comes, whole or cut, for a time after it."""
    after = states_after(programme, approach.start, approach.motion)
    return tuple(
        _audit(approach, k, float(t), state, dv, horizon_s)
        for k, (t, state, dv) in enumerate(zip(programme.times_s, after, programme.dv_m_s, strict=True))
    )


def _audit(approach: Approach, k: int, t_s: float, state: Array, dv: Array, horizon_s: float) -> CutBurn:
    pair = np.stack([state, state], axis=1)
    pair[3:, 0] -= dv
    times = approach.instants(t_s, t_s + horizon_s)
    places = _places(approach, t_s, times, pair)
    fractions = np.linspace(0.0, 1.0, FRACTIONS)
    each = places[:, :, :1] + (places[:, :, 1:] - places[:, :, :1]) * fractions
    by_fraction = np.linalg.norm(each, axis=1).min(axis=0)
    cut, whole = (_least(approach, t_s, times, each) for each in (pair, pair[:, [1, 1]]))
    return CutBurn(
        number=k + 1, time_s=t_s, fraction=cut[2], distance_m=cut[0], at_least_m=cut[1], after_s=cut[3],
        unsafe_share=float((by_fraction < approach.axes_m.min()).mean()), unsafe_share_at_least=None,
        half_m=float(by_fraction[FRACTIONS // 2]), completed_m=whole[0], completed_at_least_m=whole[1],
        completed_after_s=whole[3], missed_m=float(by_fraction[0]), by_fraction_m=by_fraction,
    )  # fmt: skip


def _places(approach: Approach, t_s: float, times_s: Array, pair: Array) -> Array:
    """Scaled places (M, 3, 2) of a burn that is not flown and flown, at times."""
    motion, scale = approach.motion, approach.axes_m.min() / approach.axes_m
    rows = np.array([motion.transition(t, t_s)[:3] @ pair for t in times_s.tolist()])
    return np.asarray(rows * scale[:, None])


def _least(
    approach: Approach, t_s: float, times_s: Array, pair: Array
) -> tuple[float, float | None, float, float]:
    """The least distance, what it is at least, its fraction, and when, after the burn."""
    times = np.stack([times_s[:-1], times_s[1:]], axis=1)
    states = np.array([approach.motion.transition(t, t_s) @ pair for t in times_s.tolist()])
    bent = max(bends(approach, times_s, states[..., k])[0] for k in (0, 1))
    known, left, found = approach.circular, np.inf, (np.inf, 0.0, 0.0)
    for _ in range(ROUNDS):
        grid, where = np.unique(times, return_inverse=True)
        places = _places(approach, t_s, grid, pair)
        first, along = places[..., 0], places[..., 1] - places[..., 0]
        squares = np.maximum((along**2).sum(axis=1), 1e-30)
        fractions = np.clip(-(first * along).sum(axis=1) / squares, 0.0, 1.0)
        away = np.linalg.norm(first + fractions[:, None] * along, axis=1)
        best = int(away.argmin())
        if away[best] < found[0]:
            found = float(away[best]), float(fractions[best]), float(grid[best])
        ends = where.reshape(times.shape)
        moved = np.linalg.norm(places[ends[:, 1]] - places[ends[:, 0]], axis=1).max(axis=1)
        bound = away[ends].min(axis=1) - 0.5 * moved - bent
        open_ = bound < found[0] - WITHIN_M
        if not open_.any():
            break
        left = float(bound[open_].min())
        steps = np.linspace(0.0, 1.0, PIECES + 1)
        bent /= PIECES**2
        fine = times[open_, :1] + steps * np.diff(times[open_], axis=1)
        times = np.stack([fine[:, :-1].ravel(), fine[:, 1:].ravel()], axis=1)
    else:
        return found[0], left if known else None, found[1], found[2] - t_s
    return found[0], found[0] - WITHIN_M if known else None, found[1], found[2] - t_s
