"""A transfer: before each burn a coast, the thrust directions of each burn at the nodes of a grid; canonical units."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from orbsoc.guidance.collocation import LegendreGauss, legendre_gauss
from orbsoc.orbit.array import Array


@dataclass(frozen=True, slots=True, eq=False)
class Transfer:
    """`coasts` (K,) and `durations` (K,) of K burns by turns, a coast first; `controls` (K, N, 3)."""

    grid: LegendreGauss
    coasts: Array
    durations: Array
    controls: Array

    @property
    def burning(self) -> float:
        """Duration of all burns together: the propellant by another name."""
        return float(self.durations.sum())

    @property
    def directed(self) -> Transfer:
        """The same with directions of unit length."""
        size = np.linalg.norm(self.controls, axis=2, keepdims=True)
        return Transfer(self.grid, self.coasts, self.durations, self.controls / np.maximum(size, 1e-12))

    def moved(self, times: Array, turns: Array) -> Transfer:
        """The same with [coasts, durations] changed by `times` (2K,) and the directions of each burn turned by a rotation vector (K, 3)."""
        burns = len(self.coasts)
        controls = np.array([rotated(each, turn) for each, turn in zip(self.controls, turns, strict=True)])
        return Transfer(self.grid, self.coasts + times[:burns], self.durations + times[burns:], controls)

    def resampled(self, nodes: int) -> Transfer:
        """What it commands, on another grid."""
        grid = legendre_gauss(nodes)
        controls = np.array([self.grid.interpolate(each, grid.nodes) for each in self.controls])
        return Transfer(grid, self.coasts, self.durations, controls).directed


def constant(directions: Array, coasts: Array, durations: Array, nodes: int) -> Transfer:
    """Thrust along one inertial direction (K, 3) over each burn."""
    unit = directions / np.linalg.norm(directions, axis=1, keepdims=True)
    controls = np.repeat(unit[:, None, :], nodes, axis=1)
    return Transfer(legendre_gauss(nodes), coasts, durations, controls)


def rotated(vectors: Array, turn: Array) -> Array:
    """Vectors (N, 3) turned by a rotation vector (3,), by Rodrigues' formula."""
    angle = float(np.linalg.norm(turn))
    axis = turn / angle if angle > 0.0 else np.array([1.0, 0.0, 0.0])
    along = np.outer(vectors @ axis, axis)
    return np.asarray(along + np.cos(angle) * (vectors - along) + np.sin(angle) * np.cross(axis, vectors))
