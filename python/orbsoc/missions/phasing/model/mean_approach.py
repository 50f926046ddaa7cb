"""An approach in mean elements, by longitude: weeks of secular drift in some milliseconds, to find what the true motion refines.

The independent variable is the mean longitude, and time an element: where on the orbit an impulse is given, and in which of
its directions R, T, N, counts; so the end depends on all impulses nearly linearly, however far their times move.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from orbsoc.orbit import PropagationError
from orbsoc.orbit.array import Array
from orbsoc.orbit.relative import local_frame

from .approach import Approach, Roll
from .mean_motion import differences, drifted, equinoctial, secular_rates, states_of, wrapped

STEPS = np.array([10.0, 1e-6, 1e-6, 1e-6, 1e-6, 0.1])
"""Of a (m), f, g, h, k and time (s), by which derivatives are taken."""
KICK_STEPS = np.full(3, 0.1)
"""m/s."""


@dataclass(frozen=True, slots=True, eq=False)
class MeanApproach(Approach):
    """Instants at `longitudes` (K,), from 0 at the start; `times_s` are those of the coast from `start`. `start` and `goal` are
    elements (6,) with the time after the first instant (s) for the longitude; both are at the first and the last instant.

    Impulses act on mean elements as on osculating ones: what that leaves out is a thousandth of their effect.
    """

    longitudes: Array = field(default_factory=lambda: np.zeros(1))

    def roll(self, dv_m_s: Array) -> Roll:
        """Drift from impulse to impulse, (R, T, N) each; `to_end` maps velocity changes (its last three columns) to the end."""
        at, count = self.longitudes, self.longitudes.size
        before, after, stops = self._drift(dv_m_s)
        ends = np.array(stops)[np.searchsorted(stops, np.arange(count - 1), side="right")]
        further = differences(lambda z: onward(z, at[ends] - at[:-1]), after[:-1], STEPS)
        by_kick = differences(lambda dv: _kicked(before, dv, at), dv_m_s, KICK_STEPS)
        to_end = np.zeros((count, 6, 6))
        chain = np.diag(self.lengths)
        to_end[-1, :, 3:] = chain @ by_kick[-1]
        for first, k in zip(reversed([0, *stops[:-1]]), reversed(stops), strict=True):
            chain = np.asarray(chain @ self._through(k, before[k], dv_m_s[k]))
            to_end[first:k, :, 3:] = chain @ further[first:k] @ by_kick[first:k]
            chain = np.asarray(chain @ further[first])
        off = after[-1] - self.goal
        return Roll(dv_m_s, before, to_end, off, self.lengths * off, np.eye(6))

    def _through(self, k: int, before: Array, dv_m_s: Array) -> Array:
        """Derivatives (6, 6) of the elements after an impulse by those before it."""
        return differences(lambda elements: _kicked(elements, dv_m_s, self.longitudes[k]), before, STEPS)

    @property
    def lengths(self) -> Array:
        """That make metres of differences of elements and time, (6,)."""
        return np.array([1.0, *[float(self.goal[0])] * 4, 7.5e3])

    def by_start(self, dv_m_s: Array) -> Array:
        """Derivatives (6, 6) of the end, in m, by the elements at the start."""
        ends = differences(
            lambda many: np.array([self._drift(dv_m_s, one)[1][-1] for one in many.reshape(-1, 6)]),
            self.start,
            STEPS,
        )
        return np.asarray(self.lengths[:, None] * ends)

    def flown(self, dv_m_s: Array) -> tuple[Array, Array]:
        """Times after the first instant and inertial velocity changes (N, 3) of a flight's impulses."""
        before, _, _ = self._drift(dv_m_s)
        fired = np.flatnonzero(np.any(dv_m_s, axis=1))
        states = _states(before[fired], self.longitudes[fired])
        turned = [local_frame(state)[0].T @ dv for state, dv in zip(states, dv_m_s[fired], strict=True)]
        return before[fired, 5], np.array(turned)

    def between(self, dv_m_s: Array) -> Array:
        """Elements (N, 6) after each impulse but the last."""
        after = self._drift(dv_m_s)[1]
        return np.asarray(after[np.flatnonzero(np.any(dv_m_s, axis=1))[:-1]])

    @np.errstate(invalid="ignore")
    def _drift(self, dv_m_s: Array, start: Array | None = None) -> tuple[Array, Array, list[int]]:
        """Elements (K, 6) before and after each instant, and the instants at which arcs end."""
        at, count = self.longitudes, self.longitudes.size
        fired = set(np.flatnonzero(np.any(dv_m_s, axis=1)).tolist())
        stops = sorted((fired - {0}) | {count - 1})
        before, after = np.empty((count, 6)), np.empty((count, 6))
        before[0] = after[0] = self.start if start is None else start
        if 0 in fired:
            after[0] = _kicked(before[0], dv_m_s[0], at[0])
        last = 0
        for k in stops:
            before[last + 1 : k + 1] = onward(after[last], at[last + 1 : k + 1] - at[last])
            after[last + 1 : k + 1] = before[last + 1 : k + 1]
            if k in fired:
                after[k] = _kicked(before[k], dv_m_s[k], at[k])
            last = k
        if not np.isfinite(after).all():
            raise PropagationError("an impulse leads to no ellipse")
        return before, after, stops


def _states(elements: Array, longitude: Array) -> Array:
    found = elements.copy()
    found[..., 5] = longitude
    return states_of(found)


def onward(elements: Array, by: Array) -> Array:
    """After some longitude; the last element is time."""
    rates = secular_rates(elements)
    dt = by / rates.sum(axis=-1)
    found = drifted(elements, dt, rates)
    found[..., 5] = elements[..., 5] + dt
    return found


def _kicked(elements: Array, dv_m_s: Array, longitude: Array) -> Array:
    """After a velocity change in (R, T, N), and the drift back to its longitude."""
    state = _states(elements, longitude)
    r, v = state[..., :3], state[..., 3:]
    normal = np.cross(r, v)
    outward, normal = (each / np.linalg.norm(each, axis=-1)[..., None] for each in (r, normal))
    axes = (outward, np.cross(normal, outward), normal)
    dv = np.asarray(dv_m_s)
    kick = sum(dv[..., k, None] * axis for k, axis in enumerate(axes))
    found = equinoctial(np.concatenate(np.broadcast_arrays(r + 0.0 * kick, v + kick), axis=-1))
    ahead = wrapped(found[..., 5] - longitude)
    found[..., 5] = elements[..., 5]
    return onward(found, -ahead)
