"""The paper's approximation: the optimal two impulses as a series in the orbital rate ω, in closed form.

Its 9 × 9 linear system for order 1 has this solution; order 2 goes one term further. With r, v the state at the
separation, K r = (−z, x) and t the time of flight:

v⁺ = −r/t + ω K r + ω² t (x, −2z)/3,   v_f = −r/t − ω K r + ω² t (x/3, 5z/6),   t = t₀ + ω² t₂.

Vectors are (x, z): along the target's motion, and outward.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from orbsoc.orbit.array import Array
from orbsoc.orbit.relative import ClohessyWiltshire

from .transfer import cost_of

ORDERS = (0, 1, 2)


class PerturbationError(ValueError):
    """The series has no leading term: the server does not move towards the target."""


@dataclass(frozen=True, slots=True, eq=False)
class Approximation:
    """One order of the series: time of flight, both impulses (2,), Σ‖Δv‖² as the series has it, and as those times cost."""

    order: int
    time_s: float
    first_m_s: Array
    last_m_s: Array
    cost: float
    true_cost: float
    """Of the exact impulses for `time_s`."""

    def to_dict(self) -> dict[str, Any]:
        vectors = {"first_m_s": self.first_m_s.tolist(), "last_m_s": self.last_m_s.tolist()}
        return asdict(self) | vectors


def series(server: ArrayLike, rate_rad_s: float, order: int) -> tuple[float, Array, Array, float]:
    """Time of flight, both impulses (2,) and Σ‖Δv‖² to an order in ω, from the server's state (4,): x, z and rates.

    Raises PerturbationError unless r · v < 0: order 0 is the straight flight at the speed that costs least.
    """
    x, z, vx, vz = (float(each) for each in np.asarray(server, np.float64))
    r, v, turned = np.array([x, z]), np.array([vx, vz]), np.array([-z, x])
    closing, square = float(r @ v), float(r @ r)
    if not closing < 0.0:
        raise PerturbationError(f"r · v = {closing:g} m²/s: must be below 0, towards the target")
    w = rate_rad_s if order else 0.0
    second = w**2 if order == 2 else 0.0
    t = -2.0 * square / closing
    t += second * 8.0 * square**3 * (x * vx - 2.0 * z * vz) / (3.0 * closing**4)
    after = -r / t + w * turned + second * t * np.array([x, -2.0 * z]) / 3.0
    arrival = -r / t - w * turned + second * t * np.array([x / 3.0, 5.0 * z / 6.0])
    cost = float(v @ v) + 2.0 * closing / t + 2.0 * square / t**2 + 2.0 * w * (vx * z - vz * x)
    cost += second * (-2.0 * t * x * vx + 4.0 * t * z * vz + 2.0 * x**2 + 5.0 * z**2) / 3.0
    return t, after - v, -arrival, cost


def approximations(server: ArrayLike, motion: ClohessyWiltshire) -> tuple[Approximation, ...]:
    """Every order with what it is worth: its cost beside the true one of its time. Raises PerturbationError."""
    x, z, vx, vz = (float(each) for each in np.asarray(server, np.float64))
    value = cost_of(motion, np.array([z, x, vz, vx]), "squares")
    found = []
    for order in ORDERS:
        t, first, last, cost = series(server, motion.mean_motion_rad_s, order)
        found.append(Approximation(order, t, first, last, cost, value(t)))
    return tuple(found)
