"""Fly an impulse programme as it would be: target and chaser each about the Earth, by an integrator no optimiser uses."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from orbsoc.orbit import EARTH, ConstantsSet
from orbsoc.orbit.array import Array
from orbsoc.orbit.perturbations import J2, Drag, Force, PointMass, coast
from orbsoc.orbit.relative import absolute_state, relative_state

from .impulses import ImpulseProgramme

Forces = Callable[[int], Sequence[Force]]
"""The forces on a number of pairs of target and chaser, states in the order target, chaser, target, …"""

RTOL = 1e-11
"""A step of a flight knows 7000 km to 70 µm."""
BALLISTIC_M2_KG = (0.01, 0.02)
"""C_D A/m of target and chaser, assumed."""


def two_body(_: int, constants: ConstantsSet = EARTH) -> Sequence[Force]:
    """Newton's law alone."""
    return [PointMass(constants)]


def oblate(_: int, constants: ConstantsSet = EARTH) -> Sequence[Force]:
    """With J₂."""
    return [PointMass(constants), J2(constants)]


def oblate_with_drag(pairs: int, constants: ConstantsSet = EARTH) -> Sequence[Force]:
    """With J₂ and the drag of two different bodies."""
    return [*oblate(pairs, constants), Drag(np.tile(BALLISTIC_M2_KG, pairs), constants)]


TRUTHS: dict[str, Forces] = {"two_body": two_body, "j2": oblate, "j2_drag": oblate_with_drag}
"""By name, as in plan.json."""


@dataclass(frozen=True, slots=True, eq=False)
class RelativeFlight:
    """Relative states (K, 6) in (R, T, N) at times_s (K,), that of an impulse's time before it; after each impulse the
    relative state (N, 6), and the inertial states (N, 2, 6) of target and chaser; at the times the inertial ones (K, 2, 6)."""

    times_s: Array
    states: Array
    after: Array
    pairs_after: Array
    pairs: Array


def fly(
    programme: ImpulseProgramme,
    start: ArrayLike,
    target: ArrayLike,
    times_s: ArrayLike,
    forces: Forces,
    *,
    rtol: float = RTOL,
) -> RelativeFlight:
    """Fly from the relative state `start` (6,) at the first of times_s (K,), where the target is at `target` (6,), ECI.

    Impulses before the first time are not flown, those after the last neither. Raises PropagationError.
    """
    wanted, burns = np.asarray(times_s, np.float64), programme.times_s
    flown = [(t, dv) for t, dv in zip(burns, programme.dv_m_s, strict=True) if wanted[0] <= t <= wanted[-1]]
    acting = forces(1)
    body = np.asarray(target, np.float64)
    pair = np.array([body, absolute_state(body, start, _pull(body, acting))])
    at = float(wanted[0])
    rows: list[Array] = []
    after: list[Array] = []
    pairs_after: list[Array] = []
    # A time at which there is an impulse is told before it.
    parts = np.split(wanted, np.searchsorted(wanted, [t for t, _ in flown], side="right"))
    for part, (t, dv) in zip(parts, [*flown, (wanted[-1], None)], strict=True):
        times = np.unique([at, *part, t])
        states = coast(pair, times, acting, rtol=rtol) if times.size > 1 else pair[None]
        rows += list(states[np.searchsorted(times, part)])
        if dv is None:
            break
        pair, at = states[-1].copy(), float(t)
        pull = _pull(pair[0], acting)
        relative = relative_state(pair[0], pair[1], pull)
        relative[3:] += dv
        pair[1] = absolute_state(pair[0], relative, pull)
        after.append(relative)
        pairs_after.append(pair.copy())
    pairs = np.array(rows)
    states = np.array([relative_state(one, other, _pull(one, acting)) for one, other in pairs])
    return RelativeFlight(
        wanted, states, np.array(after).reshape(-1, 6), np.array(pairs_after).reshape(-1, 2, 6), pairs
    )


def drifts(pairs: ArrayLike, times_s: ArrayLike, forces: Forces, *, rtol: float = RTOL) -> Array:
    """Relative positions (N, K, 3) of free drifts from inertial pairs (N, 2, 6) at times_s (K,) after them, 0 first."""
    start = np.asarray(pairs, np.float64)
    states = coast(start.reshape(-1, 6), times_s, forces(len(start)), rtol=rtol).reshape(-1, len(start), 2, 6)
    difference = states[:, :, 1, :3] - states[:, :, 0, :3]
    r, v = states[:, :, 0, :3], states[:, :, 0, 3:]
    outward = r / np.linalg.norm(r, axis=-1, keepdims=True)
    normal = np.cross(r, v)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    axes = np.stack([outward, np.cross(normal, outward), normal], axis=-2)
    return np.asarray(np.einsum("knij,knj->nki", axes, difference))


def _pull(target: Array, forces: Sequence[Force]) -> Array:
    """The target's acceleration, (3,)."""
    row = np.array([target, target])  # drag has a number for each of a pair
    return np.asarray(sum(force.acceleration(row)[0] for force in forces))
