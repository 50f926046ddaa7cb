"""Coasts and finite burns by the compiled core: another integrator than `coast`, some hundred times as fast.

It extrapolates the midpoint rule and locates the borders of air layers, each state in steps of its own.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from orbsoc import _core

from ..array import Array
from ..constants import EARTH
from ..propagate import PropagationError
from .atmosphere import LAYERS
from .coast import checked_arguments
from .forces import EARTH_RATE_RAD_S, FLATTENING, J2, Drag, Force, PointMass

RTOL = 1e-13
"""Error of a step by its distance and speed, which is estimated with an order to spare."""


@dataclass(frozen=True, slots=True)
class SteeredBurn:
    """Constant thrust and mass flow for `duration_s`, steered in the vehicle's frame (R, T, N).

    `acceleration_m_s2` is that at ignition. The direction is cos(yaw)(cos p T + sin p R) + sin(yaw) N, where p is
    `pitch_rad` half-way and changes at `pitch_rate_rad_s`.
    """

    acceleration_m_s2: float
    exhaust_m_s: float
    pitch_rad: float
    yaw_rad: float
    duration_s: float
    pitch_rate_rad_s: float = 0.0

    @property
    def dv_m_s(self) -> float:
        """By the rocket equation."""
        return -self.exhaust_m_s * float(np.log(self.mass_ratio))

    @property
    def mass_ratio(self) -> float:
        """Of the end to ignition."""
        return 1.0 - self.acceleration_m_s2 * self.duration_s / self.exhaust_m_s


def fast_coast(
    states: ArrayLike,
    times_s: ArrayLike,
    forces: Sequence[Force],
    kicks: ArrayLike | None = None,
    *,
    rtol: float = RTOL,
) -> Array:
    """States (K, B, 6) as `coast` gives them, for the forces of this package. Raises as it does."""
    return _coasted(states, times_s, forces, kicks, rtol, transitions=False)[0]


def fast_coast_with_transitions(
    states: ArrayLike,
    times_s: ArrayLike,
    forces: Sequence[Force],
    kicks: ArrayLike | None = None,
    *,
    rtol: float = RTOL,
) -> tuple[Array, Array]:
    """States (K, B, 6) and matrices (K, B, 6, 6) as `coast_with_transitions` gives them; the states are `fast_coast`'s."""
    found, matrices = _coasted(states, times_s, forces, kicks, rtol, transitions=True)
    assert matrices is not None
    return found, matrices


def fast_burn(state: ArrayLike, burn: SteeredBurn, forces: Sequence[Force], *, rtol: float = RTOL) -> Array:
    """The state (6,) at the end of a burn. Raises ValueError for one that outlasts the mass, PropagationError."""
    if not burn.mass_ratio > 0.0:
        most = burn.exhaust_m_s / burn.acceleration_m_s2
        raise ValueError(f"duration_s = {burn.duration_s:g}: must be below {most:g} s, when the mass is gone")
    field, ballistic = _field(forces, 1)
    fields = {name: getattr(burn, name) for name in burn.__dataclass_fields__}
    try:
        return field.burn(np.asarray(state, np.float64), float(ballistic[0]), tolerance=rtol, **fields)
    except _core.CoreError as error:
        raise PropagationError(str(error)) from None


def _coasted(
    states: ArrayLike,
    times_s: ArrayLike,
    forces: Sequence[Force],
    kicks: ArrayLike | None,
    rtol: float,
    *,
    transitions: bool,
) -> tuple[Array, Array | None]:
    start, times, impulses = checked_arguments(states, times_s, kicks)
    field, ballistic = _field(forces, len(start))
    try:
        return field.coast(start, times, impulses, ballistic, tolerance=rtol, transitions=transitions)
    except _core.CoreError as error:
        raise PropagationError(str(error)) from None


def _field(forces: Sequence[Force], bodies: int) -> tuple[_core.OrbitField, Array]:
    """The forces as the core has them, and the ballistic coefficient of each body (B,)."""
    by_type = {type(force): force for force in forces}
    odd = [type(force).__name__ for force in forces if not isinstance(force, PointMass | J2 | Drag)]
    if odd or PointMass not in by_type or len(by_type) != len(forces):
        names = ", ".join(type(force).__name__ for force in forces)
        raise ValueError(f"forces = [{names}]: must be PointMass, and J2 and Drag at most once")
    oblateness, drag = by_type.get(J2), by_type.get(Drag)
    constants = {getattr(force, "constants", EARTH) for force in forces}
    if len(constants) > 1:
        raise ValueError(
            f"forces have the constants {sorted(each.name for each in constants)}: must be one set"
        )
    [earth] = constants
    field = _core.OrbitField(
        mu_m3_s2=earth.mu_m3_s2,
        radius_m=earth.earth_radius_m,
        j2=oblateness.j2 if isinstance(oblateness, J2) else 0.0,
        rotation_rad_s=EARTH_RATE_RAD_S,
        flattening=FLATTENING,
        layers=LAYERS * [1e3, 1.0, 1e3],
    )
    coefficient = drag.ballistic_m2_kg if isinstance(drag, Drag) else 0.0
    return field, np.array(np.broadcast_to(np.asarray(coefficient, np.float64), (bodies,)))
