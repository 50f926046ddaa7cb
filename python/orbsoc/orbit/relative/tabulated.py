"""A relative motion whose transitions are looked up: one integration for any number of times."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..array import Array
from .reference import AlongReference

ORDER = 7
"""Of the splines: with a step of a hundredth of a radian their error is below rounding."""


class Tabulated:
    """Motion along a reference orbit, from 0 to `end_s`, by splines through its transitions at steps of `step_s` or less.

    Raises ValueError for a time outside.
    """

    def __init__(self, along: AlongReference, end_s: float, step_s: float) -> None:
        from scipy.interpolate import make_interp_spline

        self.along, self.end_s = along, end_s
        times = np.linspace(0.0, end_s, max(2 * ORDER, int(np.ceil(end_s / step_s))) + 1)
        along.prepare(times)
        each = times.tolist()
        self._there: Any = make_interp_spline(times, [along.transition(t, 0.0) for t in each], k=ORDER)
        self._back: Any = make_interp_spline(times, [along.transition(0.0, t) for t in each], k=ORDER)

    def transition(self, t1_s: float, t0_s: float) -> Array:
        """The state transition matrix (6, 6) from t0_s to t1_s, frame (R, T, N)."""
        return self.transitions(np.asarray(t1_s), np.asarray(t0_s))

    def transitions(self, t1_s: Array, t0_s: Array) -> Array:
        """Those to times (...,) from others (...,): (..., 6, 6)."""
        low, high = min(t1_s.min(), t0_s.min()), max(t1_s.max(), t0_s.max())
        if low < -1e-6 or high > self.end_s + 1e-6:
            raise ValueError(f"times from {low:g} to {high:g}: must be within 0 and {self.end_s:g}")
        return np.asarray(self._there(t1_s) @ self._back(t0_s))
