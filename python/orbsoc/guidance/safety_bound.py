"""Below how near drifts come: of an impulse cut at any fraction, about a circular target, by branch and bound.

The position at a phase θ, k revolutions on, is linear in the fraction f. Over a box of f and θ its squared distance from
the target is q ≥ q_c − |∂q/∂f| δf − |∂q/∂θ| δθ − |r| (B_θθ δθ² + 2 B_fθ δf δθ), for the rest of its second derivative is a
square; and it is at least the sum of the squares of the least |R|, |T|, |N|. Of all revolutions the two that come nearest by
the first formula, all others by the second. Boxes that may hold less than what is known are halved.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf, pi

import numpy as np

from orbsoc.orbit.array import Array, Flags

STILL_M = 1e-3
"""By which a closed ellipse may move in a revolution: the tolerance of the solver that closed it, not a drift."""
WITHIN_M = 1e-3
"""How far below the least distance found the bound is."""
BETTER_M = 1e-4
"""Less is no better place than the one that is known."""
CELLS = 8192
"""Of the fraction, by which the unsafe share is told."""
MOST_BOXES = 200_000
"""Looked at for one bound; what is left then counts by its own bounds."""


@dataclass(frozen=True, slots=True, eq=False)
class Bounds:
    """Of boxes (B,): below every distance in them, that at their middle (inf where none is known) at its nearest
    revolution, and whether the fraction changes it more than the phase."""

    bound_m: Array
    middle_m: Array
    revolution: Array
    across_fraction: Flags


@dataclass(frozen=True, slots=True)
class Least:
    """A distance of drifts, and that none is below `at_least_m`, None where that is not known: at a fraction, after a time."""

    distance_m: float
    at_least_m: float | None
    fraction: float
    after_s: float


@dataclass(frozen=True, slots=True, eq=False)
class DriftFamily:
    """Drifts from states `before` + f · (0, dv), 0 ≤ f ≤ 1, about a circular target, for a time from then on."""

    before: Array
    dv_m_s: Array
    mean_motion_rad_s: float
    horizon_s: float = inf

    @property
    def end_rad(self) -> float:
        """The phases that there are."""
        return min(2.0 * pi, self.mean_motion_rad_s * self.horizon_s)

    def _linear(self) -> tuple[Array, Array]:
        """Centre, T of it, and the coefficients of cos, sin in R and of cos, sin in N: at f = 0, and by f; (6,) each."""
        n = self.mean_motion_rad_s
        found = []
        for x, y, z, vx, vy, vz in (self.before, np.concatenate([np.zeros(3), self.dv_m_s])):
            centre = 4.0 * x + 2.0 * vy / n
            found.append(np.array([centre, y - 2.0 * vx / n, x - centre, vx / n, z, vz / n]))
        return found[0], found[1]

    def bounds(self, boxes: Array) -> Bounds:
        """Of boxes (B, 4), (f, θ, δf, δθ)."""
        f, theta, df, dt = boxes.T
        zero, by = self._linear()
        c, along, p, q, z, w = zero[:, None] + by[:, None] * f
        c1, along1, p1, q1, _, w1 = by
        cos, sin = np.cos(theta), np.sin(theta)
        slowest, fastest = 3.0 * pi * (abs(c) - abs(c1) * df), 3.0 * pi * (abs(c) + abs(c1) * df)
        still = fastest < STILL_M
        part = ~still & (slowest < STILL_M)  # where drifts turn round, or stand still in a part of the box
        step, step1 = np.where(still, 0.0, -3.0 * pi * c), np.where(still, 0.0, -3.0 * pi * c1)
        turn, grows = theta / (2.0 * pi), abs(step1) * df
        # R, T, N: at revolution 0, by f, by θ; above their second derivatives, and above how far they reach in the box
        values = np.stack([
            c + p * cos + q * sin, along + step * turn + 2.0 * (q * cos - p * sin), z * cos + w * sin
        ])  # fmt: skip
        by_f = np.stack([
            c1 + p1 * cos + q1 * sin, along1 + step1 * turn + 2.0 * (q1 * cos - p1 * sin), w1 * sin
        ])  # fmt: skip
        by_t = np.stack([
            q * cos - p * sin, step / (2.0 * pi) - 2.0 * (q * sin + p * cos), w * cos - z * sin
        ])  # fmt: skip
        swing, swing1 = np.hypot(p, q) + np.hypot(p1, q1) * df, np.hypot(p1, q1) + 0.0 * df
        by_tt = np.stack([swing, 2.0 * swing, np.hypot(z, w) + abs(w1) * df])
        by_ft = np.stack([swing1, abs(step1) / (2.0 * pi) + 2.0 * swing1, abs(w1) + 0.0 * df])
        reach = abs(by_f) * df + abs(by_t) * dt + 0.5 * by_tt * dt**2 + by_ft * df * dt
        least = np.maximum(0.0, abs(values) - reach)
        flat = least[0] ** 2 + least[2] ** 2

        def beside(k: Array) -> Array:
            """Below T² of the k-th revolution; convex in k, and least where T turns its sign."""
            return np.asarray(np.maximum(0.0, abs(values[1] + k * step) - reach[1] - k * grows) ** 2)

        spare = self.mean_motion_rad_s * self.horizon_s - theta
        last = np.floor(np.maximum(spare + dt, 0.0) / (2.0 * pi))
        with np.errstate(divide="ignore", invalid="ignore"):
            low = np.clip(np.floor(np.where(step != 0.0, -values[1] / step, 0.0)), 0.0, last)
        bound, middle, which = np.full(f.size, inf), np.full(f.size, inf), low
        along_f = np.zeros(f.size)
        for k in (low, np.minimum(low + 1.0, last)):
            place, slope = values.copy(), by_f.copy()
            place[1] += k * step
            slope[1] += k * step1
            square = (place**2).sum(axis=0)
            widest = np.sqrt(square) + np.linalg.norm(reach, axis=0) + k * grows
            curved = np.linalg.norm(by_tt, axis=0) * dt**2 + 2.0 * np.linalg.norm(by_ft, axis=0) * df * dt
            falls = abs((place * slope).sum(axis=0)) * df + abs((place * by_t).sum(axis=0)) * dt
            bound = np.minimum(bound, np.maximum(square - 2.0 * falls - widest * curved, flat + beside(k)))
            nearer = (square < middle) & (2.0 * pi * k <= spare)
            middle, which = np.where(nearer, square, middle), np.where(nearer, k, which)
            along_f = np.maximum(along_f, np.linalg.norm(slope, axis=0) * df)
        for k, there in ((low - 1.0, low >= 1.0), (low + 2.0, low + 2.0 <= last)):
            bound = np.minimum(bound, np.where(there, flat + beside(np.maximum(k, 0.0)), inf))
        ends = np.minimum(beside(np.zeros_like(last)), beside(np.where(last < inf, last, 0.0)))
        anywhere = np.maximum(0.0, np.sqrt(ends) - STILL_M * (last + 1.0)) ** 2
        # no fraction of the box drifts towards the target: at its first revolution each is nearest, or closed
        away = (abs(values[1]) > reach[1]) & (grows - np.sign(values[1]) * step < STILL_M)
        part_along = np.where(away, beside(np.zeros_like(last)), np.where(last < inf, anywhere, 0.0))
        bound = np.where(part, np.minimum(bound, flat + part_along), bound)
        middle = np.where(part, inf, middle)
        across = part | (along_f > np.linalg.norm(by_t, axis=0) * dt)
        return Bounds(np.sqrt(np.maximum(bound, 0.0)), np.sqrt(middle), which, across)

    def distance(self, fraction: Array, theta: Array, k: Array) -> Array:
        """At phases of revolutions."""
        zero, by = self._linear()
        c, along, p, q, z, w = zero[:, None] + by[:, None] * fraction
        step = np.where(np.abs(3.0 * pi * c) < STILL_M, 0.0, -3.0 * pi * c)
        cos, sin = np.cos(theta), np.sin(theta)
        tangential = along + step * (theta / (2.0 * pi) + k) + 2.0 * (q * cos - p * sin)
        return np.asarray(np.sqrt((c + p * cos + q * sin) ** 2 + tangential**2 + (z * cos + w * sin) ** 2))

    def boxes(self, fractions: int = 8, phases: int = 64) -> Array:
        """All there is, in boxes; one fraction where the impulse is zero."""
        if not self.dv_m_s.any():
            fractions = 1
        width, turn = 0.5 / fractions, 0.5 * self.end_rad / phases
        f = width * (2.0 * np.arange(fractions) + 1.0)
        theta = turn * (2.0 * np.arange(phases) + 1.0)
        grid = np.stack(np.meshgrid(f, theta, indexing="ij"), axis=-1).reshape(-1, 2)
        widths = np.broadcast_to([width if self.dv_m_s.any() else 0.0, turn], grid.shape)
        return np.hstack([grid, widths])


def least_bound(family: DriftFamily, known: Least | None = None) -> Least:
    """The least distance of the family, to within `WITHIN_M` where the boxes suffice; `known` is one of its distances."""
    boxes, looked = family.boxes(), 0
    found = known or Least(inf, None, 0.0, 0.0)
    while True:
        at = family.bounds(boxes)
        looked += len(boxes)
        k = int(at.middle_m.argmin())
        if at.middle_m[k] < found.distance_m - BETTER_M:
            after_s = (boxes[k, 1] + 2.0 * pi * at.revolution[k]) / family.mean_motion_rad_s
            found = Least(float(at.middle_m[k]), None, float(boxes[k, 0]), float(after_s))
        enough = found.distance_m - WITHIN_M
        left = at.bound_m < enough
        if enough <= 0.0 or not left.any():
            return replace(found, at_least_m=max(enough, 0.0))
        if looked > MOST_BOXES:
            return replace(found, at_least_m=float(at.bound_m[left].min()))
        boxes = _halved(boxes[left], at.across_fraction[left])


def unsafe_shares(family: DriftFamily, keep_out_m: float) -> tuple[float, float]:
    """Of the fractions, the share whose drift comes nearer than a distance: at most, and at least, this."""
    if keep_out_m <= 0.0:
        return 0.0, 0.0
    if not family.dv_m_s.any():
        least = least_bound(family)
        return float((least.at_least_m or 0.0) < keep_out_m), float(least.distance_m < keep_out_m)
    unsafe, open_ = np.zeros(CELLS, np.bool_), np.zeros(CELLS, np.bool_)
    boxes, looked = family.boxes(), 0
    while len(boxes):
        at = family.bounds(boxes)
        looked += len(boxes)
        first, end = (np.rint((boxes[:, 0] + sign * boxes[:, 2]) * CELLS).astype(int) for sign in (-1.0, 1.0))
        near = np.flatnonzero(at.middle_m < keep_out_m)
        # the place is linear in f: near at both ends, near between them
        for edge in (first, end):
            there = family.distance(edge[near] / CELLS, boxes[near, 1], at.revolution[near])
            near = near[there < keep_out_m]
        for k in near.tolist():
            unsafe[first[k] : end[k]] = True
        count = np.concatenate([[0], np.cumsum(unsafe)])
        left = (at.bound_m < keep_out_m) & (count[end] - count[first] < end - first)
        done = left & (boxes[:, 2] < 0.51 / CELLS) & (boxes[:, 3] < 0.1 * pi / CELLS)
        if looked > MOST_BOXES:
            done = left
        for k in np.flatnonzero(done).tolist():
            open_[first[k] : end[k]] = True
        left &= ~done
        splits = at.across_fraction & (boxes[:, 2] > 0.51 / CELLS) | (boxes[:, 3] < 0.1 * pi / CELLS)
        boxes = _halved(boxes[left], splits[left])
    return float((unsafe | open_).mean()), float(unsafe.mean())


def _halved(boxes: Array, across_fraction: Flags) -> Array:
    """Each box in two, across the fraction or the phase."""
    narrow = np.where(across_fraction[:, None], [0.5, 1.0], [1.0, 0.5])
    shift = np.where(across_fraction[:, None], [0.5, 0.0], [0.0, 0.5]) * boxes[:, 2:]
    return np.vstack(
        [np.hstack([boxes[:, :2] + sign * shift, boxes[:, 2:] * narrow]) for sign in (-1.0, 1.0)]
    )
