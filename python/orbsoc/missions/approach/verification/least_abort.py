"""The smallest abort impulse in the orbital plane, and that no smaller one will do: branch and bound over squares of impulses.

The place of a drift at an instant is affine in the impulse: over a square of impulses it is farthest from the target at a corner, and
no nearer than at the middle less the way to a corner. Instants alone show that an impulse is not safe: one in the body, one
outside the keep-out and a later one inside, or the last one inside. A square all of which one of these rules out is done. Of the others
those that come nearer to zero than the best impulse known are cut in four.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import inf

import numpy as np

from orbsoc.orbit.array import Array, Flags

GAP, GAP_M_S = 0.01, 1e-4
"""Of the best impulse, and m/s: how far below it the bound may stay."""
SQUARES = 8
"""Along each side of the first grid."""
MOST_SQUARES = 2_500
"""Looked at for one instant; what is left then counts by its nearest to zero."""
SHARES = np.linspace(0.0, 1.0, 65)[1:]
"""Of an impulse that will do: sizes that are looked at."""
TRIED = 3
"""Impulses of a round that are judged."""


@dataclass(frozen=True, slots=True, eq=False)
class LeastAbort:
    """The impulse (3,), None where there is none, by how much its drift is safe, and what every other one is at least, m/s."""

    dv_m_s: Array | None
    margin_m: float
    at_least_m_s: float


class Places:
    """Of the drift at instants (M,), in order of time: in semi-axes of the keep-out without an impulse, and by one along R and T;
    and the same in radii of the body, where it is no sphere."""

    def __init__(self, transitions: Array, state: Array, axes_m: Array, body_m: float) -> None:
        """`transitions` (M, 3, 6) from the state (6,) to the places."""
        self._shapes = [_Shape.of(transitions, state, axes_m)]
        self._body = body_m / float(axes_m.min())
        if np.ptp(axes_m):
            self._shapes.append(_Shape.of(transitions, state, np.full(3, axes_m.min())))

    def unsafe(self, middles: Array, half: float) -> Flags:
        """Of squares with these middles (B, 2) and half a side, which hold no safe impulse, for certain."""
        ranges = [shape.range(middles, half) for shape in self._shapes]
        near, far = ranges[0]
        been = np.logical_or.accumulate(near >= 1.0, axis=1)
        ruled_out = (been & (far < 1.0)).any(axis=1) | (far[:, -1] < 1.0)
        return np.asarray(ruled_out | (ranges[-1][1] < self._body).any(axis=1))

    def safe(self, impulses: Array) -> Flags:
        """Of impulses (B, 2), whose drift is safe at the instants."""
        sizes = [np.sqrt((shape.at(impulses) ** 2).sum(axis=0)) for shape in self._shapes]
        been = np.logical_or.accumulate(sizes[0] >= 1.0, axis=1)
        kept = ~(been & (sizes[0] < 1.0)).any(axis=1) & been[:, -1]
        return np.asarray(kept & (sizes[-1] >= self._body).all(axis=1))


@dataclass(frozen=True, slots=True, eq=False)
class _Shape:
    """Places (3, M) in semi-axes, by a unit along R and along T (3, M), the sum of the squares of both and their product, (M,)."""

    without: Array
    along: tuple[Array, Array]
    squares: Array
    product: Array

    @classmethod
    def of(cls, transitions: Array, state: Array, axes_m: Array) -> _Shape:
        rows = np.moveaxis(transitions / axes_m[:, None], 0, 2)
        first, second = rows[:, 3], rows[:, 4]
        squares = (first**2 + second**2).sum(axis=0)
        return cls(
            np.einsum("ijm,j->im", rows, state), (first, second), squares, (first * second).sum(axis=0)
        )

    def at(self, impulses: Array) -> Array:
        """(3, B, M)."""
        first, second = (each[:, None] for each in self.along)
        return np.asarray(self.without[:, None] + first * impulses[:, :1] + second * impulses[:, 1:])

    def range(self, middles: Array, half: float) -> tuple[Array, Array]:
        """Below and above the distances of the squares, (B, M)."""
        place = self.at(middles)
        first, second = (half * (place * each[:, None]).sum(axis=0) for each in self.along)
        spread, both = half**2 * self.squares, half**2 * self.product
        square = (place**2).sum(axis=0)
        corner = np.maximum(np.abs(first + second) + both, np.abs(first - second) - both)
        far = np.sqrt(np.maximum(square + spread + 2.0 * corner, 0.0))
        return np.sqrt(square) - np.sqrt(spread + 2.0 * np.abs(both)), far


def least_abort(places: Places, judged: Callable[[Array], float], largest_m_s: float) -> LeastAbort:
    """Of all impulses up to a size. `judged` says of one (3,) by how much its drift is safe, m, also between the instants."""
    half = largest_m_s / SQUARES
    line = half * (2.0 * np.arange(SQUARES) - SQUARES + 1.0)
    middles = np.stack(np.meshgrid(line, line), axis=-1).reshape(-1, 2)
    best, found, margin, looked = inf, None, -inf, 0
    while True:
        nearest = np.linalg.norm(np.maximum(np.abs(middles) - half, 0.0), axis=1)
        enough = largest_m_s
        if found is not None:
            enough = min(max(best - max(GAP * best, GAP_M_S), 0.0), largest_m_s)
        left = nearest < enough
        middles, nearest = middles[left], nearest[left]
        if looked + len(middles) > MOST_SQUARES:
            return LeastAbort(found, margin, float(nearest.min(initial=enough)))
        looked += len(middles)
        left = ~places.unsafe(middles, half)
        middles, nearest = middles[left], nearest[left]
        if not len(middles):
            return LeastAbort(found, margin, enough)
        for impulse in _promising(places, middles, min(best, largest_m_s)):
            kept = judged(impulse)
            if kept >= 0.0:
                best, found, margin = float(np.linalg.norm(impulse)), impulse, kept
                break
        half *= 0.5
        middles = (middles[:, None] + half * np.array([[-1, -1], [-1, 1], [1, -1], [1, 1]])).reshape(-1, 2)


def _promising(places: Places, middles: Array, below_m_s: float) -> list[Array]:
    """Impulses (3,) along the smallest middle that is safe at the instants, the shortest that is so first, below a size."""
    sizes = np.linalg.norm(middles, axis=1)
    order = np.argsort(sizes)
    safe = places.safe(middles[order])
    if not safe.any():
        return []
    tried = SHARES[:, None] * middles[order][safe.argmax()]
    tried = tried[(np.linalg.norm(tried, axis=1) < below_m_s) & places.safe(tried)]
    return [np.append(each, 0.0) for each in tried[:TRIED]]
