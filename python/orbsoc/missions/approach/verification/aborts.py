"""Aborts: at every instant, whether the drift is safe by itself, and the smallest impulse that makes it so.

A drift is safe if it stays off the target's body, and, once it is outside the keep-out, stays outside for the scenario's orbits.
Inside the corridor it begins inside. The impulse lies in the orbital plane: directions and sizes of a grid, the size then
looked at more closely; what is told has been judged on chords of a fine drift with their bends.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from orbsoc.orbit.array import Array

from ..model.approach import AN_ORBIT, Approach
from .linear import LIMIT_M, Arc, bends, chord_lengths

DIRECTIONS = 24
SIZES = 12
STEPS = 6
"""From one size to the next, that are looked at once a size will do."""
EACH = 2
"""One of so many of the common instants ends a chord on which a drift is judged."""
COARSE = 6
"""Of these, one of so many is looked at for each impulse of the grid, from the first quarter of an orbit on."""


@dataclass(frozen=True, slots=True, eq=False)
class Abort:
    """At an instant: the state (6,), by how much the drift is safe by itself, m, the impulse (3,) that makes it safe, zero
    where none is needed and None where none was found, and by how much it is then."""

    time_s: float
    state: Array
    drift_margin_m: float
    dv_m_s: Array | None
    margin_m: float

    @property
    def safe(self) -> bool:
        """Without an impulse."""
        return self.drift_margin_m >= -LIMIT_M

    @property
    def size_m_s(self) -> float:
        return float("nan") if self.dv_m_s is None else float(np.linalg.norm(self.dv_m_s))

    def to_dict(self) -> dict[str, Any]:
        """A row of `aborts` in plan.json."""
        return {
            "time_s": self.time_s,
            "safe_by_itself": self.safe,
            "drift_margin_m": self.drift_margin_m,
            "dv_m_s": None if self.dv_m_s is None else self.dv_m_s.tolist(),
            "margin_m": self.margin_m if self.dv_m_s is not None else None,
        }


def aborts(approach: Approach, flown: tuple[Arc, ...]) -> tuple[Abort, ...]:
    """At every impulse, and every `abort_every_s` between."""
    judge, found = Judge(approach), []
    for arc in flown:
        count = max(
            1, int(np.ceil((arc.times_s[-1] - arc.times_s[0]) / approach.scenario.safety.abort_every_s))
        )
        for k in np.linspace(0, len(arc.times_s) - 1, count, endpoint=False).astype(int).tolist():
            found.append(judge.abort(float(arc.times_s[k]), arc.states[k]))
    return tuple(found)


def kicked(state: Array, dv: Array) -> Array:
    """A state (6,) after an impulse (3,)."""
    return np.concatenate([state[:3], state[3:] + dv])


class Judge:
    """Says of drifts of one approach by how much they are safe; keeps the transition matrices."""

    def __init__(self, approach: Approach) -> None:
        self.approach = approach
        horizon = approach.horizon_s
        self.horizon_s = horizon if 0.0 < horizon < np.inf else approach.period_s
        """Without one, or for all time: an orbit."""
        end = self.horizon_s + (0.0 if approach.circular else approach.duration_s)
        self._times = approach.instants(0.0, end, EACH)
        """About a circular target since an instant, otherwise since the start."""
        self._table = np.array([approach.motion.transition(float(t), 0.0) for t in self._times])

    def _transitions(self, t_s: float) -> tuple[Array, Array]:
        """Times (M,) since an instant, and from the state then to those after them, (M, 6, 6)."""
        if self.approach.circular:
            return self._times, self._table
        first, last = np.searchsorted(self._times, [t_s + 1e-6, t_s + self.horizon_s]).tolist()
        rows = self._table[first : last + 1] @ self.approach.motion.transition(0.0, t_s)
        return np.append(0.0, self._times[first : last + 1] - t_s), np.concatenate([np.eye(6)[None], rows])

    def judged(self, t_s: float, state: Array) -> float:
        """Below by how much the drift from a state (6,) at a time is safe, m, on chords with their bends."""
        approach, (times, transitions) = self.approach, self._transitions(t_s)
        states = transitions @ state
        bend, place = bends(approach, times, states)[0], states[:, :3]
        body = float(chord_lengths(place).min()) - approach.scenario.keep_out.body_m
        sizes, ends = chord_lengths(place / approach.axes_m), approach.size(place)
        out = np.flatnonzero(ends >= 1.0)
        if not out.size:
            return float(approach.axes_m.min() * (ends[-1] - 1.0))
        least = float(sizes[out[0] :].min(initial=np.inf))
        return min(body, float(approach.axes_m.min() * (least - 1.0))) - bend

    def abort(self, t_s: float, state: Array) -> Abort:
        """Of an instant."""
        here = self.judged(t_s, state)
        if here >= -LIMIT_M:
            return Abort(t_s, state, here, np.zeros(3), here)
        transitions = self._transitions(t_s)[1][:, :3]
        early = AN_ORBIT // EACH // 4
        transitions = np.concatenate([transitions[:early], transitions[early::COARSE]])
        most = self.approach.scenario.safety.abort_m_s
        angles = 2.0 * np.pi * np.arange(DIRECTIONS) / DIRECTIONS
        ways = np.stack([np.cos(angles), np.sin(angles), np.zeros(DIRECTIONS)], axis=1)
        sizes = np.geomspace(min(0.01, 0.1 * most), most, SIZES)
        tried = (sizes[:, None, None] * ways).reshape(-1, 3)
        margins = self._sampled(transitions, state, tried).reshape(SIZES, DIRECTIONS)
        for k in np.flatnonzero((margins > 0.0).any(axis=1)).tolist():
            for way in ways[np.argsort(-margins[k])[: min(3, int((margins[k] > 0.0).sum()))]]:
                high = float(sizes[k])
                margin = self.judged(t_s, kicked(state, high * way))
                if margin < 0.0:
                    continue
                steps = np.linspace(float(sizes[k - 1]) if k else 0.0, high, STEPS + 1)[1:-1]
                fine = self._sampled(transitions, state, steps[:, None] * way)
                for size in steps[fine > 0.0][:2].tolist():
                    less = self.judged(t_s, kicked(state, size * way))
                    if less >= 0.0:
                        return Abort(t_s, state, here, size * way, less)
                return Abort(t_s, state, here, high * way, margin)
        return Abort(t_s, state, here, None, -np.inf)

    def _sampled(self, transitions: Array, state: Array, dv: Array) -> Array:
        """By how much drifts after impulses (B, 3) are safe, m, at the samples (M,) of transitions (M, 3, 6)."""
        approach = self.approach
        kicks = (transitions[:, :, 3:].reshape(-1, 3) @ dv.T).reshape(len(transitions), 3, -1)
        places = np.moveaxis((transitions @ state)[:, :, None] + kicks, 1, 2)
        sizes, ranges = approach.size(places), np.linalg.norm(places, axis=2)
        body = ranges.min(axis=0) - approach.scenario.keep_out.body_m
        been = np.logical_or.accumulate(sizes >= 1.0, axis=0)
        later = np.where(been.any(axis=0), np.where(been, sizes, np.inf).min(axis=0), 0.0)
        return np.asarray(np.minimum(body, approach.axes_m.min() * (later - 1.0) + 1e-9))
