"""Where a flight breaks its conditions worst: the instants that the next conic problem must ask for."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from orbsoc.guidance.impulses import ImpulseProgramme
from orbsoc.guidance.safety_bound import DriftFamily, least_bound
from orbsoc.orbit.array import Array, Flags

from .approach import Approach
from .instants import Instant, Instants
from .nearest_held import EACH, FINE, NEAR_M, HeldDrifts, piece_depths
from .problem import flown

AN_ARC = 24
"""Intervals of an arc."""
BROKEN_M = 5e-4
"""By which a condition must be broken to be asked for at another instant."""


@dataclass(frozen=True, slots=True, eq=False)
class Broken:
    """New instants, and by how much the worst condition is broken, m, speeds by the time that a metre takes."""

    instants: Instants
    worst_m: float


class Search:
    """Looks for the worst instants of flights of one approach; what does not depend on the flight is kept."""

    def __init__(self, approach: Approach, of_an_arc: int = AN_ARC) -> None:
        self.approach, self.of_an_arc = approach, of_an_arc

    def broken(self, programme: ImpulseProgramme, normals: Array | None = None) -> Broken:
        """Of a programme at the approach's instants; with `normals` (K, 3) the drift after an impulse stays beyond the plane of
        its own."""
        after = flown(self.approach, programme)
        if self.approach.held:
            drifts = self._held.nearest(after, normals)
        else:
            drifts = self._drifts(after, programme, normals)
        found: dict[str, list[tuple[Instant, float]]] = {"keep_out": drifts}
        states = np.einsum("ksij,kj->ksi", self._arcs, after)
        scenario, gate = self.approach.scenario, self.approach.guarded
        if scenario.corridor is not None:
            arcs = np.arange(len(states))
            margins = self.approach.corridor_margins(arcs)
            depth = scenario.corridor.depth(states[..., :3]) - margins[:, None]
            found["corridor"] = self._least(depth, arcs >= gate)
        if scenario.half_space is not None:
            wanted = self.approach.ends_s > scenario.half_space_s + 1e-6
            found["half_space"] = self._least(scenario.half_space.depth(states[..., :3]), wanted)
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
    def _held(self) -> HeldDrifts:
        return HeldDrifts(self.approach)

    @cached_property
    def _arc_times(self) -> Array:
        """Instants of each arc, (K, `of_an_arc` + 1)."""
        shares = np.linspace(0.0, 1.0, self.of_an_arc + 1)
        starts, ends = self.approach.times_s, self.approach.ends_s
        return np.asarray(starts[:, None] + shares * (ends - starts)[:, None])

    @cached_property
    def _arcs(self) -> Array:
        """From what each arc begins with to the states at those instants, (K, `of_an_arc` + 1, 6, …)."""
        times = self._arc_times
        arcs = np.repeat(np.arange(len(times)), self.of_an_arc + 1)
        found = self.approach.responses(times.ravel(), arcs, np.ones(arcs.size))
        return found.reshape(*times.shape, 6, -1)

    def _least(self, margins: Array, wanted: Flags) -> list[tuple[Instant, float]]:
        """The instant of the least margin of each arc, of margins (K, `of_an_arc` + 1)."""
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
        return times, approach.transitions(times, np.zeros_like(times))[:, :3]

    @cached_property
    def _back(self) -> Array:
        """From the state after each guarded impulse back to time 0, (G, 6, 6)."""
        motion, count = self.approach.motion, self.approach.guarded
        return np.array([motion.transition(0.0, float(t)) for t in self.approach.times_s[:count]])

    def _drifts(
        self, after: Array, programme: ImpulseProgramme, normals: Array | None
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
        near: list[tuple[int, bool, float, float]] = []
        for g in range(count):
            given = programme.sizes_m_s[g] < 1e-6 or (approach.in_flight and g == 0)
            for whole in (True, False) if cut and not given else (True,):
                end = max(ends[g], float(approach.ends_s[g])) if whole else ends[g]
                first, last = np.searchsorted(times, [starts[g], end + 1e-9]).tolist()
                pair = np.stack([before[g] if not whole else after[g], after[g]], axis=1)
                places = positions[first:last] @ (self._back[g] @ pair)
                depths, _ = piece_depths(self.approach, places, None if normals is None else normals[g])
                inner = np.pad(depths, 1, constant_values=np.inf)
                least = (depths <= inner[:-2]) & (depths <= inner[2:]) & (depths < NEAR_M)
                for m in (first + np.flatnonzero(least)).tolist():
                    low = times[m - 1] if m > first else starts[g]
                    high = times[m + 1] if m + 1 < last else end
                    near.append((g, whole, float(low), float(high)))
        found = self._refined(near, before, after, normals) if near else []
        if np.isinf(approach.horizon_s) and approach.spherical:
            found += self._for_all_time(before, after[:count], cut, normals)
        return found

    def _refined(
        self,
        near: list[tuple[int, bool, float, float]],
        before: Array,
        after: Array,
        normals: Array | None,
    ) -> list[tuple[Instant, float]]:
        """Of spans of time, each after an impulse, whole or cut, the nearest instants, all at once."""
        arcs, whole = np.array([each[0] for each in near]), np.array([each[1] for each in near])
        low, high = (np.array([each[k] for each in near]) for k in (2, 3))
        first = np.where(whole[:, None], after[arcs], before[arcs])
        pairs = np.stack([first, after[arcs]], axis=2)[:, None]
        normal = None if normals is None else normals[arcs][:, None]
        every = np.arange(len(near))
        starts = np.repeat(self.approach.times_s[arcs], FINE)
        for _ in range(2):
            fine = np.linspace(low, high, FINE, axis=1)
            to = self.approach.transitions(fine.ravel(), starts)[:, :3].reshape(-1, FINE, 3, 6)
            depths, fractions = piece_depths(self.approach, to @ pairs, normal)
            best = depths.argmin(axis=1)
            low, high = fine[every, np.maximum(best - 1, 0)], fine[every, np.minimum(best + 1, FINE - 1)]
        fractions = np.where(whole, 1.0, fractions[every, best])
        rows = zip(
            arcs.tolist(), fine[every, best].tolist(), fractions.tolist(), depths[every, best].tolist(),
            strict=True,
        )  # fmt: skip
        return [(Instant(k, t, fraction), depth) for k, t, fraction, depth in rows]

    def _for_all_time(
        self, before: Array, after: Array, cut: bool, normals: Array | None
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
            normal = None if normals is None else normals[k]
            pieces = np.stack([place, place], axis=1)[None]
            depth = float(piece_depths(approach, pieces, normal)[0][0])
            found.append((Instant(k, at + least.after_s, least.fraction if cut else 1.0), depth))
        return found
