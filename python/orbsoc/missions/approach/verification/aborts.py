"""Aborts: at every instant, whether the drift is safe by itself, and the smallest impulse that makes it so.

A drift is safe if it stays off the target's body, and, once it is outside the keep-out, stays outside for the scenario's orbits.
Inside the corridor it begins inside. The impulse lies in the orbital plane and has a bound (`least_abort`); what is told has been
judged on chords of a fine drift with their bends. Thrust that is held has no impulse: drifts alone are judged.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from orbsoc.orbit.array import Array

from ..model.approach import AN_ORBIT, Approach
from .least_abort import Places, least_abort
from .linear import LIMIT_M, Arc, bends, chord_lengths

EACH = 2
"""Of the common instants each second ends a chord on which a drift is judged."""
EARLY, LATER, FINER = 0.2, 3, 2
"""Of an orbit, for which each of these is looked at for every square of impulses, or more; later each third."""


@dataclass(frozen=True, slots=True, eq=False)
class Abort:
    """At an instant: the state (6,), by how much the drift is safe by itself, m, the impulse (3,) that makes it safe, zero
    where none is needed and None where none was found, by how much it is then, and what every one that does is at least."""

    time_s: float
    state: Array
    drift_margin_m: float
    dv_m_s: Array | None
    margin_m: float
    at_least_m_s: float = 0.0

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
            "at_least_m_s": self.at_least_m_s,
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

    def _looked_at(self, t_s: float) -> Array:
        """From the state at an instant to the places (M, 3, 6) at which impulses are looked at: more of them soon after it."""
        if self.approach.circular:
            return self._fine
        transitions = self._transitions(t_s)[1][:, :3]
        early = int(EARLY * AN_ORBIT / EACH)
        return np.concatenate([transitions[:early], transitions[early::LATER], transitions[-1:]])

    @cached_property
    def _fine(self) -> Array:
        period = self.approach.period_s
        soon = np.arange(0.0, EARLY * period, period / (FINER * AN_ORBIT))
        late = np.arange(EARLY * period, self.horizon_s, LATER * EACH * period / AN_ORBIT)
        times = np.concatenate([soon, late, [self.horizon_s]])
        return self.approach.transitions(times, np.zeros_like(times))[:, :3]

    def judged(self, t_s: float, state: Array) -> float:
        """Below by how much the drift from a state (6,) at a time is safe, m, on chords with their bends."""
        approach, (times, transitions) = self.approach, self._transitions(t_s)
        states = transitions @ state
        bend, place = bends(approach, times, states)[0], states[:, :3]
        body = float(chord_lengths(place).min()) - approach.scenario.keep_out.body_m
        sizes, ends = chord_lengths(place / approach.axes_m), approach.size(place)
        # between two samples it may be outside for a moment where one of them is nearer to it than the bend
        out = np.flatnonzero(ends >= 1.0 - bend / approach.axes_m.min())
        if not out.size:
            return float(approach.axes_m.min() * (ends[-1] - 1.0))
        least = float(sizes[out[0] :].min(initial=np.inf))
        return min(body, float(approach.axes_m.min() * (least - 1.0))) - bend

    def abort(self, t_s: float, state: Array) -> Abort:
        """Of an instant."""
        here = self.judged(t_s, state)
        if here >= -LIMIT_M:
            return Abort(t_s, state, here, np.zeros(3), here)
        if self.approach.held:
            return Abort(t_s, state, here, None, -np.inf)
        keep_out = self.approach.scenario.keep_out
        places = Places(self._looked_at(t_s), state, self.approach.axes_m, keep_out.body_m)
        largest = self.approach.scenario.safety.abort_m_s
        least = least_abort(places, lambda dv: self.judged(t_s, kicked(state, dv)), largest)
        return Abort(t_s, state, here, least.dv_m_s, least.margin_m, least.at_least_m_s)
