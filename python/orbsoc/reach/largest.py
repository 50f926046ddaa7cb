"""The largest semi-major axis as a function of plane and perigee height, with the error of interpolating it.

Between the grid's points the table is interpolated linearly in each axis. The error stated is a quarter of the largest
second difference at the cell's corners, summed over the three axes: twice the error of linear interpolation, h²f″/8, where
the function is smooth. It is an estimate, not a bound: how often it holds is measured (docs/reach.md).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

ONE_SIDED = 2.0
"""By how much a second difference counts more that stands in for a missing one: next to the edge, where the function falls
ever faster, and at the ends of the grid."""
LEAST_KM = 1e-3
"""No value is better known than this."""


@dataclass(frozen=True, slots=True, eq=False)
class LargestOrbits:
    """Semi-major axes in km, `table` (I, R, K), NaN where none is reached, over `axes`: inclinations and nodes (deg), nodes
    ascending past 360, and perigee heights (km). `bends` are the sizes of its second differences along each axis."""

    axes: tuple[Array, Array, Array]
    table: Array
    bends: tuple[Array, Array, Array]

    @classmethod
    def of(cls, axes: Sequence[Array], values: Array) -> LargestOrbits:
        """From a table's column, inclination slowest and height fastest."""
        inc, raan, height = axes
        table = values.reshape(len(inc), len(raan), len(height))
        return cls((inc, raan, height), table, (_bends(table, 0), _bends(table, 1), _bends(table, 2)))

    def __call__(self, inc_deg: float, raan_deg: float, height_km: float) -> tuple[float, float]:
        """Value and error (km); NaN outside the table and in a cell of which a corner is not reached. The error is
        infinite where the table is too small to tell."""
        west = float(self.axes[1][0])
        at = (inc_deg, west + float(np.mod(raan_deg - west + 1e-9, 360.0)) - 1e-9, height_km)
        places = [_place(axis, x) for axis, x in zip(self.axes, at, strict=True)]
        if any(place is None for place in places):
            return float("nan"), float("nan")
        cell = [place for place in places if place is not None]
        corners = list(product(*(range(k, k + 1 + (share > 0.0)) for k, share in cell)))
        value = 0.0
        for corner in corners:
            weight = 1.0
            for index, (k, share) in zip(corner, cell, strict=True):
                weight *= share if index > k else 1.0 - share
            value += weight * float(self.table[corner])
        error = LEAST_KM
        for axis, (_k, share) in enumerate(cell):
            if share > 0.0:
                error += 0.25 * max(float(self.bends[axis][corner]) for corner in corners)
        return value, error if np.isfinite(value) else float("nan")


def _place(axis: Array, x: float) -> tuple[int, float] | None:
    """The cell of a value and its share of the way through it; None outside the axis."""
    if not axis[0] - 1e-9 <= x <= axis[-1] + 1e-9:
        return None
    k = int(np.clip(np.searchsorted(axis, x, side="right") - 1, 0, max(len(axis) - 2, 0)))
    if len(axis) == 1:
        return 0, 0.0
    share = float(np.clip((x - axis[k]) / (axis[k + 1] - axis[k]), 0.0, 1.0))
    return k, share


def _bends(table: Array, axis: int) -> Array:
    """|second difference| at every point; a neighbour's, enlarged, where one cannot be formed, and infinite where none can
    nearby."""
    moved = np.moveaxis(table, axis, 0)
    out = np.full_like(moved, np.nan)
    out[1:-1] = np.abs(moved[2:] - 2.0 * moved[1:-1] + moved[:-2])
    known = np.isfinite(out)
    padded = np.pad(
        np.where(known, out, -np.inf), [(1, 1)] + [(0, 0)] * (out.ndim - 1), constant_values=-np.inf
    )
    near = np.maximum(padded[2:], padded[:-2])
    stand_in = np.where(np.isfinite(near), ONE_SIDED * near, np.inf)
    return np.moveaxis(np.where(known, out, stand_in), 0, axis)
