"""The largest semi-major axis as a function of plane and perigee height, with the error of interpolating it.

Between the grid's points the table is interpolated linearly in each axis. The error stated is a quarter of the largest
second difference at the cell's corners, summed over the three axes: twice the error of linear interpolation, h²f″/8, where
the function is smooth. It is an estimate, not a bound: how often it holds is measured (docs/reach.md).

Size is energy: a hyperbola, a < 0, is larger than any ellipse, and the axis jumps from +∞ to −∞ where the energy, −1/a,
passes zero. A cell that a hyperbola is a corner of, or next to, is interpolated in −1/a; the others in a.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from orbsoc.orbit.array import Array, Flags

Bends = tuple[Array, Array, Array]
Corner = tuple[int, ...]

ONE_SIDED = 2.0
"""By how much a second difference counts more that stands in for a missing one: next to the edge, where the function falls
ever faster, and at the ends of the grid."""
LEAST_KM = 1e-3
"""No value is better known than this."""


@dataclass(frozen=True, slots=True, eq=False)
class LargestOrbits:
    """Semi-major axes in km, `table` (I, R, K), NaN where none is reached and negative on hyperbolas, over `axes`:
    inclinations and nodes (deg), nodes ascending past 360, and perigee heights (km). `bends` are the sizes of its second
    differences along each axis, `energy_bends` those of −1/a; `open_near` says of points (I, R, K) whether they or a
    neighbour is a hyperbola."""

    axes: tuple[Array, Array, Array]
    table: Array
    bends: Bends
    energy_bends: Bends
    open_near: Flags

    @classmethod
    def of(cls, axes: Sequence[Array], values: Array) -> LargestOrbits:
        """From a table's column, inclination slowest and height fastest."""
        inc, raan, height = axes
        table = values.reshape(len(inc), len(raan), len(height))
        energy = -1.0 / table
        return cls((inc, raan, height), table, _all_bends(table), _all_bends(energy), _next_to(table < 0.0))

    def __call__(self, inc_deg: float, raan_deg: float, height_km: float) -> tuple[float, float]:
        """Value and error (km); NaN outside the table and in a cell of which a corner is not reached. The value is inf where
        the largest orbit is a hyperbola; the error is infinite where that, or the table, is too small to tell."""
        west = float(self.axes[1][0])
        at = (inc_deg, west + float(np.mod(raan_deg - west + 1e-9, 360.0)) - 1e-9, height_km)
        places = [_place(axis, x) for axis, x in zip(self.axes, at, strict=True)]
        if any(place is None for place in places):
            return float("nan"), float("nan")
        cell = [place for place in places if place is not None]
        corners = list(product(*(range(k, k + 1 + (share > 0.0)) for k, share in cell)))
        if any(self.open_near[corner] for corner in corners):
            return _size(*_between(-1.0 / self.table, self.energy_bends, cell, corners))
        value, error = _between(self.table, self.bends, cell, corners)
        return value, error + LEAST_KM


def _between(
    table: Array, bends: Bends, cell: list[tuple[int, float]], corners: list[Corner]
) -> tuple[float, float]:
    """The interpolated value in a cell, and its error; NaN where a corner is not reached."""
    value, error = 0.0, 0.0
    for corner in corners:
        weight = 1.0
        for index, (k, share) in zip(corner, cell, strict=True):
            weight *= share if index > k else 1.0 - share
        value += weight * float(table[corner])
    for axis, (_k, share) in enumerate(cell):
        if share > 0.0:
            error += 0.25 * max(float(bends[axis][corner]) for corner in corners)
    return value, error if np.isfinite(value) else float("nan")


def _size(energy: float, error: float) -> tuple[float, float]:
    """Semi-major axis (km, inf for hyperbolas) of an energy −1/a with an error, and its own error: the larger of both
    sides', infinite where one side is an ellipse and the other is not."""
    if np.isnan(energy):
        return float("nan"), float("nan")
    lower, upper = energy - error, energy + error
    if energy >= 0.0:
        return float("inf"), 0.0 if lower >= 0.0 else float("inf")
    value = -1.0 / energy
    return value, LEAST_KM + (float("inf") if upper >= 0.0 else -1.0 / upper - value)


def _place(axis: Array, x: float) -> tuple[int, float] | None:
    """The cell of a value and its share of the way through it; None outside the axis."""
    if not axis[0] - 1e-9 <= x <= axis[-1] + 1e-9:
        return None
    k = int(np.clip(np.searchsorted(axis, x, side="right") - 1, 0, max(len(axis) - 2, 0)))
    if len(axis) == 1:
        return 0, 0.0
    share = float(np.clip((x - axis[k]) / (axis[k + 1] - axis[k]), 0.0, 1.0))
    return k, share


def _next_to(marked: Flags) -> Flags:
    """The marked points and their neighbours along each axis, (I, R, K)."""
    out = marked.copy()
    for axis in range(marked.ndim):
        there, near = np.moveaxis(marked, axis, 0), np.moveaxis(out, axis, 0)
        near[1:] |= there[:-1]
        near[:-1] |= there[1:]
    return out


def _all_bends(table: Array) -> Bends:
    return _bends(table, 0), _bends(table, 1), _bends(table, 2)


def _bends(table: Array, axis: int) -> Array:
    """|second difference| at every point; a neighbour's, enlarged, where one cannot be formed, and infinite where none can
    nearby."""
    moved = np.moveaxis(table, axis, 0)
    out = np.full_like(moved, np.nan)
    out[1:-1] = np.abs(moved[2:] - 2.0 * moved[1:-1] + moved[:-2])
    known = np.isfinite(out)
    edge = np.full_like(out[:1], -np.inf)
    padded = np.concatenate([edge, np.where(known, out, -np.inf), edge])
    near = np.maximum(padded[2:], padded[:-2])
    stand_in = np.where(np.isfinite(near), ONE_SIDED * near, np.inf)
    return np.moveaxis(np.where(known, out, stand_in), 0, axis)
