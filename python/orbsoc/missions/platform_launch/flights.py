"""The rendezvous flown about the Earth: target and server each by Newton's law, impulses corrected until they meet."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import degrees
from typing import Any

import numpy as np
from numpy.typing import NDArray

from orbsoc.guidance.chaser_messages import chaser_messages
from orbsoc.guidance.impulses import KICK, ImpulseProgramme
from orbsoc.guidance.relative_flight import BALLISTIC_M2_KG, Forces, RelativeFlight, fly
from orbsoc.orbit import ConstantsSet, Elements, elements_from_state
from orbsoc.orbit.perturbations import J2, Drag, Force, PointMass
from orbsoc.orbit.relative import absolute_state, local_frame

from .launch import axes
from .scenario import Scenario
from .separation import Separation

Array = NDArray[np.float64]

SAMPLES = 121
ROUNDS = 12
"""Of the correction, at most."""
MET_M = 1e-5
"""Within which the correction ends; the state is known to about 1e-7 m."""


def two_body(constants: ConstantsSet) -> Forces:
    """Newton's law alone."""
    return lambda _: [PointMass(constants)]


def oblate_with_drag(constants: ConstantsSet) -> Forces:
    """With J₂ and the drag of two different bodies."""

    def forces(pairs: int) -> Sequence[Force]:
        return [PointMass(constants), J2(constants), Drag(np.tile(BALLISTIC_M2_KG, pairs), constants)]

    return forces


@dataclass(frozen=True, slots=True, eq=False)
class Flown:
    """A programme and its flight; `end` (6,) is the relative state after the last impulse, at the end of the time."""

    programme: ImpulseProgramme
    flight: RelativeFlight
    end: Array

    @property
    def miss_m(self) -> float:
        return float(np.linalg.norm(self.end[:3]))

    @property
    def speed_m_s(self) -> float:
        return float(np.linalg.norm(self.end[3:]))


def flown(
    scenario: Scenario, state: Array, programme: ImpulseProgramme, end_s: float, forces: Forces
) -> Flown:
    """From the separation's state (6,) in (R, T, N). Raises PropagationError."""
    times = np.unique(np.concatenate([np.linspace(0.0, end_s, SAMPLES), programme.times_s]))
    found = fly(programme, state, scenario.target_state(), times, forces)
    last = programme.times_s[-1] == end_s
    return Flown(programme, found, found.after[-1] if last else found.states[-1])


def corrected(scenario: Scenario, state: Array, programme: ImpulseProgramme, end_s: float) -> Flown:
    """The programme whose impulses are moved, as little as does it, until two bodies meet at rest.

    Newton's method with the transition of the linear model. Where it does not get there, its last flight is returned.
    """
    motion, forces = scenario.motion, two_body(scenario.constants)
    effect = np.hstack([motion.transition(end_s, float(t)) @ KICK for t in programme.times_s])
    scale = np.repeat([motion.mean_motion_rad_s, 1.0], 3)
    found = flown(scenario, state, programme, end_s, forces)
    for _ in range(ROUNDS):
        if found.miss_m < MET_M and found.speed_m_s < MET_M * motion.mean_motion_rad_s:
            break
        change, *_ = np.linalg.lstsq(scale[:, None] * effect, -scale * found.end, rcond=1e-10)
        moved = ImpulseProgramme(programme.times_s, found.programme.dv_m_s + change.reshape(-1, 3))
        following = flown(scenario, state, moved, end_s, forces)
        if following.miss_m > found.miss_m and following.speed_m_s > found.speed_m_s:
            break
        found = following
    return found


def messages(scenario: Scenario, found: Flown) -> dict[str, str]:
    """`chaser.oem` and `chaser.opm` of a flight."""
    comment = "two-body motion; impulses corrected for it, impulses_two_body.csv"
    return chaser_messages(
        scenario.name, found.programme, found.flight, comment=comment, constants=scenario.constants,
        x_axis="where orbit.raan_deg is counted from",
    )  # fmt: skip


@dataclass(frozen=True, slots=True)
class Orbits:
    """Elements as they are, and as the paper's way to them gives them: inertial velocity without ω × ρ, and of the server
    without the platform's recoil and yaw."""

    platform: Elements
    platform_as_printed: Elements
    server: Elements
    server_as_printed: Elements

    def to_dict(self) -> dict[str, Any]:
        return {name: element_rows(getattr(self, name)) for name in self.__dataclass_fields__}


def element_rows(elements: Elements) -> dict[str, float]:
    """Elements as in plan.json: kilometres and degrees, perigee angle from −180 to 180."""
    argp = (degrees(elements.argp_rad) + 180.0) % 360.0 - 180.0
    return {
        "sma_km": elements.sma_m / 1e3, "ecc": elements.ecc, "inc_deg": degrees(elements.inc_rad),
        "raan_deg": degrees(elements.raan_rad), "argp_deg": argp, "true_anomaly_deg": degrees(elements.true_anomaly_rad),
    }  # fmt: skip


def orbits(scenario: Scenario, found: Separation, first_dv: Array) -> Orbits:
    """At the launch: of the platform without it, and of the server after its first impulse (3,), both at one instant."""
    target, constants = scenario.target_state(), scenario.constants
    x, z, vx, vz = scenario.platform_state()
    platform = np.array([z, x, 0.0, vz, vx, 0.0])
    kick = np.concatenate([np.zeros(3), first_dv])
    # The paper's server: as far up its tube and as fast, but of a platform that neither recoils nor turns.
    body_axes = axes(found.pair.yaw_rad)
    offset = body_axes @ (found.pair.place_m + np.array([0.0, found.q[3]]))
    speed = found.q[7] * body_axes[:, 1]
    pushed = platform + kick + np.array([offset[1], offset[0], 0.0, speed[1], speed[0], 0.0])

    def of(inertial: Array) -> Elements:
        return elements_from_state(inertial[:3], inertial[3:], constants)

    def without_rotation(relative: Array) -> Array:
        rows, _ = local_frame(target)
        return target + np.concatenate([rows.T @ relative[:3], rows.T @ relative[3:]])

    return Orbits(
        of(absolute_state(target, platform)), of(without_rotation(platform)),
        of(absolute_state(target, found.state + kick)), of(without_rotation(pushed)),
    )  # fmt: skip
