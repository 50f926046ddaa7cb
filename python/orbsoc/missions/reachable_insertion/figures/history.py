"""What a burn does over time: heights, mass, and where its Δv goes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orbsoc.orbit import EARTH, Thruster, elements_from_state

from ..verification import Flight

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class History:
    """Along a flight, each (K,), SI. `delta_v_m_s` = `speed_change_m_s` + `gravity_m_s` + `steering_m_s`.

    d|v|/dt = a u·v̂ + g·v̂. Of a burn that speeds up, gravity takes −∫ g·v̂ dt and turning ∫ a (1 − u·v̂) dt; of one that `brakes`,
    the change is the speed that is shed, and v̂ is replaced by −v̂.
    """

    brakes: bool

    times_s: Array
    altitude_m: Array
    perigee_height_m: Array
    apogee_height_m: Array
    mass_kg: Array
    delta_v_m_s: Array
    speed_change_m_s: Array
    gravity_m_s: Array
    steering_m_s: Array

    @classmethod
    def of(cls, thruster: Thruster, flight: Flight) -> History:
        """From the samples of the flight that verified the plan."""
        times, states = flight.times_s, flight.propagated
        r, v = states[:, :3], states[:, 3:]
        radius, speed = (np.linalg.norm(each, axis=1) for each in (r, v))
        along = v / speed[:, None]
        mass = thruster.mass_kg - thruster.mass_flow_kg_s * times
        acceleration = thruster.acceleration_m_s2(times)
        pull = -EARTH.mu_m3_s2 * r / radius[:, None] ** 3
        exhaust = thruster.thrust_n / thruster.mass_flow_kg_s
        orbits = [elements_from_state(x[:3], x[3:]) for x in states]
        forwards = np.einsum("ki,ki->k", flight.direction, along)
        brakes = bool(_integrated(acceleration * forwards, times)[-1] < 0.0)
        sign = -1.0 if brakes else 1.0
        turned = acceleration * (1.0 - sign * forwards)
        return cls(
            brakes=brakes,
            times_s=times,
            altitude_m=radius - EARTH.earth_radius_m,
            perigee_height_m=np.array([orbit.perigee_height_m() for orbit in orbits]),
            apogee_height_m=np.array([orbit.apogee_height_m() for orbit in orbits]),
            mass_kg=mass,
            delta_v_m_s=exhaust * np.log(thruster.mass_kg / mass),
            speed_change_m_s=sign * (speed - speed[0]),
            gravity_m_s=_integrated(-sign * np.einsum("ki,ki->k", pull, along), times),
            steering_m_s=_integrated(turned, times),
        )


def _integrated(rate: Array, times: Array) -> Array:
    from scipy.integrate import cumulative_simpson  # pyright: ignore[reportUnknownVariableType]

    return np.asarray(cumulative_simpson(rate, x=times, initial=0.0), dtype=np.float64)
