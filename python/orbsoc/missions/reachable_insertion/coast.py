"""The coast before the burn: the first orbit without thrust."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from orbsoc.orbit import Thruster, propagate_burn

from .scenario import Scenario

Array = NDArray[np.float64]

ENGINE_OFF = Thruster(mass_kg=1.0, thrust_n=0.0, mass_flow_kg_s=0.0)


def coasted(state_si: Array, times_s: ArrayLike) -> Array:
    """States (K, 6), SI, after K increasing times of a coast. Raises `orbsoc.orbit.PropagationError`."""
    return propagate_burn(state_si, ENGINE_OFF, lambda _t, x: x[3:], times_s)


def at_ignition(scenario: Scenario, ignition_s: float) -> Array:
    """State at ignition, launch-inertial, SI (6,)."""
    start = scenario.launch_inertial(scenario.initial)
    return start if ignition_s == 0.0 else coasted(start, [ignition_s])[-1]
