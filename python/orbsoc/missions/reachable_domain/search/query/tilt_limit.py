"""The boundary as a function: the largest tilt at any azimuth and perigee height, with the error of interpolating it.

Between azimuths 1/δ² is interpolated, not the tilt δ: of an ellipse, however thin, it is a plain wave in twice the azimuth.
Where azimuths lie too far apart for a tip or a corner, `unresolved` names those between.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from orbsoc.orbit.array import Array, Flags, Index

from ..continuation.largest_tilt import CLEAR_RAD, RESOLUTION_RAD

MOST_HOLES = 0.1
"""Share of the azimuths of a curve that may lack a tilt."""
LEAST_TILT_DEG, MOST_TILT_DEG = 1e-6, 180.0
"""Bounds of an interpolated tilt."""
AT_A_TIP = 3.0
"""How many times the error may be a miss: 2.8 where a tip lies between azimuths too far apart for it, a sixteenth where the
edge is smooth."""
SAMPLES = 8
"""Of a step between azimuths."""
LEAST_STEP_DEG = 1e-3
"""Azimuths nearer to each other than this are not parted further."""


@dataclass(frozen=True, eq=False)
class TiltLimit:
    """Tilts (degrees) on A azimuths × K perigee heights, `table` (A, K), and how much each `change`d from a coarser grid
    of the burn; between them periodic cubics over azimuth and monotone ones over height."""

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
        return self._over_height(azimuth_deg, height_km, np.arange(len(self.height_km)))

    def covers(self, height_km: ArrayLike) -> Flags:
        """Whether perigee heights lie within those whose edge is known."""
        height = np.asarray(height_km, np.float64)
        lowest, highest = self.height_km.min(initial=np.inf), self.height_km.max(initial=-np.inf)
        return np.asarray((height >= lowest - 1e-9) & (height <= highest + 1e-9))

    def error_deg(self, azimuth_deg: ArrayLike, height_km: ArrayLike) -> Array:
        """How far a value may be off: the sum of three parts, NaN outside the table.

        Over azimuth: the largest `miss` of the step and its neighbours, AT_A_TIP times. Of the azimuths themselves: the largest change from a
        coarser grid among these. Over height: the change when every second height is left out, and no
        more than what the heights above and below allow, since a higher bound makes no tilt larger.
        """
        beta, height = np.broadcast_arrays(np.asarray(azimuth_deg, np.float64), np.asarray(height_km))
        if not self.height_km.size:
            return np.full(beta.shape, np.nan)
        above = np.clip(np.searchsorted(self.height_km, height - 1e-9), 0, len(self.height_km) - 1)
        below = np.clip(np.searchsorted(self.height_km, height + 1e-9, side="right") - 1, 0, None)
        after = np.searchsorted(self.azimuth_deg, np.mod(beta, 360.0), side="right")
        near = (after[..., None] + np.arange(-2, 1)) % len(self.azimuth_deg)
        of_azimuth = np.zeros(beta.shape)
        for height_of in (below, above):
            own = self._own_error[near, height_of[..., None]].max(axis=-1)
            miss = AT_A_TIP * self.miss[near, height_of[..., None]].max(axis=-1)
            of_azimuth = np.maximum(of_azimuth, miss + own)
        return np.asarray(of_azimuth + self._height_error(beta, height, below, above))

    @cached_property
    def miss(self) -> Array:
        """How far the curve lies from those with every second azimuth left out, the largest in each step from an azimuth to the
        next, (A, K).

        Their steps are twice as long, so this is more than the error between the azimuths: sixteen times where the edge is
        smooth, about that error at a corner. It is looked for between the azimuths as well: a tip that lies there is seen by none.
        """
        gap = np.diff(self.azimuth_deg, append=self.azimuth_deg[0] + 360.0)
        places = self.azimuth_deg[:, None] + gap[:, None] * np.arange(SAMPLES) / SAMPLES
        full = _around(self.azimuth_deg, self.table, places.ravel())
        away = [
            np.abs(_around(self.azimuth_deg[part], self.table[part], places.ravel()) - full)
            for part in (slice(0, None, 2), slice(1, None, 2))
        ]
        return np.asarray(np.maximum(*away).reshape(*places.shape, -1).max(axis=1))

    def unresolved(self, tolerance_deg: float, most: int) -> Array:
        """Azimuths within 0…180 to solve next, at most `most`, those of the largest misses first: the middles of steps in
        which the curve is missed by more than the tolerance."""
        azimuth, half = self.azimuth_deg, self.azimuth_deg < 180.0 - 1e-9
        score = self.miss.max(axis=1, initial=0.0)
        gap = np.diff(azimuth, append=azimuth[0] + 360.0)
        wanted = np.flatnonzero(half & (score > tolerance_deg) & (gap > LEAST_STEP_DEG))
        chosen = np.sort(wanted[np.argsort(-score[wanted], kind="stable")[: max(most, 0)]])
        return np.asarray(azimuth[chosen] + 0.5 * gap[chosen])

    @property
    def _own_error(self) -> Array:
        """The error of the solved tilts themselves, (A, K): their change from the coarser grid, and of those that have none
        the largest of their height."""
        unknown = np.fmax.reduce(self.change, axis=0, initial=0.0)
        unknown = np.where(np.isnan(self.change).all(axis=0), np.rad2deg(CLEAR_RAD), unknown)
        return np.maximum(np.where(np.isnan(self.change), unknown, self.change), np.rad2deg(RESOLUTION_RAD))

    def _height_error(self, beta: Array, height: Array, below: Index, above: Index) -> Array:
        full = self(beta, height)
        low, high = self(beta, self.height_km[below]), self(beta, self.height_km[above])
        between = np.maximum(np.abs(low - full), np.abs(high - full))
        count = len(self.height_km)
        if count < 5:
            return np.asarray(between)
        kept = np.unique(np.append(np.arange(0, count, 2), count - 1))
        return np.asarray(np.minimum(between, np.abs(self._over_height(beta, height, kept) - full)))

    def _over_height(self, azimuth_deg: ArrayLike, height_km: ArrayLike, kept: Index) -> Array:
        """Interpolated with some of the heights."""
        from scipy.interpolate import PchipInterpolator

        beta, height = np.broadcast_arrays(
            np.asarray(azimuth_deg, np.float64), np.asarray(height_km, np.float64)
        )
        out = np.full(beta.size, np.nan)
        inside = np.flatnonzero(self.covers(height.ravel()))
        if not inside.size:  # no splines through nothing
            return out.reshape(beta.shape)
        heights = self.height_km[kept]
        columns = _around(self.azimuth_deg, self.table[:, kept], beta.ravel()[inside])
        at = height.ravel()[inside]
        if len(heights) == 1:
            out[inside] = columns[:, 0]
        elif np.ptp(at) == 0.0:
            out[inside] = PchipInterpolator(heights, columns, axis=1)(at[0])
        else:
            out[inside] = [PchipInterpolator(heights, row)(x) for row, x in zip(columns, at, strict=True)]
        return out.reshape(beta.shape)


def _around(azimuth_deg: Array, tilts: Array, at_deg: Array) -> Array:
    """The periodic curves through tilts (A, K) at A azimuths, at other azimuths (B,): (B, K)."""
    from scipy.interpolate import CubicSpline

    points = np.append(azimuth_deg, azimuth_deg[0] + 360.0)
    inverse = np.maximum(np.vstack([tilts, tilts[:1]]), LEAST_TILT_DEG) ** -2.0
    squares = CubicSpline(points, inverse, bc_type="periodic")(np.mod(at_deg, 360.0))
    return np.asarray(np.maximum(squares, MOST_TILT_DEG**-2.0) ** -0.5)


def _filled(azimuth_deg: Array, tilt: Array, change: Array) -> tuple[Array, Array]:
    """A curve (A,) with its holes interpolated, and their error in `change`."""
    known = ~np.isnan(tilt)
    points = np.append(azimuth_deg[known], azimuth_deg[known][0] + 360.0)
    values = np.append(tilt[known], tilt[known][0])
    cubic = _around(azimuth_deg[known], tilt[known, None], azimuth_deg[~known])[:, 0]
    linear = np.interp(azimuth_deg[~known], points, values)
    tilt, change = tilt.copy(), change.copy()
    tilt[~known], change[~known] = cubic, np.abs(cubic - linear)
    return tilt, change
