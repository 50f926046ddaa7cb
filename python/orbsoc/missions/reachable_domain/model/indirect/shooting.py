"""Newton's method on the indirect equations: what the convex sequence approaches, found to the last digits.

Unknowns of a point are the initial primer (p₀, ṗ₀) and a multiplier ν of each terminal row; equations are
λ(t_f) = ∇J + Σ ν ∇c with λ = (−ṗ, p), and c = 0 of the active rows. The perigee row is smooth in the form
|H|²/(2ρ²) − 1/ρ − E ≥ 0 (the squared radial velocity at ρ is not positive ⇔ r_p ≥ ρ). It is active where the perigee
is to be at its bound, and else where it has to be: a point that ends with a negative value or multiplier is solved again the other way.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orbsoc.guidance.collocation import differentiation_matrix, interpolation_matrix
from orbsoc.guidance.powered_flight import Burn
from orbsoc.orbit.array import Array, Flags, Index

from ..batch import Batch
from ..direct.arcs import Collocation
from ..direct.sequence import Sequences
from ..direct.terminal import LargestOrbit
from .conditions import DIRECTION, PERIGEE, ROWS, conditions, curvature
from .primer import Extremals, extremals, sensitivity

TOLERANCE = 1e-10
"""Largest residual, canonical, of a converged point."""
MAX_STEPS = 20
HALVINGS = 4
STEADY = 0.01
"""A step that leaves a smaller fraction of the residual is followed by one with the same matrix."""
STALLED, STALLS = 0.7, 3
"""A point is given up after STALLS steps in a row that each leave more than the fraction STALLED of the residual."""
SWITCHES = 3
"""How often the perigee row may change sides."""


@dataclass(slots=True, eq=False)
class Unknowns(Batch):
    """Initial primers [p₀, ṗ₀] (B, 6), multipliers (B, 4), and the active rows (B, 4)."""

    primers: Array
    multipliers: Array
    active: Flags


@dataclass(frozen=True, slots=True, eq=False)
class Extrema:
    """What Newton arrived at for B points: the unknowns, the extremals, the largest residual (B,), its steps (B,)."""

    unknowns: Unknowns
    flown: Extremals
    residual: Array
    steps: NDArray[np.int32]

    @property
    def converged(self) -> Flags:
        return self.residual <= TOLERANCE

    def put(self, which: Index, other: Extrema) -> None:
        """Overwrite some points by other attempts at them, in place, adding up the steps."""
        self.unknowns.put(which, other.unknowns)
        self.flown.put(which, other.flown)
        self.residual[which] = other.residual
        self.steps[which] += other.steps


@dataclass(frozen=True, slots=True, eq=False)
class Indirect:
    """One vehicle and burn time for which extremals are sought, with the number of Gauss steps of an extremal."""

    burn: Burn
    duration: float
    steps: int = 12

    def solve(self, target: LargestOrbit, start: Unknowns) -> Extrema:
        """Newton from `start`."""
        count = len(target)
        found = start.copy()
        if target.perigee_at_bound:
            found.active[:, PERIGEE] = True
        flown, residual = self.flown(found), np.full(count, np.inf)
        steps = np.zeros(count, np.int32)
        todo = np.arange(count)
        for _ in range(SWITCHES):
            part, arrived = found[todo], flown if todo.size == count else flown[todo]
            residual[todo], taken = self._newton(target[todo], part, arrived)
            if arrived is not flown:
                flown.put(todo, arrived)
            steps[todo] += taken
            found.put(todo, part)
            if target.perigee_at_bound:
                break
            todo = todo[self._wrong_side(target[todo], found[todo], flown.ends[todo, :6], residual[todo])]
            if not todo.size:
                break
            found.active[todo, PERIGEE] ^= True
            residual[todo] = np.inf
        return Extrema(found, flown, residual, steps)

    def flown(self, unknowns: Unknowns) -> Extremals:
        """The extremals themselves."""
        return extremals(self.burn, self.duration, unknowns.primers, steps=self.steps)

    def _wrong_side(self, target: LargestOrbit, at: Unknowns, ends: Array, residual: Array) -> Flags:
        value = conditions(target, ends).values[:, PERIGEE]
        active = at.active[:, PERIGEE]
        wrong = np.where(active, at.multipliers[:, PERIGEE] < -1e-9, value < -1e-9)
        return np.asarray(wrong & (residual <= TOLERANCE))

    def _newton(
        self, target: LargestOrbit, at: Unknowns, arrived: Extremals
    ) -> tuple[Array, NDArray[np.int32]]:
        """Damped Newton, in place on `at` and its extremals; residuals and steps taken. Points that stall are left."""
        count = len(target)
        size = _size(residuals(target, arrived.ends, at))
        steps, stalls = np.zeros(count, np.int32), np.zeros(count, np.int32)
        live = np.flatnonzero((size > TOLERANCE) & np.isfinite(size))
        flown = arrived[live]
        matrix, old = np.empty((live.size, 6 + ROWS, 6 + ROWS)), np.ones(live.size, bool)
        for _ in range(MAX_STEPS):
            if not live.size:
                break
            here, before = at[live], size[live]
            stale = np.flatnonzero(old)
            if stale.size:
                matrix[stale] = self._matrix(target[live[stale]], here[stale], flown[stale])
            step = _solved(matrix, residuals(target[live], flown.ends, here))
            steps[live] += 1
            size[live] = self._backtrack(target[live], here, flown, step, before)
            at.put(live, here)
            stalls[live] = np.where(size[live] > STALLED * before, stalls[live] + 1, 0)
            going = (size[live] < before) & (size[live] > TOLERANCE) & (stalls[live] < STALLS)
            old = (size[live] > STEADY * before)[going]
            if not going.all():
                arrived.put(live[~going], flown[np.flatnonzero(~going)])
                live, flown, matrix = live[going], flown[np.flatnonzero(going)], matrix[going]
        arrived.put(live, flown)
        return size, steps

    def _matrix(self, target: LargestOrbit, at: Unknowns, flown: Extremals) -> Array:
        """Derivatives of `residuals` by [p₀, ṗ₀, ν], (B, 10, 10)."""
        ends = flown.ends[:, :6]
        by_start = sensitivity(self.burn, flown)
        here = conditions(target, ends)
        bend = curvature(target, ends, at.multipliers)
        matrix = np.zeros((len(ends), 6 + ROWS, 6 + ROWS))
        matrix[:, :3, :6], matrix[:, 3:6, :6] = -by_start[:, 9:], by_start[:, 6:9]
        matrix[:, :6, :6] -= bend @ by_start[:, :6]
        matrix[:, :6, 6:] = -here.gradients.swapaxes(1, 2)
        matrix[:, 6:, :6] = np.where(at.active[:, :, None], here.gradients @ by_start[:, :6], 0.0)
        k = np.arange(ROWS)
        matrix[:, 6 + k, 6 + k] = np.where(at.active, 0.0, 1.0)
        matrix[~np.isfinite(matrix).all(axis=(1, 2))] = np.eye(6 + ROWS)
        return matrix

    def _backtrack(
        self, target: LargestOrbit, at: Unknowns, flown: Extremals, step: Array, size: Array
    ) -> Array:
        """Move by the longest of the halved steps that makes the residual smaller, in place on `at` and `flown`, and
        stay where none does; the residuals (B,)."""
        found = size.copy()
        left = np.arange(len(size))
        share = 1.0
        for _ in range(HALVINGS):
            here = at[left]
            trial = Unknowns(
                here.primers + share * step[left, :6], here.multipliers + share * step[left, 6:], here.active
            )
            there = self.flown(trial)
            trial_size = _size(residuals(target[left], there.ends, trial))
            good = np.flatnonzero(trial_size < size[left])
            at.put(left[good], trial[good])
            flown.put(left[good], there[good])
            found[left[good]] = trial_size[good]
            left = np.delete(left, good)
            if not left.size:
                break
            share *= 0.5
        return found


def _solved(matrix: Array, values: Array) -> Array:
    """Newton's step (B, 10); none where a residual is not finite."""
    values = np.where(np.isfinite(values).all(axis=1, keepdims=True), values, 0.0)
    try:
        return np.asarray(-np.linalg.solve(matrix, values[:, :, None])[:, :, 0])
    except np.linalg.LinAlgError:
        return np.asarray(-(np.linalg.pinv(matrix) @ values[:, :, None])[:, :, 0])


def residuals(target: LargestOrbit, flown_ends: Array, at: Unknowns) -> Array:
    """λ(t_f) − ∇J − Σ ν ∇c and the active rows' values (ν itself where a row is not active), (B, 10)."""
    here = conditions(target, flown_ends[:, :6])
    costate = np.concatenate([-flown_ends[:, 9:], flown_ends[:, 6:9]], axis=1)
    slope = here.objective + (at.multipliers[:, :, None] * here.gradients).sum(axis=1)
    rows = np.where(at.active, here.values, at.multipliers)
    return np.concatenate([costate - slope, rows], axis=1)


def from_sequences(
    collocation: Collocation, target: LargestOrbit, found: Sequences, which: Index
) -> Unknowns:
    """Unknowns read off the multipliers of the last convex subproblems of the points `which`."""
    arcs, part = found.arcs[which], target[which]
    linear = collocation.end_map(arcs)
    rows = part.rows(arcs.ends)
    p = rows.equal.shape[1]
    costate = -rows.cost - (arcs.multipliers[:, :p, None] * rows.equal).sum(axis=1)
    perigee = rows.cone if rows.cone.shape[1] else rows.bound
    costate -= (arcs.multipliers[:, 3 : 3 + perigee.shape[1], None] * perigee).sum(axis=1)
    nodes = (costate[:, None] @ linear.by_control)[:, 0].reshape(arcs.controls.shape)
    nodes = nodes / (0.5 * collocation.duration * collocation.grid.weights * collocation.thrust)[:, None]
    here = conditions(part, arcs.ends)
    active = np.ones(here.values.shape, bool)
    active[:, DIRECTION] = part.perigee_direction is not None
    active[:, PERIGEE] = here.values[:, PERIGEE] < 1e-6
    weights = np.where(active[:, :, None], here.gradients, 0.0)
    fitted = np.linalg.pinv(weights.swapaxes(1, 2), rcond=1e-12) @ (costate - here.objective)[:, :, None]
    return Unknowns(_initial_primers(collocation, nodes), np.where(active, fitted[:, :, 0], 0.0), active)


def _initial_primers(collocation: Collocation, nodes: Array) -> Array:
    """[p, ṗ] at ignition from the polynomial through the primer at the nodes, (B, 6)."""
    points = collocation.grid.nodes
    value = interpolation_matrix(points, [-1.0])
    slope = value @ differentiation_matrix(points) / (0.5 * collocation.duration)
    return np.concatenate([(value @ nodes)[:, 0], (slope @ nodes)[:, 0]], axis=1)


def _size(values: Array) -> Array:
    largest = np.abs(values).max(axis=1)
    return np.where(np.isfinite(largest), largest, np.inf)
