"""What errors of navigation and execution make of the corrected flight, by linear covariance, and the room that they need.

The flight is that of `closed_loop`: what navigation says goes through its correction into the next impulse. Impulses have the size that
is planned for them. A place needs `sigmas` standard deviations of its own across the keep-out.
"""

from __future__ import annotations

import numpy as np

from orbsoc.guidance.impulses import ImpulseProgramme
from orbsoc.guidance.uncertainty import Uncertainty
from orbsoc.orbit.array import Array

from ..model.approach import Approach
from .closed_loop import gains
from .linear import Arc


def covariances_after(
    approach: Approach, programme: ImpulseProgramme, flown: tuple[Arc, ...], errors: Uncertainty
) -> Array:
    """Of the state's deviation just after each impulse, (K, 6, 6), frame (R, T, N)."""
    kick = np.vstack([np.zeros((3, 3)), np.eye(3)])
    navigation, before = errors.covariance(), np.zeros((6, 6))
    found = np.empty((len(programme), 6, 6))
    for k, law in enumerate(gains(approach, programme, flown)):
        size = float(np.linalg.norm(programme.dv_m_s[k]))
        fired = (errors.execution_share * size) ** 2 + errors.execution_fixed_m_s**2
        kept, steered = np.eye(6) + kick @ law, kick @ law
        found[k] = kept @ before @ kept.T + steered @ navigation @ steered.T + fired * kick @ kick.T
        times = flown[k].times_s
        coast = approach.motion.transition(float(times[-1]), float(times[0]))
        before = coast @ found[k] @ coast.T
    return found


def room_m(
    approach: Approach, programme: ImpulseProgramme, flown: tuple[Arc, ...], errors: Uncertainty
) -> float:
    """How far outside the keep-out the flight before the gate stays, less what its errors reach there, m; the least."""
    found = covariances_after(approach, programme, flown, errors)
    least = np.inf
    for k in range(int(np.searchsorted(programme.times_s, approach.gate_s - 1e-6))):
        times, places = flown[k].times_s, flown[k].states[:, :3]
        rows = approach.transitions(times, np.full_like(times, times[0]))[:, :3]
        scaled = places / approach.axes_m**2
        across = approach.axes_m.min() * scaled / approach.size(places)[:, None]
        weights = np.einsum("mi,mij->mj", across, rows)
        reach = np.sqrt(np.einsum("mi,ij,mj->m", weights, found[k], weights))
        least = min(least, float((approach.outside_m(places) - errors.sigmas * reach).min()))
    return least
