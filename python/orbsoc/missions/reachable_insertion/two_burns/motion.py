"""How a vehicle moves between its burns and in them, canonical: two-body coasts in closed form, or coasts with J2.

The sensitivities of a two-body coast are central differences of neighbouring coasts; those of a coast with J2 are the variational
equation's, integrated by the compiled core.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from orbsoc.guidance.powered_flight import Burn
from orbsoc.orbit import EARTH, CanonicalUnits, PropagationError, rotate_state
from orbsoc.orbit.array import Array
from orbsoc.orbit.kepler import coasted_in_closed_form
from orbsoc.orbit.perturbations import Force, fast_coast, fast_coast_with_transitions

from ..model.coast import oblate
from ..search.setup import InsertionSetup

DIFFERENCE = 1e-5
"""Half the distance of neighbouring flights, canonical."""


class Coast(Protocol):
    """States without thrust, in the axes of plans; NaN where an integrator gives up."""

    @property
    def oblate(self) -> bool:
        """Whether J2 acts."""
        ...

    def ends(self, states: Array, times: Array) -> Array:
        """States (B, 6) after times (B,), each its own."""
        ...

    def way(self, state: Array, times: Array) -> Array:
        """States (K, 6) on the way of one state, at times (K,) that increase from 0."""
        ...

    def transition(self, state: Array, time: float) -> tuple[Array, Array]:
        """The state (6,) after a time, and the transition matrix (6, 6)."""
        ...

    def rate(self, state: Array) -> Array:
        """[v, a] of a state (6,)."""
        ...


@dataclass(frozen=True, slots=True)
class TwoBodyCoast:
    """About a point mass, in closed form."""

    oblate: bool = False

    def ends(self, states: Array, times: Array) -> Array:
        return coasted_in_closed_form(states, times)

    def way(self, state: Array, times: Array) -> Array:
        return coasted_in_closed_form(np.tile(state, (len(times), 1)), times)

    def transition(self, state: Array, time: float) -> tuple[Array, Array]:
        moved = np.vstack([state, state + DIFFERENCE * np.eye(6), state - DIFFERENCE * np.eye(6)])
        ends = coasted_in_closed_form(moved, np.full(len(moved), time))
        return ends[0], (ends[1:7] - ends[7:]).T / (2.0 * DIFFERENCE)

    def rate(self, state: Array) -> Array:
        return np.concatenate([state[3:], -state[:3] / float(np.linalg.norm(state[:3])) ** 3])


@dataclass(frozen=True, slots=True, eq=False)
class OblateCoast:
    """About the oblate Earth, by the compiled core; `to_eci` (3, 3) turns the axes of plans into those of the pole."""

    to_eci: Array
    units: CanonicalUnits
    forces: tuple[Force, ...] = oblate(EARTH)
    oblate: bool = True

    def ends(self, states: Array, times: Array) -> Array:
        pairs = zip(states, times, strict=True)
        return np.array([self.way(state, np.array([0.0, time]))[-1] for state, time in pairs])

    def way(self, state: Array, times: Array) -> Array:
        if not times[-1] > 0.0:
            return np.tile(state, (len(times), 1))
        try:
            found = fast_coast(self._si(state)[None], times * self.units.time_s, self.forces)
        except PropagationError:
            return np.full((len(times), 6), np.nan)
        return self._canonical(found[:, 0])

    def transition(self, state: Array, time: float) -> tuple[Array, Array]:
        if not time > 0.0:
            return state, np.eye(6)
        times_s = np.array([0.0, time * self.units.time_s])
        try:
            found, matrices = fast_coast_with_transitions(self._si(state)[None], times_s, self.forces)
        except PropagationError:
            return np.full(6, np.nan), np.full((6, 6), np.nan)
        turned = np.kron(np.eye(2), self.to_eci)
        scale = np.repeat([self.units.length_m, self.units.speed_m_s], 3)
        return self._canonical(found[-1, 0]), turned.T @ (matrices[-1, 0] / scale[:, None] * scale) @ turned

    def rate(self, state: Array) -> Array:
        pull = sum(force.acceleration(self._si(state)[None])[0] for force in self.forces)
        return np.concatenate([state[3:], self.to_eci.T @ pull / self.units.acceleration_m_s2])

    def _si(self, state: Array) -> Array:
        """In ECI."""
        return rotate_state(self.to_eci, self.units.state_to_si(state))

    def _canonical(self, states: Array) -> Array:
        return np.asarray(self.units.state_from_si(rotate_state(self.to_eci.T, states)))


LOOKS = 65
"""Points of a coast among which the lowest is sought."""
LOWERED = 3
"""Steps towards the lowest point, from the lowest of these."""


def lowest_of(coast: Coast, state: Array, time: float) -> tuple[float, float]:
    """The least radius on the way of a state (6,), and when it is there, in [0, `time`]; NaN where the coast cannot be flown."""
    times = np.linspace(0.0, max(time, 0.0), LOOKS)
    radii = np.linalg.norm(coast.way(state, times)[:, :3], axis=1)
    k = int(np.nan_to_num(radii, nan=-np.inf).argmin())
    when, radius = float(times[k]), float(radii[k])
    early, late = float(times[max(k - 1, 0)]), float(times[min(k + 1, LOOKS - 1)])
    for _ in range(LOWERED):
        found = coast.way(state, np.array([0.0, when]))[-1] if when > 0.0 else state
        bend = float(found[3:] @ found[3:] + found[:3] @ coast.rate(found)[3:])
        if not bend > 0.0:
            break
        when = float(np.clip(when - found[:3] @ found[3:] / bend, early, late))
        radius = min(radius, float(np.linalg.norm(found[:3])))
    return radius, when


@dataclass(frozen=True, slots=True)
class Motion:
    """The engine, from the scenario's state on, and the coasts."""

    burn: Burn
    coast: Coast

    @classmethod
    def of(cls, ready: InsertionSetup) -> Motion:
        forces = oblate(ready.scenario.constants)
        coast = OblateCoast(ready.scenario.eci_rotation, ready.units, forces)
        return cls(ready.burn, coast if ready.scenario.burn.coast_j2 else TwoBodyCoast())
