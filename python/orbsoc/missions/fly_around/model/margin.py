"""What navigation and execution errors do to a flight that aims at its nodes: margins before, draws after."""

from __future__ import annotations

import numpy as np

from orbsoc.guidance.uncertainty import Uncertainty
from orbsoc.orbit.array import Array

from .flight import Flight
from .waypoints import required_size

SAMPLES = 12


def margin_m(flight: Flight, times_s: Array, uncertainty: Uncertainty) -> float:
    """`sigmas` standard deviations of the position beside the plan, the largest of any time and direction.

    Each pulse aims at the next node from the state as navigated: the position error of a node is what navigation and
    execution at the node before make of it over the arc. A pulse's size is taken as |a_req| times the arc's length: the
    first, which also leaves the start, may be larger, and the draws show what that does.
    """
    place = uncertainty.position_m**2 * np.eye(3)
    speed = uncertainty.velocity_m_s**2 * np.eye(3)
    arrived = np.zeros((3, 3))
    largest = 0.0
    for at, length in zip(times_s[:-1].tolist(), np.diff(times_s).tolist(), strict=True):
        size = float(required_size(flight, at)) * length
        fired = (uncertainty.execution_share * size) ** 2 + uncertainty.execution_fixed_m_s**2
        whole = flight.motion.transition(length, 0.0)
        aim = np.linalg.solve(whole[:3, 3:], whole[:3, :3])
        for s in np.linspace(0.0, length, SAMPLES + 1)[1:].tolist():
            part = flight.motion.transition(s, 0.0)
            stayed, steered, moved = part[:3, :3] - part[:3, 3:] @ aim, part[:3, 3:] @ aim, part[:3, 3:]
            covariance = (
                stayed @ arrived @ stayed.T
                + steered @ place @ steered.T
                + moved @ (speed + fired * np.eye(3)) @ moved.T
            )
            largest = max(largest, float(np.linalg.eigvalsh(covariance)[-1]))
        arrived = covariance
    return float(uncertainty.sigmas * np.sqrt(largest))
