"""A plan flown by the integrator that did not plan it: SciPy's DOP853, chaser and target each from its own epoch."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import sqrt

import numpy as np

from orbsoc.guidance.impulses import ImpulseProgramme
from orbsoc.guidance.mission import Check
from orbsoc.orbit import EARTH, ConstantsSet
from orbsoc.orbit.array import Array
from orbsoc.orbit.perturbations import EARTH_J2, J2, Force, PointMass, coast
from orbsoc.orbit.relative import local_frame, relative_state

from ..model.approach import states_at
from ..scenario import Scenario
from ..search.first_guess import elements

LIMIT_M, LIMIT_M_S = 1.0, 1e-3
"""Within which a flown plan meets the target. DOP853 itself is off by decimetres where the air's layers meet."""
RTOL, WEEKS_RTOL = 1e-11, 1e-13
"""The second of flights longer than `WEEKS_S`, whose errors grow with the square of the time."""
WEEKS_S = 2.5e5
AFTER_S, STEP_S = 12_000.0, 60.0
"""How long after the meeting the distance is told, as in the paper's figures 3 and 4, and how often."""
SAMPLE_S = 240.0
"""Between the states of the flight that are told."""


@dataclass(frozen=True, slots=True, eq=False)
class Flight:
    """Chaser states (K, 6), ECI, at times (K,), that of an impulse's time before it; of each impulse (N, 3), inertial;
    `end_state` after the last; at the end the relative state (6,) in the target's (R, T, N), and after it the distance (M,) at `after_s` (M,)."""

    times_s: Array
    chaser: Array
    dv_m_s: Array
    end_state: Array
    miss: Array
    after_s: Array
    distance_m: Array
    checks: tuple[Check, ...]

    @property
    def miss_m(self) -> float:
        return float(np.linalg.norm(self.miss[:3]))

    @property
    def miss_m_s(self) -> float:
        return float(np.linalg.norm(self.miss[3:]))

    @property
    def failures(self) -> tuple[str, ...]:
        return tuple(
            f"{each.name} by {-each.margin:.3g} {each.unit}" for each in self.checks if each.margin < 0.0
        )


@dataclass(frozen=True, slots=True)
class OneOblate:
    """`PointMass` and `J2` on one state, in plain floats: weeks of flight in a fifth of the time."""

    constants: ConstantsSet = EARTH
    j2: float = EARTH_J2

    def acceleration(self, states: Array) -> Array:
        """m/s², (1, 3), at one state (1, 6)."""
        x, y, z = states[0, :3].tolist()
        square = x * x + y * y + z * z
        pull = -self.constants.mu_m3_s2 / (square * sqrt(square))
        oblate = 1.5 * self.j2 * self.constants.earth_radius_m**2 / square
        ratio = 5.0 * z * z / square
        across = pull * (1.0 + oblate * (1.0 - ratio))
        return np.array([[across * x, across * y, pull * (1.0 + oblate * (3.0 - ratio)) * z]])

    def jacobian(self, states: Array) -> Array:
        """Derivatives (1, 3, 6)."""
        return PointMass(self.constants).jacobian(states) + J2(self.constants, self.j2).jacobian(states)


def fly(scenario: Scenario, programme: ImpulseProgramme, end_s: float) -> Flight:
    """Fly a programme, in the chaser's (R, T, N), to the meeting at `end_s` and on. Raises PropagationError."""
    forces: Sequence[Force] = scenario.forces_on(scenario.chaser.ballistic_m2_kg)
    if scenario.forces == ("j2",):
        forces = [OneOblate(scenario.constants, scenario.constants.j2)]
    state, at = scenario.chaser.state, scenario.chaser.epoch_s
    times: list[Array] = []
    states: list[Array] = []
    kicks: list[Array] = []
    checks: list[Check] = []
    rtol = WEEKS_RTOL if end_s - at > WEEKS_S else RTOL
    stops = [*zip(programme.times_s.tolist(), programme.dv_m_s, strict=True)]
    if not stops or stops[-1][0] < end_s:
        stops.append((end_s, np.zeros(3)))
    for number, (t, dv) in enumerate(stops):
        inside = np.linspace(at, t, 2 + int((t - at) / SAMPLE_S)) if t > at else np.array([at])
        arc = coast([state], inside, forces, rtol=rtol)[:, 0] if t > at else state[None]
        times.append(inside if number == 0 else inside[1:])
        states.append(arc if number == 0 else arc[1:])
        state, at = arc[-1].copy(), t
        kicks.append(local_frame(state)[0].T @ dv)
        state[3:] += kicks[-1]
        if t < end_s:
            checks += _limits(scenario, state, t, number + 1)
    drag = scenario.forces_on(scenario.target.ballistic_m2_kg)
    after = np.arange(0.0, AFTER_S + STEP_S, STEP_S)
    target = scenario.target
    if target.motion == "mean_j2":
        goal = states_at(scenario, "target", end_s + after)
    else:
        goal = coast([target.state], np.append(target.epoch_s, end_s + after), drag, rtol=rtol)[1:, 0]
    follower = coast([state], end_s + after, forces, rtol=rtol)[:, 0]
    miss = relative_state(goal[0], state)
    met = [
        Check("meeting, position", LIMIT_M - float(np.linalg.norm(miss[:3])), "m", end_s),
        Check("meeting, velocity", LIMIT_M_S - float(np.linalg.norm(miss[3:])), "m/s", end_s),
    ]
    distance = np.linalg.norm(follower[:, :3] - goal[:, :3], axis=1)
    return Flight(
        np.concatenate(times),
        np.concatenate(states),
        np.array(kicks),
        state,
        miss,
        end_s + after,
        distance,
        (*met, *checks),
    )


def _limits(scenario: Scenario, state: Array, t: float, number: int) -> list[Check]:
    """Of the osculating orbit after an impulse."""
    orbit, limits = elements(state, scenario.constants), scenario.limits
    low, high = 1e-3 * orbit.perigee_height_m(), 1e-3 * orbit.apogee_height_m()
    return [
        Check(f"perigee after impulse {number}", low - limits.perigee_height_km, "km", t),
        Check(f"apogee after impulse {number}", limits.apogee_height_km - high, "km", t),
    ]
