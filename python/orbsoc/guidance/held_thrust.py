"""Thrust on a chaser that is held in its target's frame (R, T, N), as a force on pairs of both about the Earth."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from orbsoc.orbit.array import Array


@dataclass(frozen=True, slots=True, eq=False)
class HeldThrust:
    """Accelerations (B, 3), m/s², of the chasers of states (2B, 6) in the order target, chaser, target, …; constant in (R, T, N) of
    the target, which turns."""

    pushes: Array

    def acceleration(self, states: Array) -> Array:
        """m/s², (2B, 3), ECI."""
        targets = states[::2]
        r, v = targets[:, :3], targets[:, 3:]
        outward = r / np.linalg.norm(r, axis=1, keepdims=True)
        normal = np.cross(r, v)
        normal /= np.linalg.norm(normal, axis=1, keepdims=True)
        axes = np.stack([outward, np.cross(normal, outward), normal], axis=1)
        found = np.zeros((len(states), 3))
        found[1::2] = np.einsum("bij,bi->bj", axes, self.pushes)
        return found

    def jacobian(self, states: Array) -> Array:
        """Raises NotImplementedError: it depends on another body's state, which a Jacobian by the own one does not tell."""
        raise NotImplementedError("thrust held in a target's frame has no transition matrices")
