"""Where drifts after thrust that is held, cut at any instant, come nearest; and how near straight pieces do.

At a time the places of all cuts of an arc are a curve. It is looked at as a polygon, whose corners are exact and whose pieces are
made shorter where it is nearest.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np

from orbsoc.orbit.array import Array, Index
from orbsoc.orbit.relative import ClohessyWiltshire

from .approach import Approach
from .instants import Instant

EACH = 3
"""Of the common instants each third is looked at in a drift before the nearest is refined."""
NEAR_M = 80.0
"""Outside the keep-out, up to which a drift is refined between the instants: what it flies from one to the next."""
FINE = 9
"""Instants, and cuts, at which each span is looked at."""
ROUNDS = 3
"""Of refinement; each makes the span of cuts a quarter."""
STILL_M_S = 1e-6
"""Velocity change of an arc that counts as none."""
CUTS_AN_ORBIT, MOST_CUTS = 60, 8
"""Pieces of the cuts of an arc, at first."""


def piece_depths(approach: Approach, places: Array, normal: Array | None) -> tuple[Array, Array]:
    """How far outside the keep-out with its margin, or beyond its plane, the nearest of each straight piece (..., 3, 2) is, m, and
    the fraction that it is at."""
    axes = approach.outer_m
    scaled = places / axes[:, None]
    first, along = scaled[..., 0], scaled[..., 1] - scaled[..., 0]
    if normal is not None:
        fractions = np.where((along * normal).sum(axis=-1) < 0.0, 1.0, 0.0)
    else:
        fractions = np.clip(
            -(first * along).sum(axis=-1) / np.maximum((along**2).sum(axis=-1), 1e-30), 0.0, 1.0
        )
    nearest = first + fractions[..., None] * along
    sizes = np.linalg.norm(nearest, axis=-1) if normal is None else (nearest * normal).sum(axis=-1)
    return float(axes.min()) * (sizes - 1.0), fractions


class HeldDrifts:
    """Looks for the nearest instants of drifts before the gate; what does not depend on the flight is kept."""

    def __init__(self, approach: Approach) -> None:
        assert isinstance(approach.motion, ClohessyWiltshire)  # the scenario checks it
        self.approach, self.motion = approach, approach.motion
        safety = approach.scenario.safety
        self._cut = safety.cut_burns and approach.horizon_s > 0.0

    @cached_property
    def _drifts(self) -> tuple[Array, Array]:
        """Times since a cut (M,), and from the state there to the positions then, (M, 3, 6)."""
        lapses = np.unique(self.approach.instants(0.0, self.approach.horizon_s, EACH))
        return lapses, self.motion.transitions(lapses)[:, :3]

    def _families(self, k: int, dv: Array) -> list[tuple[Array, Array, Array]]:
        """Of an arc and its velocity change (3,): times since a cut (M,), to the positions then (M, 3, 6), and cuts (F,).

        Where cuts are not looked at, the flight, which is no time after every cut, and the drift after the whole arc.
        """
        lapses, to = self._drifts
        whole = float(self.approach.ends_s[k] - self.approach.times_s[k])
        wanted = int(np.ceil(CUTS_AN_ORBIT * whole / self.approach.period_s))
        cuts = np.linspace(0.0, 1.0, min(MOST_CUTS, max(1, wanted)) + 1)
        if self._cut and np.linalg.norm(dv) >= STILL_M_S:
            return [(lapses, to, cuts)]
        return [(lapses[:1], to[:1], cuts), (lapses, to, np.ones(2))]

    def _cut_states(self, arcs: Index, cuts: Array, begun: Array) -> Array:
        """Of a flight whose arcs begin with (K, 9), the states where thrust is cut (S, F) on arcs (S,): (S, F, 6)."""
        starts = self.approach.times_s[arcs][:, None]
        times = starts + cuts * (self.approach.ends_s[arcs][:, None] - starts)
        to = self.approach.responses(times.ravel(), np.repeat(arcs, cuts.shape[1]), cuts.ravel())
        return np.asarray(np.einsum("sfij,sj->sfi", to.reshape(*cuts.shape, 6, 9), begun[arcs]))

    def nearest(self, begun: Array, normals: Array | None) -> list[tuple[Instant, float]]:
        """Of a flight whose arcs begin with (K, 9), the nearest instants of its drifts before the gate with their margins, m.

        With `normals` (K, 3) the drifts after an arc's cuts stay beyond the plane of its own.
        """
        spans: list[tuple[float, ...]] = []
        for k in range(self.approach.guarded):
            normal = None if normals is None else normals[k]
            for lapses, to, cuts in self._families(k, begun[k, 6:]):
                states = self._cut_states(np.array([k]), cuts[None], begun)[0]
                corners = np.einsum("mij,fj->mfi", to, states)
                depths, _ = piece_depths(self.approach, _pieces(corners), normal)
                inner = np.pad(depths, 1, constant_values=np.inf)
                beside = (inner[:-2, 1:-1], inner[2:, 1:-1], inner[1:-1, :-2], inner[1:-1, 2:])
                least = np.logical_and.reduce([depths <= each for each in beside]) & (depths < NEAR_M)
                for m, j in zip(*np.nonzero(least), strict=True):
                    around = lapses[max(m - 1, 0)], lapses[min(m + 1, lapses.size - 1)]
                    spans.append((k, *around, cuts[j], cuts[j + 1]))
        return self._refined(np.array(spans), begun, normals) if spans else []

    def _refined(self, spans: Array, begun: Array, normals: Array | None) -> list[tuple[Instant, float]]:
        """Of spans of time since the cut and of cuts (S, 5), the nearest instants, all at once."""
        arcs: Index = spans[:, 0].astype(np.intp)
        low, high, first, last = spans[:, 1:].T
        normal = None if normals is None else normals[arcs][:, None, None]
        every, shares = np.arange(len(spans)), np.linspace(0.0, 1.0, FINE)
        for _ in range(ROUNDS):
            lapses = low[:, None] + shares * (high - low)[:, None]
            cuts = first[:, None] + shares * (last - first)[:, None]
            to, states = self.motion.transitions(lapses)[..., :3, :], self._cut_states(arcs, cuts, begun)
            pieces = _pieces(np.einsum("smij,sfj->smfi", to, states))
            depths, fractions = piece_depths(self.approach, pieces, normal)
            best = depths.reshape(len(spans), -1).argmin(axis=1)
            m, j = best // (FINE - 1), best % (FINE - 1)
            width = cuts[:, 1] - cuts[:, 0]
            at, lapse = cuts[every, j] + fractions[every, m, j] * width, lapses[every, m]
            low, high = lapses[every, np.maximum(m - 1, 0)], lapses[every, np.minimum(m + 1, FINE - 1)]
            first, last = np.maximum(first, at - width), np.minimum(last, at + width)
        starts = self.approach.times_s[arcs]
        times = starts + at * (self.approach.ends_s[arcs] - starts) + lapse
        rows = zip(arcs.tolist(), times.tolist(), at.tolist(), depths[every, m, j].tolist(), strict=True)
        return [(Instant(k, t, cut), depth) for k, t, cut, depth in rows]


def _pieces(corners: Array) -> Array:
    """Between neighbours of corners (..., F, 3): (..., F − 1, 3, 2)."""
    return np.stack([corners[..., :-1, :], corners[..., 1:, :]], axis=-1)
