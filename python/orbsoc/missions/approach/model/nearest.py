"""Where a flight breaks its conditions worst: the instants that the next conic problem must ask for."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from orbsoc.guidance.impulses import ImpulseProgramme
from orbsoc.guidance.safety import drift_clearance
from orbsoc.orbit.array import Array

from .approach import Approach
from .problem import Instant, Instants, flown

AN_ORBIT = 240
"""Instants of a revolution at which drifts are looked at before the nearest is refined."""
AN_ARC = 8
"""Intervals of an arc."""
FRACTIONS = np.linspace(0.0, 1.0, 11)
"""Of a burn, at which it may stop."""
NEAR_M = 2.0
"""Outside the keep-out, up to which a drift is refined between the instants."""
BROKEN_M = 5e-4
"""By which a condition must be broken to be asked for at another instant."""


@dataclass(frozen=True, slots=True, eq=False)
class Broken:
    """New instants, and by how much the worst condition is broken, m, speeds by the time that a metre takes."""

    instants: Instants
    worst_m: float


class Search:
    """Looks for the worst instants of flights of one approach; what does not depend on the flight is kept."""

    def __init__(self, approach: Approach) -> None:
        self.approach = approach

    def broken(self, programme: ImpulseProgramme, side: Array | None = None) -> Broken:
        """Of a programme at the approach's instants; with `side` (3,) all drifts stay beyond the plane of this normal."""
        after = flown(self.approach, programme)
        found: dict[str, list[tuple[Instant, float]]] = {"keep_out": self._drifts(after, programme, side)}
        states = np.einsum("ksij,kj->ksi", self._arcs, after)
        scenario, gate = self.approach.scenario, self.approach.guarded
        if scenario.corridor is not None:
            depth = scenario.corridor.depth(states[..., :3]) - scenario.corridor.margin_m
            found["corridor"] = self._least(depth, lambda k: k >= gate)
        if scenario.speed is not None:
            ranges = np.linalg.norm(states[..., :3], axis=-1)
            spare = scenario.speed.limit(ranges) - np.linalg.norm(states[..., 3:], axis=-1)
            found["speed"] = self._least(100.0 * spare, lambda k: True)
        hold = []
        for _, point in self.approach.holds():
            away = np.linalg.norm(states[..., :3] - point.position(), axis=-1)
            at = self.approach.times_s
            first, last = point.arrive_s, point.leave_s
            hold += self._least(
                point.hold_within_m - away, lambda k, first=first, last=last: first <= at[k] < last  # type: ignore[misc]
            )
        found["hold"] = hold
        worst = max((-margin for each in found.values() for _, margin in each), default=0.0)
        rows = {name: tuple(at for at, margin in each if margin < -BROKEN_M) for name, each in found.items()}
        return Broken(Instants(**rows), max(worst, 0.0))

    @cached_property
    def _arc_times(self) -> Array:
        """Instants of each arc, (K, AN_ARC + 1)."""
        shares = np.linspace(0.0, 1.0, AN_ARC + 1)
        starts, ends = self.approach.times_s, self.approach.ends_s
        return np.asarray(starts[:, None] + shares * (ends - starts)[:, None])

    @cached_property
    def _arcs(self) -> Array:
        """From the state after each impulse to those instants, (K, AN_ARC + 1, 6, 6)."""
        motion = self.approach.motion
        return np.array([[motion.transition(float(t), float(row[0])) for t in row] for row in self._arc_times])

    def _least(self, margins: Array, wanted: Callable[[int], bool]) -> list[tuple[Instant, float]]:
        """The instant of the least margin of each arc, of margins (K, AN_ARC + 1)."""
        best = margins.argmin(axis=1)
        return [
            (Instant(k, float(self._arc_times[k, best[k]])), float(margins[k, best[k]]))
            for k in range(len(margins))
            if wanted(k)
        ]

    @cached_property
    def _grid(self) -> tuple[Array, Array]:
        """Instants (M,) for drifts before the gate, and the positions (M, 3, 6) that a state at time 0 leads to."""
        approach = self.approach
        span = approach.period_s if np.isinf(approach.horizon_s) else approach.horizon_s
        end = approach.gate_s + span
        times = np.linspace(0.0, end, max(2, int(np.ceil(AN_ORBIT * end / approach.period_s))) + 1)
        return times, np.array([approach.motion.transition(float(t), 0.0)[:3] for t in times])

    @cached_property
    def _back(self) -> Array:
        """From the state after each guarded impulse back to time 0, (G, 6, 6)."""
        motion, count = self.approach.motion, self.approach.guarded
        return np.array([motion.transition(0.0, float(t)) for t in self.approach.times_s[:count]])

    def _drifts(
        self, after: Array, programme: ImpulseProgramme, side: Array | None
    ) -> list[tuple[Instant, float]]:
        """The nearest instants of the drifts, of whole and cut burns, with their margins, m."""
        approach, count = self.approach, self.approach.guarded
        cut = approach.scenario.safety.cut_burns and approach.horizon_s > 0.0
        fractions = FRACTIONS if cut else FRACTIONS[-1:]
        dv = np.zeros((count, 6))
        dv[:, 3:] = programme.dv_m_s[:count]
        states = after[:count, None] - (1.0 - fractions)[:, None] * dv[:, None]  # (G, F, 6)
        times, positions = self._grid
        at_zero = np.einsum("gij,gfj->igf", self._back, states).reshape(6, -1)
        places = (positions.reshape(-1, 6) @ at_zero).reshape(len(times), 3, -1)
        depths = self._depths(np.moveaxis(places, 1, 2), side).reshape(len(times), count, -1)
        starts = approach.times_s[:count, None]
        # a drift is looked at for its horizon; the arc that is flown in any case, by a whole burn alone
        flown_until = np.where(fractions == 1.0, approach.ends_s[:count, None], starts)
        until = np.maximum(starts + min(approach.horizon_s, times[-1]), flown_until)
        there = (times[:, None, None] >= starts) & (times[:, None, None] <= until)
        depths = np.where(there, depths, np.inf)
        inner = np.pad(depths, ((1, 1), (0, 0), (0, 0)), constant_values=np.inf)
        wells = (depths <= inner[:-2]) & (depths <= inner[2:]) & (depths < NEAR_M)
        small = programme.sizes_m_s[:count] < 1e-6
        wells[:, small, :-1] = False
        found = []
        for m, g, f in np.argwhere(wells).tolist():
            low = max(float(times[max(m - 1, 0)]), float(starts[g, 0]))
            high = min(float(times[min(m + 1, len(times) - 1)]), float(until[g, f]))
            found.append(self._refined(g, float(fractions[f]), states[g, f], low, high, side))
        if np.isinf(approach.horizon_s) and approach.spherical and side is None:
            found += self._for_all_time(states, fractions)
        return found

    def _depths(self, places: Array, side: Array | None) -> Array:
        """How far outside the keep-out with its margin, or beyond its plane, positions (..., 3) are, m."""
        axes = self.approach.axes_m + self.approach.scenario.keep_out.margin_m
        scaled = places / axes
        sizes = np.linalg.norm(scaled, axis=-1) if side is None else scaled @ side
        return np.asarray(float(axes.min()) * (sizes - 1.0))

    def _refined(
        self, k: int, fraction: float, state: Array, low_s: float, high_s: float, side: Array | None
    ) -> tuple[Instant, float]:
        motion, at = self.approach.motion, float(self.approach.times_s[k])
        for _ in range(2):
            fine = np.linspace(low_s, high_s, 9)
            depths = self._depths(np.array([motion.transition(float(t), at)[:3] @ state for t in fine]), side)
            best = int(depths.argmin())
            low_s, high_s = float(fine[max(best - 1, 0)]), float(fine[min(best + 1, 8)])
        return Instant(k, float(fine[best]), fraction), float(depths[best])

    def _for_all_time(self, states: Array, fractions: Array) -> list[tuple[Instant, float]]:
        clear = drift_clearance(states.reshape(-1, 6), self.approach.mean_motion_rad_s)
        radius, found = float(self.approach.axes_m[0]) + self.approach.scenario.keep_out.margin_m, []
        for row, (away, after_s) in enumerate(zip(clear.distance_m, clear.at_s, strict=True)):
            k, f = divmod(row, len(fractions))
            if away < radius + NEAR_M:
                at = Instant(k, float(self.approach.times_s[k] + after_s), float(fractions[f]))
                found.append((at, float(away) - radius))
        return found
