"""Navigation and execution errors: what they may do to a drift, and draws of them by seed."""

from __future__ import annotations

from math import erfc, sqrt

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field

from orbsoc.orbit.array import Array
from orbsoc.orbit.relative import LinearMotion

from .scenario_file import Table

PHASES = 360
"""Times in a revolution at which errors of a drift are looked at."""


class Uncertainty(Table):
    """Standard deviations an axis: of navigation at each impulse, and of what the engine does with each."""

    position_m: float = Field(ge=0.0, le=1e4)
    velocity_m_s: float = Field(ge=0.0, le=10.0)
    execution_share: float = Field(default=0.0, ge=0.0, le=0.3, description="of an impulse's size")
    execution_fixed_m_s: float = Field(default=0.0, ge=0.0, le=1.0)
    sigmas: float = Field(default=3.0, ge=0.0, le=10.0, description="that a margin covers")
    runs: int = Field(default=200, ge=0, le=100_000, description="of the Monte Carlo; 0 for none")
    seed: int = Field(default=0, ge=0)

    @property
    def left_out(self) -> float:
        """The share of normal draws beyond `sigmas`, on one side."""
        return 0.5 * erfc(self.sigmas / sqrt(2.0))

    def covariance(self) -> Array:
        """Of a state as navigated, (6, 6)."""
        return np.diag(np.repeat([self.position_m**2, self.velocity_m_s**2], 3))

    def deviation(self, row: ArrayLike) -> Array:
        """Standard deviation, without the share of the impulse, of `row` · state just after an impulse; row (..., 6)."""
        weights = np.asarray(row, np.float64)
        navigated = np.einsum("...i,ij,...j->...", weights, self.covariance(), weights)
        fired = self.execution_fixed_m_s**2 * np.sum(weights[..., 3:] ** 2, axis=-1)
        return np.asarray(np.sqrt(navigated + fired))

    def gain(self, row: ArrayLike) -> Array:
        """The same of the share of an impulse, by m/s of its size."""
        return np.asarray(self.execution_share * np.linalg.norm(np.asarray(row)[..., 3:], axis=-1))

    def navigated(self, state: Array, random: np.random.Generator) -> Array:
        """The state (6,) as navigation has it."""
        sigma = np.repeat([self.position_m, self.velocity_m_s], 3)
        return np.asarray(state + sigma * random.standard_normal(6))

    def executed(self, dv_m_s: Array, random: np.random.Generator) -> Array:
        """The velocity change (3,) as the engine gives it; an impulse of 0 is not fired."""
        size = float(np.linalg.norm(dv_m_s))
        if size == 0.0:
            return dv_m_s
        shares, fixed = random.standard_normal((2, 3))
        return np.asarray(dv_m_s + self.execution_share * size * shares + self.execution_fixed_m_s * fixed)


def drift_rows(motion: LinearMotion, matrix: ArrayLike, at_s: float, period_s: float) -> Array:
    """matrix · Φ(at + t, at) for t over one revolution, (PHASES + 1, rows, 6)."""
    rows = np.atleast_2d(np.asarray(matrix, np.float64))
    times = at_s + np.linspace(0.0, period_s, PHASES + 1)
    return np.array([rows @ motion.transition(float(t), at_s) for t in times])
