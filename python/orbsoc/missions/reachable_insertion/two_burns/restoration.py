"""A transfer corrected by Gauss–Newton steps until its flight ends on the target orbit and no coast is too low.

A step is the smallest to first order, of the directions across themselves, of durations in relative terms, and of coasts.
Steps are judged by the size of the next one (Deuflhard's natural level function), as in `smooth_burn`. Where the turn of the thrust
is bounded, a burn's directions are drawn together first, and then turn as a whole: that changes no rate but by the duration.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from orbsoc.orbit.array import Array

from ..targets.target import Target
from .flight import LowestPoint, Sensitivities, ends_of, lowest_point, sensitivities
from .limits import Limits
from .motion import Motion, lowest_of
from .transfer import Transfer, rotated
from .turning import slowed, turn_rates

ITERATIONS = 15
MISS = 1e-11
"""Of the conditions, within which a transfer has reached the orbit."""
REACHED = 1e-9
SHARES = np.array([1.0, 0.5, 0.25, 0.1, 0.03, 0.01])
SLOWED = 6
"""How often a correction that made a burn too fast is repeated."""
LONGEST_STEP = 0.5
"""Of a direction, of the logarithm of a duration, and of a coast."""


def missed(target: Target, end: Array) -> float:
    """The largest of the conditions at an end state (6,)."""
    return float(np.abs(target.conditions(end[None])).max())


@dataclass(frozen=True, slots=True, eq=False)
class Restored:
    """A transfer moved towards the orbit, its sensitivities, its lowest point between the burns, and what it still misses: the
    largest of the conditions, or what the coast is too low by. `held`: whether it had to be lifted."""

    transfer: Transfer
    found: Sensitivities
    lowest: LowestPoint
    miss: float
    held: bool

    @property
    def reaches(self) -> bool:
        return self.miss <= REACHED


def restored(motion: Motion, target: Target, limits: Limits, transfer: Transfer) -> Restored:
    """The transfer moved onto the orbit as far as that goes, and slowed down where it turns too fast."""
    transfer = limits.clipped(transfer.directed)
    if limits.rate is None:
        return _corrected(motion, target, limits, transfer)
    for _ in range(SLOWED):
        found = _corrected(motion, target, limits, slowed(transfer, limits.rate))
        transfer = found.transfer
        if not found.reaches or turn_rates(transfer).max() <= limits.rate:
            return found
    return replace(found, miss=np.inf)


def _corrected(motion: Motion, target: Target, limits: Limits, transfer: Transfer) -> Restored:
    held = False
    for last in range(ITERATIONS + 1):
        found = sensitivities(motion, transfer)
        lowest = lowest_point(motion, transfer, found)
        if not (np.isfinite(found.last.by_controls).all() and np.isfinite(lowest.by_controls).all()):
            return Restored(transfer, found, lowest, np.inf, held)
        held |= lowest.radius < limits.lowest
        miss = max(missed(target, found.end), limits.lowest - lowest.radius)
        if last == ITERATIONS or not miss > MISS:
            break
        block, rhs = target.linear_rows(found.end)
        rows = block @ found.end - rhs
        by_times, by_controls = (
            block @ found.last.by_times,
            np.einsum("ri,ikna->rkna", block, found.last.by_controls),
        )
        if held:
            rows = np.append(rows, lowest.radius - limits.lowest)
            by_times = np.vstack([by_times, lowest.by_times])
            by_controls = np.concatenate([by_controls, lowest.by_controls[None]])
        step, inverse = _smallest_step(limits, transfer, by_times, by_controls, rows)
        best = _best_share(motion, target, limits, transfer, step, inverse, rows)
        if best is None:
            break
        transfer = best
    return Restored(transfer, found, lowest, miss, held)


def _best_share(
    motion: Motion,
    target: Target,
    limits: Limits,
    transfer: Transfer,
    step: Array,
    inverse: Array,
    rows: Array,
) -> Transfer | None:
    """The transfer after the share of a step whose next step is smallest; None where none is smaller than this one."""
    level = float(np.linalg.norm(inverse @ rows))
    held = len(rows) > len(target.rows)

    def next_level(transfer: Transfer, ends: Array) -> float:
        if not np.isfinite(ends).all():
            return np.inf
        block, rhs = target.linear_rows(ends[-1])
        left = block @ ends[-1] - rhs
        if held:
            left = np.append(
                left, lowest_of(motion.coast, ends[0], float(transfer.coasts[1]))[0] - limits.lowest
            )
        return float(np.linalg.norm(inverse @ left))

    for shares in (SHARES[:1], SHARES[1:]):
        tried = [_moved(limits, transfer, share * step) for share in shares]
        levels = np.array([next_level(*each) for each in zip(tried, ends_of(motion, tried), strict=True)])
        best = int(np.nan_to_num(levels, nan=np.inf).argmin())
        if levels[best] < level * (0.5 if len(shares) == 1 else 1.0):
            return tried[best]
    return None


def _smallest_step(
    limits: Limits, transfer: Transfer, by_times: Array, by_controls: Array, rows: Array
) -> tuple[Array, Array]:
    """The step [coasts, log durations, directions], and the weighted inverse of the rows' Jacobian; with a bound on their turn,
    each burn's directions are three: a rotation vector."""
    burns, nodes = len(transfer.coasts), transfer.grid.size
    unit = transfer.controls
    slopes = by_controls - np.einsum("rkna,kna->rkn", by_controls, unit)[..., None] * unit
    weight = np.sqrt(0.5 * transfer.grid.weights)
    if limits.rate is None:
        by_directions = (slopes / weight[None, None, :, None]).reshape(len(rows), -1)
    else:
        by_directions = np.cross(unit, slopes).sum(axis=2).reshape(len(rows), -1)
    jacobian = np.hstack([by_times[:, :burns], by_times[:, burns:] * transfer.durations, by_directions])
    movable = np.ones(2 * burns, dtype=bool)
    for _ in range(2 * burns + 1):
        held = jacobian.copy()
        held[:, : 2 * burns][:, ~movable] = 0.0
        left, sizes, right = np.linalg.svd(held, full_matrices=False)
        inverse = right.T @ (left / np.maximum(sizes, 1e-10 * sizes[0])).T
        step = -inverse @ rows
        allowed = limits.open(transfer, step[: 2 * burns])
        if (allowed | ~movable).all():
            break
        movable &= allowed
    if limits.rate is None:
        step[2 * burns :] /= np.broadcast_to(weight[None, :, None], (burns, nodes, 3)).ravel()
    step /= max(1.0, float(np.abs(step).max()) / LONGEST_STEP)
    return step, inverse


def _moved(limits: Limits, transfer: Transfer, step: Array) -> Transfer:
    burns = len(transfer.coasts)
    coasts = transfer.coasts + step[:burns]
    durations = transfer.durations * np.exp(step[burns : 2 * burns])
    turns = step[2 * burns :]
    if limits.rate is None:
        controls = transfer.controls + turns.reshape(transfer.controls.shape)
    else:
        pairs = zip(transfer.controls, turns.reshape(-1, 3), strict=True)
        controls = np.array([rotated(each, turn) for each, turn in pairs])
    return limits.clipped(Transfer(transfer.grid, coasts, durations, controls).directed)
