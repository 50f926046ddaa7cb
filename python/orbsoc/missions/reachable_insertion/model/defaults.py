"""What a scenario leaves out and the mission assumes: the burn time to begin with, from impulses between the apsides."""

from __future__ import annotations

from itertools import product
from math import acos, cos, exp, inf, isfinite, sqrt

import numpy as np
from numpy.typing import NDArray

from orbsoc.guidance.vehicle import DRY_SHARE, Vehicle
from orbsoc.orbit import EARTH, angular_momentum, elements_from_state

Array = NDArray[np.float64]

MOST_SHARE = 0.9
"""Of the longest burn, that a guess takes at most."""
WITHOUT_SHAPE = 0.1
"""Of the longest burn, where the target's shape is free or an orbit is a parabola."""


def guessed_duration_s(vehicle: Vehicle, start: Array, goal: Array | None, *, plane_free: bool) -> float:
    """The burn of the cheapest pair of impulses between an apsis of the first orbit and one of the target, by the rocket
    equation; the plane turns at the second. States (6,), SI, in the same axes; `goal` None where its shape is free."""
    longest = vehicle.longest_burn_s
    dv_m_s = inf if goal is None else _least_dv_m_s(start, goal, plane_free)
    if not isfinite(dv_m_s):
        return WITHOUT_SHAPE * longest
    exhaust_m_s = vehicle.thrust_n / vehicle.mass_flow_kg_s
    burn_s = vehicle.mass_kg / vehicle.mass_flow_kg_s * (1.0 - exp(-dv_m_s / exhaust_m_s))
    return min(max(burn_s, 1.0), MOST_SHARE * longest)


def dry_mass_words(vehicle: Vehicle) -> list[str]:
    """That the dry mass is the default, if it is."""
    if vehicle.dry_mass_kg != DRY_SHARE * vehicle.mass_kg:
        return []
    return [f"vehicle.dry_mass_kg = {vehicle.dry_mass_kg:g}, a tenth of mass_kg, the default"]


def _least_dv_m_s(start: Array, goal: Array, plane_free: bool) -> float:
    """Infinite where nothing can be said."""
    mu = EARTH.mu_m3_s2
    try:
        first = elements_from_state(start[:3], start[3:])
        last = elements_from_state(goal[:3], goal[3:])
    except ValueError:
        return inf
    turn = 0.0
    if not plane_free:
        normals = [angular_momentum(each[:3], each[3:]) for each in (start, goal)]
        units = [each / np.linalg.norm(each) for each in normals]
        turn = acos(float(np.clip(units[0] @ units[1], -1.0, 1.0)))

    def speed(radius: float, sma: float) -> float:
        return sqrt(mu * max(2.0 / radius - 1.0 / sma, 0.0))

    def pair(low: float, high: float) -> float:
        sma = 0.5 * (low + high)
        leave = abs(speed(low, sma) - speed(low, first.sma_m))
        come, stay = speed(high, sma), speed(high, last.sma_m)
        return leave + sqrt(max(come**2 + stay**2 - 2.0 * come * stay * cos(turn), 0.0))

    apsides = [
        [each for each in (orbit.perigee_radius_m, orbit.apogee_radius_m) if isfinite(each)]
        for orbit in (first, last)
    ]
    return min(pair(a, b) for a, b in product(*apsides))
