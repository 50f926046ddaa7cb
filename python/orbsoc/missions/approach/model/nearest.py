"""Where a flight breaks its conditions worst: the instants that the next conic problem must ask for."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from orbsoc.guidance.impulses import ImpulseProgramme
from orbsoc.guidance.safety_bound import DriftFamily, least_bound
from orbsoc.orbit.array import Array, Flags

from .approach import Approach
from .problem import Instant, Instants, flown

EACH = 3
"""One of so many of the common instants is looked at in a drift before the nearest is refined."""
AN_ARC = 24
"""Intervals of an arc."""
NEAR_M = 80.0
"""Outside the keep-out, up to which a drift is refined between the instants: what it flies from one to the next."""
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
            found["corridor"] = self._least(depth, np.arange(len(depth)) >= gate)
        if scenario.speed is not None:
            ranges = np.linalg.norm(states[..., :3], axis=-1)
            spare = scenario.speed.limit(ranges) - np.linalg.norm(states[..., 3:], axis=-1)
            found["speed"] = self._least(100.0 * spare, np.full(len(spare), True))
        hold: list[tuple[Instant, float]] = []
        for _, point in self.approach.holds():
            held = (self.approach.times_s >= point.arrive_s) & (self.approach.times_s < point.leave_s)
            away = np.linalg.norm(states[..., :3] - point.position(), axis=-1)
            hold += self._least(point.hold_within_m - away, held)
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
        return np.array(
            [[motion.transition(float(t), float(row[0])) for t in row] for row in self._arc_times]
        )

    def _least(self, margins: Array, wanted: Flags) -> list[tuple[Instant, float]]:
        """The instant of the least margin of each arc, of margins (K, AN_ARC + 1)."""
        best = margins.argmin(axis=1)
        return [
            (Instant(k, float(self._arc_times[k, best[k]])), float(margins[k, best[k]]))
            for k in np.flatnonzero(wanted).tolist()
        ]

    @cached_property
    def _grid(self) -> tuple[Array, Array]:
        """Instants (M,) for drifts before the gate, and the positions (M, 3, 6) that a state at time 0 leads to."""
        approach = self.approach
        span = approach.period_s if np.isinf(approach.horizon_s) else approach.horizon_s
        end = approach.gate_s + span
        times = approach.instants(0.0, end, EACH)
        return times, np.array([approach.motion.transition(float(t), 0.0)[:3] for t in times])

    @cached_property
    def _back(self) -> Array:
        """From the state after each guarded impulse back to time 0, (G, 6, 6)."""
        motion, count = self.approach.motion, self.approach.guarded
        return np.array([motion.transition(0.0, float(t)) for t in self.approach.times_s[:count]])

    def _drifts(
        self, after: Array, programme: ImpulseProgramme, side: Array | None
    ) -> list[tuple[Instant, float]]:
        """The nearest instants of the drifts, of whole and cut burns, with their margins, m.

        At a time the places of all fractions are a straight piece, whose nearest point is known.
        """
        approach, count = self.approach, self.approach.guarded
        before = after[:count].copy()
        before[:, 3:] -= programme.dv_m_s[:count]
        cut = approach.scenario.safety.cut_burns and approach.horizon_s > 0.0
        times, positions = self._grid
        starts = approach.times_s[:count]
        ends = [float(min(each + approach.horizon_s, times[-1])) for each in starts]
        found = []
        for g in range(count):
            small = programme.sizes_m_s[g] < 1e-6
            for whole in (True, False) if cut and not small else (True,):
                end = max(ends[g], float(approach.ends_s[g])) if whole else ends[g]
                there = np.flatnonzero((times >= starts[g]) & (times <= end))
                pair = np.stack([before[g] if not whole else after[g], after[g]], axis=1)
                places = positions[there] @ (self._back[g] @ pair)
                depths, _ = self._depths(places, side)
                inner = np.pad(depths, 1, constant_values=np.inf)
                for m in np.flatnonzero(
                    (depths <= inner[:-2]) & (depths <= inner[2:]) & (depths < NEAR_M)
                ).tolist():
                    low = times[there[m - 1]] if m else starts[g]
                    high = times[there[m + 1]] if m + 1 < there.size else end
                    found.append(self._refined(g, pair, float(low), float(high), side))
        if np.isinf(approach.horizon_s) and approach.spherical:
            found += self._for_all_time(before, after[:count], cut, side)
        return found

    def _depths(self, places: Array, side: Array | None) -> tuple[Array, Array]:
        """How far outside the keep-out with its margin, or beyond its plane, the nearest of each piece (M, 3, 2) is, m, and
        the fraction that it is at."""
        axes = self.approach.axes_m + self.approach.scenario.keep_out.margin_m
        scaled = places / axes[:, None]
        first, along = scaled[..., 0], scaled[..., 1] - scaled[..., 0]
        if side is not None:
            fractions = np.where(along @ side < 0.0, 1.0, 0.0)
        else:
            fractions = np.clip(
                -(first * along).sum(axis=1) / np.maximum((along**2).sum(axis=1), 1e-30), 0.0, 1.0
            )
        nearest = first + fractions[:, None] * along
        sizes = np.linalg.norm(nearest, axis=1) if side is None else nearest @ side
        return float(axes.min()) * (sizes - 1.0), fractions

    def _refined(
        self, k: int, pair: Array, low_s: float, high_s: float, side: Array | None
    ) -> tuple[Instant, float]:
        motion, at = self.approach.motion, float(self.approach.times_s[k])
        for _ in range(2):
            fine = np.linspace(low_s, high_s, 9)
            places = np.array([motion.transition(float(t), at)[:3] @ pair for t in fine])
            depths, fractions = self._depths(places, side)
            best = int(depths.argmin())
            low_s, high_s = float(fine[max(best - 1, 0)]), float(fine[min(best + 1, 8)])
        fraction = 1.0 if (pair[:, 0] == pair[:, 1]).all() else float(fractions[best])
        return Instant(k, float(fine[best]), fraction), float(depths[best])

    def _for_all_time(
        self, before: Array, after: Array, cut: bool, side: Array | None
    ) -> list[tuple[Instant, float]]:
        """The nearest of each drift family, however late."""
        approach, found = self.approach, []
        for k, (state, later) in enumerate(zip(before, after, strict=True)):
            pair = np.stack([state if cut else later, later], axis=1)
            kick = (pair[:, 1] - pair[:, 0])[3:]
            least = least_bound(DriftFamily(pair[:, 0], kick, approach.mean_motion_rad_s))
            at = float(approach.times_s[k])
            rows = approach.motion.transition(at + least.after_s, at)[:3]
            place = rows @ (pair[:, 0] + least.fraction * (pair[:, 1] - pair[:, 0]))
            depth = float(self._depths(np.stack([place, place], axis=1)[None], side)[0][0])
            found.append((Instant(k, at + least.after_s, least.fraction if cut else 1.0), depth))
        return found
