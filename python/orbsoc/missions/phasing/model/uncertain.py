"""How sure the meeting is: linear covariance along the transition matrices, and draws of the distance that follows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.stats import norm

from orbsoc.orbit.array import Array
from orbsoc.orbit.perturbations import fast_coast_with_transitions
from orbsoc.orbit.relative import local_frame

from ..scenario import Errors
from .approach import Approach, Roll, approach_at

FOLLOWED_S, STEP_S = 11_000.0, 110.0
"""Two revolutions after the meeting, in which the least distance is looked for."""
DRAG_STEP = 0.2
"""Of the target's ballistic coefficient, for its effect by a difference."""


@dataclass(frozen=True, slots=True, eq=False)
class Meeting:
    """Covariance (6, 6) of chaser less target at the meeting in the target's (R, T, N), SI; of the draws the percentiles 5, 50
    and 95 of the least and the largest distance afterwards, and the shares that come within limits."""

    covariance: Array
    least_m: Array
    largest_m: Array
    within: float
    """Share of the draws that come within `distance_km`; NaN without draws."""

    @property
    def sigmas_m(self) -> Array:
        """Of R, T, N."""
        return np.sqrt(np.diag(self.covariance)[:3])


def impulse_covariance(dv_m_s: Array, errors: Errors) -> Array:
    """Of an impulse as fired, (3, 3): a share of its size, and an angle about each axis across it."""
    size = float(np.linalg.norm(dv_m_s))
    if size == 0.0:
        return np.zeros((3, 3))
    along = np.outer(dv_m_s, dv_m_s)
    across = size**2 * np.eye(3) - along
    return np.asarray(errors.execution_share**2 * along + np.deg2rad(errors.execution_deg) ** 2 * across)


def target_covariance(approach: Approach, errors: Errors) -> Array:
    """Of the target's state at the meeting, inertial, (6, 6): of its state at its epoch, and of its drag."""
    scenario, target = approach.scenario, approach.scenario.target
    axes = np.kron(np.eye(2), local_frame(target.state)[0].T)
    known = axes @ np.diag(np.square([*errors.position_m, *errors.velocity_m_s])) @ axes.T
    forces = scenario.forces_on(target.ballistic_m2_kg)
    _, matrices = fast_coast_with_transitions([target.state], [target.epoch_s, approach.end_s], forces)
    found = matrices[-1, 0] @ known @ matrices[-1, 0].T
    if errors.ballistic_m2_kg and "drag" in scenario.forces:
        step = DRAG_STEP * errors.ballistic_m2_kg
        other = approach_at(scenario, approach.times_s[[-1]], ballistic_m2_kg=target.ballistic_m2_kg + step)
        by_drag = (other.goal - approach.goal) / step
        found = found + errors.ballistic_m2_kg**2 * np.outer(by_drag, by_drag)
    return np.asarray(found)


@dataclass(frozen=True, slots=True, eq=False)
class Chance:
    """P(|T| < distance at the meeting) ≥ probability, for T is nearly all of the distance, and normal: a limit on its standard
    deviation, of which the target has `fixed_m`; what an impulse adds follows from its size and its direction."""

    errors: Errors
    limit_m: float
    fixed_m: float
    along: Array
    """T of the target at the meeting, inertial, (3,)."""

    @classmethod
    def of(cls, approach: Approach) -> Chance | None:
        """What the scenario asks for; None if it asks for no probability."""
        errors = approach.scenario.uncertainty
        if errors is None or errors.probability is None:
            return None
        along = local_frame(approach.goal)[0][1]
        fixed = along @ target_covariance(approach, errors)[:3, :3] @ along
        sigmas = float(norm.ppf(0.5 + 0.5 * errors.probability))
        return cls(errors, 1e3 * errors.distance_km / sigmas, float(np.sqrt(fixed)), along)

    def slopes_s(self, approach: Approach, roll: Roll) -> Array:
        """Standard deviation of T by m/s of each impulse (K,), in the direction that it has in a flight, or along the motion."""
        found = np.empty(len(roll.dv_m_s))
        for k, dv in enumerate(roll.dv_m_s):
            size = float(np.linalg.norm(dv))
            unit = dv / size if size else approach.axes(roll, k)[1]
            pull = self.along @ roll.to_end[k][:3, 3:]
            found[k] = np.sqrt(pull @ impulse_covariance(unit, self.errors) @ pull)
        return found

    def sigma_m(self, approach: Approach, roll: Roll) -> float:
        """Of T at the meeting."""
        sizes = np.linalg.norm(roll.dv_m_s, axis=1)
        return float(np.linalg.norm(np.append(self.slopes_s(approach, roll) * sizes, self.fixed_m)))


def meeting(approach: Approach, roll: Roll, errors: Errors) -> Meeting:
    """Of a flight by impulses as planned, without planning again."""
    found = target_covariance(approach, errors)
    for k in np.flatnonzero(np.any(roll.dv_m_s, axis=1)):
        effect = roll.to_end[k][:, 3:]
        found = found + effect @ impulse_covariance(roll.dv_m_s[k], errors) @ effect.T
    turn = np.kron(np.eye(2), local_frame(approach.goal)[0])
    least, largest = _draws(approach, found, errors)
    quantiles = [5.0, 50.0, 95.0]
    if not errors.runs:
        nothing = np.full(3, np.nan)
        return Meeting(turn @ found @ turn.T, nothing, nothing, float("nan"))
    return Meeting(
        turn @ found @ turn.T, np.percentile(least, quantiles), np.percentile(largest, quantiles),
        float(np.mean(least <= 1e3 * errors.distance_km)),
    )  # fmt: skip


def _draws(approach: Approach, covariance: Array, errors: Errors) -> tuple[Array, Array]:
    """Least and largest distances (runs,) over two revolutions after the meeting, to first order about the target."""
    scenario = approach.scenario
    random = np.random.default_rng(errors.seed)
    values, vectors = np.linalg.eigh(covariance)
    spread = vectors * np.sqrt(np.maximum(values, 0.0))
    states = random.standard_normal((errors.runs, 6)) @ spread.T
    times = np.arange(0.0, FOLLOWED_S + STEP_S, STEP_S)
    forces = scenario.forces_on(scenario.target.ballistic_m2_kg)
    _, matrices = fast_coast_with_transitions([approach.goal], times, forces)
    least, largest = np.full(errors.runs, np.inf), np.zeros(errors.runs)
    for matrix in matrices[:, 0, :3]:
        distance = np.linalg.norm(states @ matrix.T, axis=1)
        np.minimum(least, distance, out=least)
        np.maximum(largest, distance, out=largest)
    return least, largest
