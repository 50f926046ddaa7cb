"""The rendezvous flown about the Earth: target and server each by Newton's law, impulses corrected until they meet."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from math import degrees

import numpy as np

from orbsoc.guidance.chaser_messages import chaser_messages
from orbsoc.guidance.impulses import KICK, ImpulseProgramme
from orbsoc.guidance.relative_flight import Forces, RelativeFlight, fly, two_body
from orbsoc.orbit import Elements, elements_from_state
from orbsoc.orbit.array import Array
from orbsoc.orbit.relative import absolute_state, local_frame

from ..model.launch import axes
from ..model.separation import Separation
from ..scenario import Scenario

SAMPLES = 121
ROUNDS = 20
"""Of the correction, at most."""
MET_M = 1e-5
"""Within which the correction ends; the state is known to about 1e-7 m."""


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

    Broyden's method from the transition of the linear model. Where it does not get there, its best flight is returned.
    """
    motion, forces = scenario.motion, partial(two_body, constants=scenario.constants)
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
        effect += np.outer(following.end - found.end - effect @ change, change) / float(change @ change)
        found = following
    return found


def messages(scenario: Scenario, found: Flown) -> dict[str, str]:
    """`chaser.oem` and `chaser.opm` of a flight."""
    comment = "two-body motion; impulses corrected for it, impulses_two_body.csv"
    return chaser_messages(
        scenario.name, found.programme, found.flight, comment=comment, constants=scenario.constants,
        epoch_utc=scenario.orbit.epoch_utc, x_axis="where orbit.raan_deg is counted from",
        assumptions=scenario.assumptions,
    )  # fmt: skip


def element_rows(elements: Elements) -> dict[str, float]:
    """Elements as in plan.json: kilometres and degrees, perigee angle from −180 to 180."""
    argp = (degrees(elements.argp_rad) + 180.0) % 360.0 - 180.0
    return {
        "sma_km": elements.sma_m / 1e3, "ecc": elements.ecc, "inc_deg": degrees(elements.inc_rad),
        "raan_deg": degrees(elements.raan_rad), "argp_deg": argp, "true_anomaly_deg": degrees(elements.true_anomaly_rad),
    }  # fmt: skip


def orbits(scenario: Scenario, found: Separation, first_dv: Array) -> dict[str, Elements]:
    """At the launch, of the platform without it and of the server after its first impulse (3,), both at one instant: as
    they are, and `_as_printed`, by the paper's way: inertial velocity without ω × ρ, and a server as far up its tube and
    as fast, but of a platform that neither recoils nor turns."""
    target, constants = scenario.target_state(), scenario.constants
    x, z, vx, vz = scenario.platform_state()
    platform = np.array([z, x, 0.0, vz, vx, 0.0])
    kick = np.concatenate([np.zeros(3), first_dv])
    body_axes = axes(found.pair.yaw_rad)
    offset = body_axes @ (found.pair.place_m + np.array([0.0, found.q[3]]))
    speed = found.q[7] * body_axes[:, 1]
    pushed = platform + kick + np.array([offset[1], offset[0], 0.0, speed[1], speed[0], 0.0])
    rows, _ = local_frame(target)

    def without_rotation(relative: Array) -> Array:
        return np.asarray(target + np.concatenate([rows.T @ relative[:3], rows.T @ relative[3:]]))

    states = {
        "platform": absolute_state(target, platform), "platform_as_printed": without_rotation(platform),
        "server": absolute_state(target, found.state + kick), "server_as_printed": without_rotation(pushed),
    }  # fmt: skip
    return {name: elements_from_state(each[:3], each[3:], constants) for name, each in states.items()}
