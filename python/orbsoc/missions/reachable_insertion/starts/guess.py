"""Initial references: a burn propagated with a simple steering law, read off at the collocation nodes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from orbsoc.guidance.collocation import LegendreGauss
from orbsoc.guidance.powered_flight import Trajectory
from orbsoc.orbit import EARTH, CanonicalUnits, ConstantsSet, Thruster, propagate_burn
from orbsoc.orbit.propagate import Steering

Array = NDArray[np.float64]


def along_velocity(_t_s: float, state_si: Array) -> Array:
    """Thrust along the velocity: the cold start of problems A and B."""
    return state_si[3:]


def towards_plane(normal: Array, units: CanonicalUnits) -> Steering:
    """Thrust along v̂ − 2(v·n)n, v canonical: along the velocity and back towards the plane of normal n."""

    def steering(_t_s: float, state_si: Array) -> Array:
        velocity = state_si[3:] / units.speed_m_s
        return velocity / np.linalg.norm(velocity) - 2.0 * (velocity @ normal) * normal

    return steering


def propagated(
    state_si: Array,
    thruster: Thruster,
    steering: Steering,
    duration_s: float,
    grid: LegendreGauss,
    *,
    constants: ConstantsSet = EARTH,
) -> Trajectory:
    """The trajectory (canonical) that `steering` flies, at the nodes of `grid` and at the end.

    Raises `orbsoc.orbit.PropagationError` when it cannot be integrated.
    """
    units = CanonicalUnits.of(constants)
    times_s = 0.5 * duration_s * (np.append(grid.nodes, 1.0) + 1.0)
    states_si = propagate_burn(state_si, thruster, steering, times_s, constants=constants)
    directions = np.array([steering(t, x) for t, x in zip(times_s[:-1], states_si[:-1], strict=True)])
    states = units.state_from_si(states_si)
    return Trajectory(
        grid=grid,
        states=states[:-1],
        controls=directions / np.linalg.norm(directions, axis=1, keepdims=True),
        end=states[-1],
        duration=duration_s / units.time_s,
    )
