"""The convex problem about a transfer that ends on the target orbit: the shortest burns, to first order, within a trust radius.

Unknowns are the nodal thrusts u, relaxed to ‖u‖ ≤ 1, and a step d of the times: coasts in units of their own local time, durations
in their own. Directions are meant in axes that follow the way to their ignition, so that a burn that is moved along the orbit
keeps its attitude to the orbit. The end state is x̂ + Σ S_u (u − û) + S_d d, and the target's rows hold to first order. Steps are bounded by
‖uᵢ − ûᵢ‖ ≤ ρ and |d| ≤ ρ. The balls bend the cost of u but not of d, where the optimum is as flat as a Hohmann transfer's is in
its times: the convex part of the Lagrangian's second derivatives by d, with the multipliers of the problem before, is added.

A bound on the turn of the thrust adds the cones of `attitude_rate`, with the durations as unknowns. There the ball would lend a fast
turn the way through its inside; ûᵢ·uᵢ ≥ 1 − ρ²/2, which every unit vector within ρ of ûᵢ obeys, keeps that to second order.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy import sparse

from orbsoc.conic.builder import ConicBuilder, HasPoint, Term, Variable
from orbsoc.conic.named_rows import HasDuals
from orbsoc.conic.problem import Problem
from orbsoc.guidance.powered_flight import stored
from orbsoc.orbit.array import Array

from ..model.attitude_rate import add_turns, slope_matrix
from ..targets.target import Target
from .flight import CutOff, LowestPoint, Sensitivities, sensitivities
from .limits import SHORTEST, Limits
from .motion import Motion
from .transfer import Transfer
from .turning import held_shares

ROWS = "target"
DIFFERENCE = 1e-4
"""Of times in their scales, between which slopes are compared."""


@dataclass(frozen=True, slots=True, eq=False)
class Linearised:
    """A transfer with its sensitivities, and the scales (2K,) of steps of [coasts, durations]."""

    transfer: Transfer
    found: Sensitivities
    scales: Array

    @classmethod
    def about(cls, transfer: Transfer, found: Sensitivities) -> Linearised:
        starts = found.ignitions
        local = np.linalg.norm(starts[:, :3], axis=1) / np.linalg.norm(starts[:, 3:], axis=1)
        return cls(transfer, found, np.concatenate([local, np.maximum(transfer.durations, 1e-4)]))

    def by_times(self, transfer: Transfer, by: CutOff | LowestPoint) -> Array:
        """What follows [coasts, durations] and thrust, by d (..., 2K), of this transfer or one near it: directions turn with
        their ignition."""
        swept = np.cross(
            self.found.turns.swapaxes(1, 2)[:, :, None], transfer.controls[:, None]
        )  # (K, 2K, N, 3)
        by_turns = np.einsum("...kna,kjna->...j", by.by_controls, swept)
        return np.asarray((by.by_times + by_turns) * self.scales)

    def moved(self, transfer: Transfer, step: Array) -> Transfer:
        """A transfer with this one's times, moved by a step d."""
        times = step * self.scales
        return transfer.moved(times, self.found.turns @ times)


def problem_about(
    at: Linearised,
    target: Target,
    limits: Limits,
    radius: float,
    bend: Array,
    lowest: LowestPoint | None = None,
) -> tuple[ConicBuilder, Problem]:
    """The conic problem; its cost is the change of the burns' total duration, relative to what it is, and ½ dᵀ `bend` d. The
    coast between the burns keeps to its least radius where its `lowest` point is given."""
    transfer, found = at.transfer, at.found
    burns, nodes = transfer.controls.shape[:2]
    builder = ConicBuilder()
    controls = builder.variable("controls", (burns * nodes, 3))
    times = builder.variable("times", 2 * burns)
    total = transfer.burning
    builder.cost(times, np.concatenate([np.zeros(burns), at.scales[burns:] / total]))
    builder.quadratic_cost(times, stored(bend))

    block, rhs = target.linear_rows(found.end)
    by_controls = block @ found.last.by_controls.reshape(6, -1)
    by_times = block @ at.by_times(transfer, found.last)
    size = _sizes(at, target)
    now = transfer.controls.reshape(-1)
    side = rhs - block @ found.end + by_controls @ now
    terms: list[Term] = [
        (controls, stored(by_controls / size[:, None])),
        (times, stored(by_times / size[:, None])),
    ]
    builder.equality(terms, side / size, name=ROWS)
    _bound_times(builder, at, limits, radius, times)

    pick = np.vstack([np.zeros(3), -np.eye(3)])
    balls = sparse.kron(sparse.eye_array(burns * nodes), pick)
    builder.second_order([(controls, balls)], np.tile([1.0, 0.0, 0.0, 0.0], burns * nodes), size=4)
    heads = np.hstack([np.full((burns * nodes, 1), radius), -now.reshape(-1, 3)])
    builder.second_order([(controls, balls)], heads.ravel(), size=4)
    if lowest is not None:
        by_thrust, by_step = lowest.by_controls.reshape(1, -1), at.by_times(transfer, lowest)[None]
        scale = max(float(np.abs(by_step).max()), float(np.abs(by_thrust).max()))
        spare = lowest.radius - limits.lowest - by_thrust @ now
        builder.nonnegative([(controls, -by_thrust / scale), (times, -by_step / scale)], spare / scale)
    if limits.rate is not None:
        _bound_turns(builder, at, limits.rate, radius, (controls, times))
    return builder, builder.build()


def _bound_turns(
    builder: ConicBuilder, at: Linearised, rate: float, radius: float, unknowns: tuple[Variable, Variable]
) -> None:
    """|p'| ≤ ωT/2 over each burn, and thrust on the outside of the ball."""
    (controls, times), transfer = unknowns, at.transfer
    burns, nodes = transfer.controls.shape[:2]
    each = slope_matrix(nodes)
    half = np.repeat(0.5 * rate * held_shares(transfer), len(each))
    longer = np.hstack([np.zeros((burns, burns)), np.diag(at.scales[burns:])])
    by_times = half[:, None] * np.repeat(longer, len(each), axis=0)
    slopes = sparse.kron(sparse.eye_array(burns), sparse.coo_array(each))
    add_turns(builder, controls, slopes, half * np.repeat(transfer.durations, len(each)), (times, by_times))
    now = transfer.controls.reshape(-1, 3)
    along = sparse.block_diag([-row[None] for row in now])
    builder.nonnegative([(controls, along)], np.full(burns * nodes, 0.5 * radius**2 - 1.0))


def _sizes(at: Linearised, target: Target) -> Array:
    """The largest entry of each row."""
    block = target.linear_rows(at.found.end)[0]
    by_times = np.abs(block @ at.by_times(at.transfer, at.found.last)).max(axis=1)
    by_controls = np.abs(block @ at.found.last.by_controls.reshape(6, -1)).max(axis=1)
    return np.asarray(np.maximum(by_times, by_controls))


def multipliers(builder: ConicBuilder, solution: HasDuals, at: Linearised, target: Target) -> Array:
    """Of the target's rows as they are, not as they were scaled."""
    return np.asarray(builder.dual(solution, ROWS) / _sizes(at, target))


def bend_of(motion: Motion, target: Target, at: Linearised, multiplied: Array) -> Array:
    """The convex part of the second derivatives (2K, 2K) of the rows by the times, each row times its multiplier."""
    burns = len(at.transfer.coasts)

    def slope(transfer: Transfer, found: Sensitivities) -> Array:
        return np.asarray(multiplied @ target.linear_rows(found.end)[0] @ at.by_times(transfer, found.last))

    here = slope(at.transfer, at.found)
    bend = np.zeros((2 * burns, 2 * burns))
    for k, step in enumerate(DIFFERENCE * np.eye(2 * burns)):
        moved = at.moved(at.transfer, step)
        bend[k] = (slope(moved, sensitivities(motion, moved)) - here) / DIFFERENCE
    values, vectors = np.linalg.eigh(0.5 * (bend + bend.T))
    return np.asarray(vectors * np.maximum(values, 0.0) @ vectors.T)


def _bound_times(
    builder: ConicBuilder, at: Linearised, limits: Limits, radius: float, times: Variable
) -> None:
    """|d| ≤ ρ, and times within their limits."""
    now = np.concatenate([at.transfer.coasts, at.transfer.durations])
    burns = len(at.transfer.coasts)
    low = np.concatenate([np.zeros(burns), np.full(burns, SHORTEST)])
    high = np.concatenate([[limits.ignition, limits.coast], np.full(burns, np.inf)])
    up = np.minimum(radius, (high - now) / at.scales)
    down = np.minimum(radius, (now - low) / at.scales)
    identity = np.eye(2 * burns)
    builder.nonnegative([(times, np.vstack([identity, -identity]))], np.concatenate([up, down]))
    row = np.concatenate([np.zeros(burns), at.scales[burns:]])
    builder.nonnegative([(times, row[None] / limits.burning)], [1.0 - now[burns:].sum() / limits.burning])


def stepped(builder: ConicBuilder, solution: HasPoint, at: Linearised) -> tuple[Transfer, float]:
    """The transfer at a solution, and the largest step."""
    transfer = at.transfer
    step = builder.value(solution, "times")
    controls = builder.value(solution, "controls").reshape(transfer.controls.shape)
    moved = at.moved(replace(transfer, controls=controls), step)
    new = replace(
        moved, coasts=np.maximum(moved.coasts, 0.0), durations=np.maximum(moved.durations, SHORTEST)
    )
    distance = max(
        float(np.abs(step).max()), float(np.linalg.norm(controls - transfer.controls, axis=2).max())
    )
    return new, distance
