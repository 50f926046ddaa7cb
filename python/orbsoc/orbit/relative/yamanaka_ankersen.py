"""Relative motion about an eccentric orbit."""

from __future__ import annotations

from dataclasses import dataclass
from math import atan2, cos, pi, remainder, sin, sqrt

import numpy as np

from ..array import Array


def true_anomaly(mean_anomaly_rad: float, ecc: float) -> float:
    """True anomaly of a mean anomaly on an ellipse, rad, in the same revolution: Kepler's equation by Newton's method."""
    within = remainder(mean_anomaly_rad, 2.0 * pi)
    eccentric = within + ecc * sin(within) / (1.0 - sin(within + ecc) + sin(within)) if ecc else within
    for _ in range(50):
        step = (eccentric - ecc * sin(eccentric) - within) / (1.0 - ecc * cos(eccentric))
        eccentric -= step
        if abs(step) < 1e-15:
            break
    return (mean_anomaly_rad - within) + 2.0 * atan2(
        sqrt(1.0 + ecc) * sin(eccentric / 2.0), sqrt(1.0 - ecc) * cos(eccentric / 2.0)
    )


def mean_anomaly(true_anomaly_rad: float, ecc: float) -> float:
    """The inverse of `true_anomaly`."""
    within = remainder(true_anomaly_rad, 2.0 * pi)
    half = within / 2.0
    eccentric = 2.0 * atan2(sqrt(1.0 - ecc) * sin(half), sqrt(1.0 + ecc) * cos(half))
    return (true_anomaly_rad - within) + eccentric - ecc * sin(eccentric)


@dataclass(frozen=True, slots=True)
class YamanakaAnkersen:
    """Motion relative to a target on an ellipse, to first order in the distance over the radius.

    `anomaly_rad` is the target's true anomaly at t = 0. Source: Yamanaka & Ankersen, J. Guidance 25(1), 2002, whose
    general solution is taken at both times; its constants at the first are found by solving, not by the printed inverse.
    Raises ValueError unless the mean motion is positive and 0 ≤ ecc < 1.
    """

    mean_motion_rad_s: float
    ecc: float
    anomaly_rad: float = 0.0

    def __post_init__(self) -> None:
        if not 0.0 < self.mean_motion_rad_s < float("inf"):
            raise ValueError(f"mean_motion_rad_s = {self.mean_motion_rad_s!r}: must be positive and finite")
        if not 0.0 <= self.ecc < 1.0:
            raise ValueError(f"ecc = {self.ecc!r}: must be 0 or more and below 1")

    @property
    def period_s(self) -> float:
        return 2.0 * pi / self.mean_motion_rad_s

    def true_anomaly(self, t_s: float) -> float:
        """Of the target, rad."""
        start = mean_anomaly(self.anomaly_rad, self.ecc)
        return true_anomaly(start + self.mean_motion_rad_s * t_s, self.ecc)

    def transition(self, t1_s: float, t0_s: float) -> Array:
        """The state transition matrix (6, 6) from t0_s to t1_s, frame (R, T, N)."""
        first, second = self.true_anomaly(t0_s), self.true_anomaly(t1_s)
        rate = self.mean_motion_rad_s * (1.0 - self.ecc**2) ** -1.5  # k² of the paper, θ̇ = k² ρ²
        found = np.zeros((6, 6))
        plane = self._general(second, rate * (t1_s - t0_s)) @ np.linalg.inv(self._general(first, 0.0))
        found[np.ix_(_PLANE, _PLANE)] = self._in_time(second, rate) @ plane @ self._in_anomaly(first, rate)
        turn = second - first
        across = np.array([[cos(turn), sin(turn)], [-sin(turn), cos(turn)]])
        found[np.ix_(_ACROSS, _ACROSS)] = (
            self._in_time(second, rate)[_ONE] @ across @ self._in_anomaly(first, rate)[_ONE]
        )
        return found

    def _general(self, theta: float, integral: float) -> Array:
        """The general solution (R̃, T̃, R̃′, T̃′) by its four constants; integral = k² (t − t₀)."""
        e = self.ecc
        rho = 1.0 + e * cos(theta)
        s, c = rho * sin(theta), rho * cos(theta)
        ds, dc = cos(theta) + e * cos(2.0 * theta), -(sin(theta) + e * sin(2.0 * theta))
        return np.array(
            [
                [0.0, -s, -c, -(2.0 - 3.0 * e * s * integral)],
                [1.0, -c * (1.0 + 1.0 / rho), s * (1.0 + 1.0 / rho), 3.0 * rho**2 * integral],
                [0.0, -ds, -dc, 3.0 * e * (ds * integral + s / rho**2)],
                [0.0, 2.0 * s, 2.0 * c - e, 3.0 * (1.0 - 2.0 * e * s * integral)],
            ]
        )

    def _in_anomaly(self, theta: float, rate: float) -> Array:
        """(r, ṙ) of two axes to ρ r and its derivative by the anomaly: −e sin θ r + ṙ/(k² ρ)."""
        rho = 1.0 + self.ecc * cos(theta)
        slope, pace = -self.ecc * sin(theta), 1.0 / (rate * rho)
        return np.kron(np.array([[rho, 0.0], [slope, pace]]), np.eye(2))

    def _in_time(self, theta: float, rate: float) -> Array:
        """The inverse of `_in_anomaly`."""
        rho = 1.0 + self.ecc * cos(theta)
        return np.kron(np.array([[1.0 / rho, 0.0], [rate * self.ecc * sin(theta), rate * rho]]), np.eye(2))


_PLANE = [0, 1, 3, 4]
_ACROSS = [2, 5]
_ONE = np.ix_([0, 2], [0, 2])
"""Of the matrices for two axes, those for one."""
