"""Where each condition is asked for: instants on the arcs after the impulses."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from orbsoc.orbit.array import Array, Index

from .approach import Approach

KEEP_OUT, CORRIDOR, SPEED, HOLD, AWAY = KINDS = ("keep_out", "corridor", "speed", "hold", "away")
ACTIVE: Final = 0.1
"""Of a row, m, or what speeds it is worth: one that a solution keeps by less is not given up."""

ALIKE_ORBIT, ALIKE_ARC, ALIKE_FRACTION = 60, 4, 0.1
"""Of an orbit, for drifts, of an arc, and of a burn: two instants that are nearer to each other do not need a row each."""
PASSES = 3
"""Of the drift after an impulse, whole or cut, for which there are rows at first."""


@dataclass(frozen=True, slots=True)
class Instant:
    """After impulse `arc`, of which a `fraction` was flown, at a time."""

    arc: int
    t_s: float
    fraction: float = 1.0

    def is_like(self, other: Instant, near_s: float) -> bool:
        """Whether it is so near to another one that they do not need a row each."""
        return abs(self.t_s - other.t_s) < near_s and abs(self.fraction - other.fraction) < ALIKE_FRACTION


@dataclass(frozen=True, slots=True, eq=False)
class Instants:
    """Of each condition its instants. `away`: the drift after the impulse moves away along the track."""

    keep_out: tuple[Instant, ...] = ()
    corridor: tuple[Instant, ...] = ()
    speed: tuple[Instant, ...] = ()
    hold: tuple[Instant, ...] = ()
    away: tuple[Instant, ...] = ()

    def of(self, kind: str) -> tuple[Instant, ...]:
        """Those of one condition."""
        found: tuple[Instant, ...] = getattr(self, kind)
        return found

    def without(self, *kinds: str) -> Instants:
        """The same less some conditions."""
        return replace(self, **dict.fromkeys(kinds, ()))


def arrays(instants: Sequence[Instant]) -> tuple[Index, Array, Array]:
    """Arcs (S,), times (S,) and fractions (S,)."""
    arcs = np.array([each.arc for each in instants], np.intp)
    return arcs, np.array([each.t_s for each in instants]), np.array([each.fraction for each in instants])


def at_nodes(approach: Approach) -> Instants:
    """At the ends of arcs: where corridor, speed and holds are asked for at first."""
    ends = [Instant(k, float(end)) for k, end in enumerate(approach.ends_s)]
    scenario = approach.scenario
    later = tuple(each for each in ends if each.t_s > approach.gate_s)
    held = [
        each
        for _, point in approach.holds()
        for each in ends
        if point.arrive_s <= approach.times_s[each.arc] < point.leave_s
    ]
    return Instants(
        corridor=later if scenario.corridor else (), speed=later if scenario.speed else (), hold=tuple(held)
    )


@dataclass(frozen=True, slots=True, eq=False)
class Room:
    """For how many instants of each condition every arc has rows, (K,) each: what the pattern of a problem depends on."""

    counts: Mapping[str, Index]
    alike_s: Mapping[str, Array]
    """Nearer to each other two instants of an arc do not need a row each, (K,)."""

    @classmethod
    def of(cls, approach: Approach) -> Room:
        """For the instants at first, and the passes of a drift that come near the keep-out."""
        counts = {kind: np.zeros(approach.times_s.size, np.intp) for kind in KINDS}
        for kind in KINDS:
            for each in at_nodes(approach).of(kind):
                counts[kind][each.arc] += 1
        counts[KEEP_OUT][: approach.guarded] = PASSES
        counts[CORRIDOR] *= 2
        counts[HOLD] *= 2
        if np.isinf(approach.horizon_s):
            counts[AWAY][: approach.guarded] = 1
        arcs = (approach.ends_s - approach.times_s) / ALIKE_ARC
        alike = dict.fromkeys(KINDS, arcs) | {KEEP_OUT: 0.0 * arcs + approach.period_s / ALIKE_ORBIT}
        return cls(counts, alike)

    def fitted(self, old: Instants, slacks: Mapping[str, Array], new: Instants) -> tuple[Instants, Room]:
        """Old instants, whose rows a solution keeps by `slacks` (S,), and new ones: those that matter most, and the room for
        them, which is larger where a row that is active, or new, would have none."""
        counts = {kind: each.copy() for kind, each in self.counts.items()}
        found = {}
        for kind in KINDS:
            wanted = dict.fromkeys(new.of(kind), -np.inf)
            for each, slack in zip(old.of(kind), slacks[kind].tolist(), strict=True):
                wanted.setdefault(each, slack)
            kept: list[Instant] = []
            others: list[Instant] = []
            for each, slack in sorted(wanted.items(), key=lambda pair: pair[1]):
                beside = [other for other in kept if other.arc == each.arc]
                near_s = self.alike_s[kind][each.arc]
                alike = any(each.is_like(other, near_s) for other in beside)
                if not alike and slack < ACTIVE:
                    kept.append(each)
                    counts[kind][each.arc] = max(counts[kind][each.arc], len(beside) + 1)
                else:
                    others.append(each)
            for each in others:
                if sum(other.arc == each.arc for other in kept) < counts[kind][each.arc]:
                    kept.append(each)
            found[kind] = tuple(kept)
        drifts = counts[KEEP_OUT]
        drifts[drifts > 0] = drifts.max()  # where one drift has too few rows others soon have
        same = all((counts[kind] == self.counts[kind]).all() for kind in KINDS)
        return Instants(**found), self if same else Room(counts, self.alike_s)
