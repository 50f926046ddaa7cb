"""What table 1 of the paper implies: its rows coasted to one another, and the distances that follow from its last ones."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from orbsoc.orbit.array import Array
from orbsoc.orbit.perturbations import J2, Drag, Force, PointMass, fast_coast
from orbsoc.orbit.relative import local_frame, relative_state

from .printed import TABLE

STEP_S = 10.0


@dataclass(frozen=True, slots=True, eq=False)
class Distances:
    """Of chaser and target at times after burn 8 (K,), m; within the orbital plane, and out of it."""

    after_s: Array
    distance_m: Array
    plane_m: Array
    across_m: Array

    def within_s(self, limit_m: float) -> float:
        """How long from burn 8 on the distance stays below a limit."""
        beyond = np.flatnonzero(self.distance_m > limit_m)
        return float(self.after_s[beyond[0]] if beyond.size else self.after_s[-1])

    def largest(self, until_s: float) -> tuple[float, float]:
        """Of the distance up to a time, and when."""
        part = self.distance_m[self.after_s <= until_s]
        return float(part.max()), float(self.after_s[part.argmax()])


def forces(ballistic_m2_kg: float = 0.0) -> list[Force]:
    return [PointMass(), J2(), *([Drag(ballistic_m2_kg)] if ballistic_m2_kg else [])]


def difference(row: str, later: str, ballistic_m2_kg: float = 0.0) -> tuple[Array, Array]:
    """Position (m) and velocity (m/s) of a later row less a row coasted to its epoch, each (3,) in the (R, T, N) of the latter."""
    one, two = TABLE[row], TABLE[later]
    state = one.state
    if two.epoch_s > one.epoch_s:
        state = fast_coast([state], [one.epoch_s, two.epoch_s], forces(ballistic_m2_kg))[-1, 0]
    found = two.state - state
    axes = local_frame(state)[0]
    return axes @ found[:3], axes @ found[3:]


def distances(chaser: str, target: str, ballistic_m2_kg: float, duration_s: float = 12_000.0) -> Distances:
    """Of a row after burn 8 and a target with drag, from the end of burn 8 on."""
    one, two = TABLE[chaser], TABLE[target]
    after = np.arange(0.0, duration_s + STEP_S, STEP_S)
    times = one.epoch_s + after
    goal = fast_coast([two.state], np.append(two.epoch_s, times), forces(ballistic_m2_kg))[1:, 0]
    flown = fast_coast([one.state], times, forces())[:, 0]
    relative = np.array([relative_state(a, b)[:3] for a, b in zip(goal, flown, strict=True)])
    size = np.linalg.norm(relative, axis=1)
    return Distances(after, size, np.linalg.norm(relative[:, :2], axis=1), np.abs(relative[:, 2]))
