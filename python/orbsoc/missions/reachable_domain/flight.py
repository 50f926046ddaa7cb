"""Fly plans: propagate what their attitude programmes command, many at once, and say what orbits they reach.

The commanded direction is the degree N − 1 interpolant of the nodal controls, normalised, at constant thrust
(docs/algorithm.md). Integrated by `orbsoc.orbit.gauss`, which the convex programmes do not use; extremals are
integrated by it too, in half as many steps.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orbsoc.collocation import LegendreGauss, interpolation_matrix
from orbsoc.missions.reachable_insertion.model import Burn
from orbsoc.orbit.gauss import GaussSteps, gauss_steps, integrate

Array = NDArray[np.float64]

STEPS = 12
"""Gauss steps of order 16 over a burn: 96 nodes. Checked against DOP853 in the tests."""
TOGETHER = 256
"""Burns that are flown together: what fits in a core's cache."""


@dataclass(frozen=True, slots=True, eq=False)
class Flights:
    """B propagated burns, canonical: end states (B, 6), smallest radius (B,) on the way, and the extremes of the raw
    interpolant's length (B,)."""

    ends: Array
    lowest: Array
    raw_most: Array
    raw_least: Array

    def __getitem__(self, part: slice) -> Flights:
        """Some of them, as views."""
        return Flights(self.ends[part], self.lowest[part], self.raw_most[part], self.raw_least[part])


def fly(burn: Burn, duration: float, grid: LegendreGauss, controls: Array, *, steps: int = STEPS) -> Flights:
    """Propagate the commanded burns of controls (B, N, 3) for `duration` (canonical)."""
    scheme, count = gauss_steps(duration, steps), len(controls)
    out = Flights(np.empty((count, 6)), *(np.empty(count) for _ in range(3)))
    for first in range(0, count, TOGETHER):
        part = slice(first, first + TOGETHER)
        _fly_part(burn, scheme, grid, controls[part], out[part])
    return out


def _fly_part(burn: Burn, scheme: GaussSteps, grid: LegendreGauss, controls: Array, out: Flights) -> None:
    """Propagate burns into `out`."""
    raw = _sampled(grid, scheme, controls)
    length = np.sqrt(np.einsum("sdb,sdb->sb", raw, raw))
    raw *= (burn.thrust_acceleration(scheme.times)[:, None] / length)[:, None]

    def force(window: slice, positions: Array) -> Array:
        square = np.einsum("sdb,sdb->sb", positions, positions)
        return np.asarray(raw[window] - positions / (square * np.sqrt(square))[:, None])

    start = np.repeat(burn.start[:, None], len(controls), axis=1)
    arc = integrate(scheme, start[:3], start[3:], force)
    out.ends[:] = np.concatenate([arc.end_position, arc.end_velocity]).T
    out.lowest[:] = _lowest(arc.positions, out.ends)
    out.raw_most[:], out.raw_least[:] = length.max(axis=0), length.min(axis=0)


def _sampled(grid: LegendreGauss, scheme: GaussSteps, controls: Array) -> Array:
    """The interpolants at all nodes of the scheme, (nodes, 3, B)."""
    count, n, _ = controls.shape
    matrix = interpolation_matrix(grid.nodes, 2.0 * scheme.times / scheme.duration - 1.0)
    stacked = controls.transpose(1, 2, 0).reshape(n, 3 * count)
    return np.asarray(matrix @ stacked).reshape(-1, 3, count)


def _lowest(positions: Array, ends: Array) -> Array:
    """Smallest radius at the nodes and the end."""
    radius = np.sqrt(np.einsum("sdb,sdb->sb", positions, positions))
    return np.asarray(np.minimum(radius.min(axis=0), np.linalg.norm(ends[:, :3], axis=1)))
