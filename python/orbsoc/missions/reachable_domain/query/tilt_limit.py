"""The boundary as a function: the largest tilt at any azimuth and perigee height, with the error of interpolating it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import CubicSpline, PchipInterpolator

Array = NDArray[np.float64]


MOST_HOLES = 0.1
"""Share of the azimuths of a curve that may lack a tilt."""


@dataclass(frozen=True, slots=True, eq=False)
class TiltLimit:
    """Tilts (degrees) on A azimuths × K perigee heights, `table` (A, K); between them periodic cubics over azimuth and
    monotone ones over height."""

    azimuth_deg: Array
    height_km: Array
    table: Array
    change: Array

    @classmethod
    def of(cls, boundary: Mapping[str, NDArray[Any]]) -> TiltLimit:
        """From the boundary's columns; a point without a tilt is interpolated from its neighbours, and its error is how
        far cubic and linear interpolation differ there. A height with too many of them has no edge, and is left out.

        Raises ValueError unless every azimuth has every height.
        """
        azimuth, height = np.unique(boundary["azimuth_deg"]), np.unique(boundary["perigee_bound_km"])
        order = np.lexsort((boundary["perigee_bound_km"], boundary["azimuth_deg"]))
        if len(order) != len(azimuth) * len(height):
            raise ValueError(
                f"the boundary has {len(order)} points, not {len(azimuth)} azimuths × {len(height)} heights"
            )
        table = boundary["tilt_deg"][order].reshape(len(azimuth), len(height))
        change = boundary["tilt_change_deg"][order].reshape(table.shape)
        known = np.isnan(table).mean(axis=0) <= MOST_HOLES
        height, table, change = height[known], table[:, known], change[:, known]
        for k in np.flatnonzero(np.isnan(table).any(axis=0)):
            table[:, k], change[:, k] = _filled(azimuth, table[:, k], change[:, k])
        return cls(azimuth, height, table, change)

    def __call__(self, azimuth_deg: ArrayLike, height_km: ArrayLike) -> Array:
        """The largest tilt (degrees); NaN for heights outside the table."""
        return self._interpolate(self.azimuth_deg, self.table, azimuth_deg, height_km)

    def covers(self, height_km: ArrayLike) -> NDArray[np.bool_]:
        """Whether perigee heights lie within those whose edge is known."""
        height = np.asarray(height_km, np.float64)
        lowest, highest = self.height_km.min(initial=np.inf), self.height_km.max(initial=-np.inf)
        return np.asarray((height >= lowest - 1e-9) & (height <= highest + 1e-9))

    def error_deg(self, azimuth_deg: ArrayLike, height_km: ArrayLike) -> Array:
        """How far a value may be off: the change when every second azimuth, or every second height, is left out, plus the
        largest change of the table itself from its coarser grid. Left-out points make the steps twice as long, so
        this is more than the error of the full table wherever the curve is resolved at all."""
        full = self(azimuth_deg, height_km)
        thinner = np.abs(
            self._interpolate(self.azimuth_deg[::2], self.table[::2], azimuth_deg, height_km) - full
        )
        other = self._interpolate(self.azimuth_deg[1::2], self.table[1::2], azimuth_deg, height_km)
        thinner = np.maximum(thinner, np.abs(other - full))
        if len(self.height_km) >= 5 and len(self.height_km) % 2:
            sparse = TiltLimit(self.azimuth_deg, self.height_km[::2], self.table[:, ::2], self.change[:, ::2])
            thinner = np.maximum(thinner, np.abs(sparse(azimuth_deg, height_km) - full))
        return np.asarray(thinner + np.nanmax(self.change, initial=0.0))

    def _interpolate(
        self, azimuths: Array, table: Array, azimuth_deg: ArrayLike, height_km: ArrayLike
    ) -> Array:
        beta, height = np.broadcast_arrays(np.mod(azimuth_deg, 360.0), np.asarray(height_km, np.float64))
        if not self.height_km.size:  # no splines through nothing
            return np.full(beta.shape, np.nan)
        around = CubicSpline(
            np.append(azimuths, azimuths[0] + 360.0), np.vstack([table, table[:1]]), bc_type="periodic"
        )
        columns = around(beta.ravel())
        out = np.full(beta.size, np.nan)
        inside = self.covers(height.ravel())
        for k in np.flatnonzero(inside):
            if len(self.height_km) == 1:
                out[k] = columns[k, 0]
            else:
                out[k] = PchipInterpolator(self.height_km, columns[k])(height.ravel()[k])
        return out.reshape(beta.shape)


def _filled(azimuth_deg: Array, tilt: Array, change: Array) -> tuple[Array, Array]:
    """A curve (A,) with its holes interpolated, and their error in `change`."""
    known = ~np.isnan(tilt)
    points = np.append(azimuth_deg[known], azimuth_deg[known][0] + 360.0)
    values = np.append(tilt[known], tilt[known][0])
    cubic = CubicSpline(points, values, bc_type="periodic")(azimuth_deg[~known])
    linear = np.interp(azimuth_deg[~known], points, values)
    tilt, change = tilt.copy(), change.copy()
    tilt[~known], change[~known] = cubic, np.abs(cubic - linear)
    return tilt, change
