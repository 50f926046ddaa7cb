"""Finite burns that stand for impulses: each centred on its impulse's time, with an inertially fixed direction, then two
corrections of all by the transition matrices."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import exp

import numpy as np

from orbsoc.orbit import PropagationError
from orbsoc.orbit.array import Array
from orbsoc.orbit.perturbations import SteeredBurn, fast_burn, fast_coast
from orbsoc.orbit.relative import local_frame

from ..model.approach import ROWS, Approach, Roll, state_at
from ..scenario import Engine, Scenario


@dataclass(frozen=True, slots=True, eq=False)
class FiniteBurns:
    """Burns with their ignition times, what they cost, and by how much the last one's end misses the target."""

    ignition_s: Array
    burns: tuple[SteeredBurn, ...]
    miss: Array
    uncorrected_m: float = float("inf")
    """By which the burns miss before they are corrected."""

    @property
    def dv_m_s(self) -> float:
        return sum(burn.dv_m_s for burn in self.burns)

    @property
    def mass_ratio(self) -> float:
        """Of the end to before the first burn."""
        return float(np.prod([burn.mass_ratio for burn in self.burns]))

    @property
    def longest_s(self) -> float:
        return max(burn.duration_s for burn in self.burns)

    @property
    def diverged(self) -> bool:
        """Whether the corrections led further away."""
        return self.miss_m > self.uncorrected_m

    @property
    def miss_m(self) -> float:
        return float(np.linalg.norm(self.miss[:3]))

    @property
    def miss_m_s(self) -> float:
        return float(np.linalg.norm(self.miss[3:]))


def finite_burns(approach: Approach, roll: Roll, engine: Engine, *, corrections: int = 2) -> FiniteBurns:
    """Of a flight by impulses; every correction changes each burn in proportion to its size.

    Raises PropagationError where a burn would begin before the one before it has ended: the engine is too weak.
    """
    dv = roll.dv_m_s.copy()
    found = first = _flown(approach, roll, dv, engine)
    weights = np.repeat(np.linalg.norm(dv, axis=1), 3)
    effect = ROWS @ np.concatenate(roll.to_end[:, :, 3:], axis=1)
    least = weights[:, None] * effect.T
    for _ in range(corrections):
        step = np.linalg.solve(effect @ least, ROWS @ found.miss)
        dv = dv - (least @ step).reshape(-1, 3)
        found = _flown(approach, roll, dv, engine)
    return replace(found, uncorrected_m=first.miss_m)


def _flown(approach: Approach, roll: Roll, dv: Array, engine: Engine) -> FiniteBurns:
    scenario = approach.scenario
    forces = scenario.forces_on(scenario.chaser.ballistic_m2_kg)
    state, at = scenario.chaser.state, scenario.chaser.epoch_s
    acceleration, ignitions, burns = engine.acceleration_m_s2, [], []
    for k in np.flatnonzero(np.any(roll.dv_m_s, axis=1)):
        burn = _burn(approach, roll, int(k), dv[k], acceleration, engine.exhaust_m_s)
        ignition = float(approach.times_s[k]) - 0.5 * burn.duration_s
        if ignition < at:
            raise PropagationError(f"a burn of {burn.duration_s:.4g} s has no room before its impulse's time")
        state = fast_coast([state], [at, ignition], forces)[-1, 0]
        state = fast_burn(state, burn, forces)
        at = ignition + burn.duration_s
        acceleration /= burn.mass_ratio
        ignitions.append(ignition)
        burns.append(burn)
    return FiniteBurns(np.array(ignitions), tuple(burns), state - _goal(approach, at))


def _goal(approach: Approach, at_s: float) -> Array:
    """The target's state at the end of the last burn, by the drag of the approach's own goal."""
    scenario: Scenario = approach.scenario
    if at_s <= approach.end_s:
        return state_at(scenario, "target", at_s)
    forces = scenario.forces_on(scenario.target.ballistic_m2_kg)
    return np.asarray(fast_coast([approach.goal], [approach.end_s, at_s], forces)[-1, 0])


def _burn(
    approach: Approach, roll: Roll, k: int, dv: Array, acceleration: float, exhaust: float
) -> SteeredBurn:
    """Its direction, seen from the frame that turns with the orbit, pitches up at the orbit's rate."""
    axes, rate = local_frame(roll.states[k])
    outward, along, normal = axes @ dv
    size = float(np.linalg.norm(dv))
    return SteeredBurn(
        acceleration_m_s2=acceleration,
        exhaust_m_s=exhaust,
        pitch_rad=float(np.arctan2(outward, along)),
        yaw_rad=float(np.arcsin(np.clip(normal / size, -1.0, 1.0))),
        duration_s=exhaust / acceleration * (1.0 - exp(-size / exhaust)),
        pitch_rate_rad_s=float(rate[2]),
    )
