"""Propagation of a powered arc by an integrator the optimiser does not use: SciPy's DOP853.

Nothing here knows about collocation. The thrust direction comes in as a function of time, so a plan is judged
by what its attitude programme would do to the vehicle at constant thrust, not by its own equations.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, cast

import numpy as np
from numpy.typing import ArrayLike

from .array import Array
from .constants import EARTH, ConstantsSet
from .units import CanonicalUnits


class PropagationError(RuntimeError):
    """The integrator gave up; the message says when and why."""


@dataclass(frozen=True, slots=True)
class Thruster:
    """A vehicle that burns at constant thrust (N) and mass flow (kg/s) from an initial mass (kg)."""

    mass_kg: float
    thrust_n: float
    mass_flow_kg_s: float

    def acceleration_m_s2(self, t_s: ArrayLike) -> Array:
        """Thrust acceleration F/m(t), m(t) = m₀ − ṁt."""
        return self.thrust_n / (self.mass_kg - self.mass_flow_kg_s * np.asarray(t_s, dtype=np.float64))


Steering = Callable[[float, Array], ArrayLike]
"""Thrust direction (3,) at a time in s and a state [r_m, v_m_s]; any length, it is normalised."""


def propagate_burn(
    state_si: ArrayLike,
    thruster: Thruster,
    steering: Steering,
    times_s: ArrayLike,
    *,
    constants: ConstantsSet = EARTH,
    rtol: float = 1e-12,
    atol: float = 1e-13,
) -> Array:
    """States [r_m, v_m_s], shape (K, 6), at the K increasing times of a burn that starts at t = 0.

    r̈ = −μ r/|r|³ + F/(m₀ − ṁt) · u/|u|, Earth-centred inertial axes, integrated in canonical units by DOP853
    with the given relative and absolute tolerances.
    Raises ValueError for times that decrease, are negative or outlast the mass; PropagationError when the
    integrator fails.
    """
    times = np.asarray(times_s, dtype=np.float64)
    if times.ndim != 1 or times.size == 0 or times[0] < 0.0 or np.any(np.diff(times) < 0.0):
        raise ValueError(f"times_s = {times!r}: must be a non-empty, non-decreasing vector from t ≥ 0")
    if thruster.mass_flow_kg_s * times[-1] >= thruster.mass_kg:
        raise ValueError(
            f"times_s ends at {times[-1]} s, when the vehicle of {thruster.mass_kg} kg has burnt itself up: "
            f"must be below {thruster.mass_kg / thruster.mass_flow_kg_s} s"
        )
    units = CanonicalUnits.of(constants)
    scale = units.state_to_si(np.ones(6))

    def rate(t: float, x: Array) -> Array:
        t_s = t * units.time_s
        direction = np.asarray(steering(t_s, x * scale), dtype=np.float64)
        acceleration = float(thruster.acceleration_m_s2(t_s)) / units.acceleration_m_s2
        radius = np.sqrt(x[:3] @ x[:3])
        pull = -x[:3] / radius**3
        return np.concatenate([x[3:], pull + acceleration * direction / np.sqrt(direction @ direction)])

    if times[-1] == 0.0:
        return np.tile(np.asarray(state_si, dtype=np.float64), (times.size, 1))
    from scipy.integrate import solve_ivp  # pyright: ignore[reportUnknownVariableType]

    integrate: Any = cast(Any, solve_ivp)  # published without types
    with np.errstate(over="ignore", invalid="ignore"):  # an overflow ends in a step of size 0, and so below
        result = integrate(
            rate,
            (0.0, times[-1] / units.time_s),
            units.state_from_si(np.asarray(state_si, dtype=np.float64)),
            method="DOP853",
            t_eval=times / units.time_s,
            rtol=rtol,
            atol=atol,
        )
    if not result.success:
        # SciPy hands out a list of times, an empty one if not even the first was reached.
        reached_s = result.t[-1] * units.time_s if len(result.t) else 0.0
        raise PropagationError(f"propagation stopped after t = {reached_s:.6g} s: {result.message}")
    return units.state_to_si(result.y.T)
