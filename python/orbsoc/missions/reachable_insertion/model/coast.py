"""The coasts of a plan: orbits without thrust, about a point mass or, where the scenario says so, with J2."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from orbsoc.orbit import ConstantsSet, Thruster, propagate_burn, rotate_state
from orbsoc.orbit.array import Array
from orbsoc.orbit.perturbations import J2, Force, PointMass, coast, fast_coast

from ..scenario import Scenario

ENGINE_OFF = Thruster(mass_kg=1.0, thrust_n=0.0, mass_flow_kg_s=0.0)


def oblate(about: ConstantsSet) -> tuple[Force, ...]:
    """The forces of a coast with J2."""
    return (PointMass(about), J2(about, about.j2))


def coasted(scenario: Scenario, times_s: ArrayLike, *, independent: bool = False) -> Array:
    """States (K, 6), in the axes of plans, SI, after K increasing times of the coast from the scenario's state.

    With J2 the compiled core flies it, or DOP853 where the planner is to be judged: `independent`. Without, it is DOP853 for both.
    Raises `orbsoc.orbit.PropagationError`.
    """
    return coasted_from(
        scenario, scenario.launch_inertial(scenario.initial), times_s, independent=independent
    )


def coasted_from(scenario: Scenario, start: Array, times_s: ArrayLike, *, independent: bool = False) -> Array:
    """The same from a state (6,) in the axes of plans, SI."""
    times = np.atleast_1d(np.asarray(times_s, dtype=np.float64))
    if not scenario.burn.coast_j2:
        return propagate_burn(start, ENGINE_OFF, lambda _t, x: x[3:], times, constants=scenario.constants)
    if times[-1] == 0.0:
        return np.tile(start, (times.size, 1))
    to_eci = scenario.eci_rotation
    later = times[0] > 0.0  # the first time is that of the start
    fly = coast if independent else fast_coast
    found = fly(
        rotate_state(to_eci, start)[None],
        np.append(0.0, times) if later else times,
        oblate(scenario.constants),
    )
    return np.asarray(rotate_state(to_eci.T, found[int(later) :, 0]))


def at_ignition(scenario: Scenario, ignition_s: float, *, independent: bool = False) -> Array:
    """State at ignition, in the axes of plans, SI (6,)."""
    if ignition_s == 0.0:
        return scenario.launch_inertial(scenario.initial)
    return np.asarray(coasted(scenario, [ignition_s], independent=independent)[-1])
