"""The convex problem about a transfer that ends on the target orbit: the shortest burns, to first order, within a trust radius.

Unknowns are the nodal thrusts u, relaxed to ‖u‖ ≤ 1, and a step d of the times: coasts in units of their own local time, durations
in their own. The end state is x̂ + Σ S_u (u − û) + S_d d, and the target's rows hold to first order. Steps are bounded by
‖uᵢ − ûᵢ‖ ≤ ρ and |d| ≤ ρ.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from orbsoc.conic.builder import ConicBuilder, HasPoint, Variable
from orbsoc.conic.problem import Problem
from orbsoc.guidance.powered_flight import stored

from ..any_target import AnyTarget
from .flight import Sensitivities
from .limits import SHORTEST, Limits
from .transfer import Transfer

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Linearised:
    """A transfer with its sensitivities, and the scales (2K,) of steps of [coasts, durations]."""

    transfer: Transfer
    found: Sensitivities
    scales: Array

    @classmethod
    def about(cls, transfer: Transfer, found: Sensitivities) -> Linearised:
        starts = found.states[:, 0]
        local = np.linalg.norm(starts[:, :3], axis=1) / np.linalg.norm(starts[:, 3:], axis=1)
        return cls(transfer, found, np.concatenate([local, np.maximum(transfer.durations, 1e-4)]))


def problem_about(
    at: Linearised, target: AnyTarget, limits: Limits, radius: float
) -> tuple[ConicBuilder, Problem]:
    """The conic problem; its cost is the change of the burns' total duration, relative to what it is."""
    transfer, found = at.transfer, at.found
    burns, nodes = transfer.controls.shape[:2]
    builder = ConicBuilder()
    controls = builder.variable("controls", (burns * nodes, 3))
    times = builder.variable("times", 2 * burns)
    total = transfer.burning
    builder.cost(times, np.concatenate([np.zeros(burns), at.scales[burns:] / total]))

    block, rhs = target.linear_rows(found.end)
    by_controls = block @ found.by_controls.reshape(6, -1)
    by_times = block @ np.hstack([found.by_coasts, found.by_durations]) * at.scales
    size = np.abs(np.hstack([by_times, by_controls])).max(axis=1, keepdims=True)
    now = transfer.controls.reshape(-1)
    side = rhs - block @ found.end + by_controls @ now
    builder.equality(
        [(controls, stored(by_controls / size)), (times, stored(by_times / size))], side / size[:, 0]
    )
    _bound_times(builder, at, limits, radius, times)

    pick = np.vstack([np.zeros(3), -np.eye(3)])
    balls = sparse.kron(sparse.eye_array(burns * nodes), pick)
    builder.second_order([(controls, balls)], np.tile([1.0, 0.0, 0.0, 0.0], burns * nodes), size=4)
    heads = np.hstack([np.full((burns * nodes, 1), radius), -now.reshape(-1, 3)])
    builder.second_order([(controls, balls)], heads.ravel(), size=4)
    return builder, builder.build()


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
    burns = len(transfer.coasts)
    step = builder.value(solution, "times")
    moved = step * at.scales
    controls = builder.value(solution, "controls").reshape(transfer.controls.shape)
    new = Transfer(
        transfer.grid,
        np.maximum(transfer.coasts + moved[:burns], 0.0),
        np.maximum(transfer.durations + moved[burns:], SHORTEST),
        controls,
    )
    distance = max(
        float(np.abs(step).max()), float(np.linalg.norm(controls - transfer.controls, axis=2).max())
    )
    return new, distance
