"""The paper's design with finite burns: burn 6 along the normal, burn 7 at a constant pitch, burn 8 at a pitch that changes
linearly and a yaw. The ends of the burns are given; durations and directions follow from the meeting.

The paper prints neither thrust nor directions: the engine is fitted to burn 6 of its table 1, the pitch rate to its cost.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from orbsoc.orbit import Elements, elements_from_state
from orbsoc.orbit.array import Array
from orbsoc.orbit.perturbations import SteeredBurn, fast_burn, fast_coast

from ..model.approach import ROWS
from .printed import TABLE
from .table_checks import forces

FORCES = forces()
EXHAUST_M_S = 3090.0
"""An isp of 315 s."""
ACCELERATION_M_S2 = 1.0687
"""At the ignition of burn 6, see `fitted_engine`."""
PITCH_RATE_RAD_S = -0.0053102
FLIGHT_PITCH_RATE_RAD_S = -0.0066141
"""Of burn 8, the cheapest for the design, and for the actual target at the epochs of the flight."""
DESIGN_ENDS_S = (89267.6305, 112704.6022, 149684.4129)
FLIGHT_ENDS_S = (89402.3031, 112773.4899, 149786.6842)
GUESS = np.array([65.5, 223.4, -0.05, 273.3, np.pi, 0.0])


@dataclass(frozen=True, slots=True, eq=False)
class Design:
    """Three burns and the orbits at their ends."""

    burns: tuple[SteeredBurn, ...]
    orbits: tuple[Elements, ...]
    miss_m: float

    @property
    def dv_m_s(self) -> float:
        return sum(burn.dv_m_s for burn in self.burns)


def finite_design(
    target: str,
    ballistic_m2_kg: float,
    ends_s: tuple[float, ...] = DESIGN_ENDS_S,
    *,
    pitch_rate_rad_s: float = PITCH_RATE_RAD_S,
) -> Design:
    """The burns that meet a target of table 1, with a given drag, at the end of burn 8."""
    row = TABLE[target]
    drag = forces(ballistic_m2_kg)
    goal = fast_coast([row.state], [row.epoch_s, ends_s[-1]], drag)[-1, 0]

    def flown(unknowns: Array) -> tuple[list[SteeredBurn], list[Array]]:
        acceleration, burns, states = ACCELERATION_M_S2, [], []
        state, at = TABLE["parking"].state, TABLE["parking"].epoch_s
        for end_s, (duration, pitch, rate, yaw) in zip(
            ends_s, _steering(unknowns, pitch_rate_rad_s), strict=True
        ):
            burn = SteeredBurn(acceleration, EXHAUST_M_S, pitch, yaw, duration, rate)
            state = fast_burn(fast_coast([state], [at, end_s - duration], FORCES)[-1, 0], burn, FORCES)
            acceleration /= burn.mass_ratio
            at = end_s
            burns.append(burn)
            states.append(state)
        return burns, states

    found = least_squares(
        lambda unknowns: ROWS @ (flown(unknowns)[1][-1] - goal), GUESS, x_scale=[1.0, 1.0, 0.01, 1.0, 0.01, 0.01],
        diff_step=1e-6, xtol=1e-12, ftol=1e-12, gtol=1e-12,
    )  # fmt: skip
    burns, states = flown(found.x)
    orbits = tuple(elements_from_state(state[:3], state[3:]) for state in states)
    return Design(tuple(burns), orbits, float(np.abs(ROWS @ (states[-1] - goal)).max()))


def _steering(unknowns: Array, rate: float) -> list[tuple[float, float, float, float]]:
    """Of each burn: duration, pitch half-way, its rate, yaw."""
    six, seven, pitch7, eight, pitch8, yaw8 = map(float, unknowns)
    return [(six, 0.0, 0.0, 0.5 * np.pi), (seven, pitch7, 0.0, 0.0), (eight, pitch8, rate, yaw8)]


def fitted_engine() -> tuple[float, float, float]:
    """Duration (s), acceleration at ignition (m/s²) and velocity change (m/s) of a normal burn that takes the parking row to
    the row after burn 6 as designed."""
    start, end = TABLE["parking"], TABLE["burn 6 design"]

    def burn(unknowns: Array) -> SteeredBurn:
        return SteeredBurn(float(unknowns[1]), EXHAUST_M_S, 0.0, 0.5 * np.pi, float(unknowns[0]))

    def miss(unknowns: Array) -> Array:
        duration = float(unknowns[0])
        before = fast_coast([start.state], [start.epoch_s, end.epoch_s - duration], FORCES)[-1, 0]
        return np.asarray(ROWS @ (fast_burn(before, burn(unknowns), FORCES) - end.state))

    found = least_squares(miss, [60.0, 1.1], x_scale=[1.0, 0.01], diff_step=1e-5)
    return float(found.x[0]), float(found.x[1]), burn(found.x).dv_m_s
