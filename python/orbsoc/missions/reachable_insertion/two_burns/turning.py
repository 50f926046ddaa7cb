"""How fast the thrust of a transfer turns, and the same transfer turning no faster than is allowed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from orbsoc.orbit.array import Array

from ..model.attitude_rate import peak_rate, slope_matrix
from .transfer import Transfer

ROUNDS = 30
"""In which directions are drawn together; one is enough where they are close."""
MARGIN = 1e-6
"""Share of the bound that is kept free, for burns that a correction shortens afterwards."""
STILL = 1e-9
"""Rate per unit of τ, below which rounding makes a good part of it."""
LEAST_SHARE = 0.9
"""Of the bound that the convex problem holds; see `held_shares`."""


def turn_rates(transfer: Transfer) -> Array:
    """The fastest turn over each burn (K,), rad per canonical time."""
    peaks = np.array([peak_rate(transfer.grid, each) for each in transfer.controls])
    return np.asarray(2.0 * peaks / transfer.durations)


def slowed(transfer: Transfer, rate: float) -> Transfer:
    """The same with the directions of each burn that is too fast drawn towards their mean, until it turns at `rate` at most."""
    controls = transfer.controls.copy()
    for _ in range(ROUNDS):
        rates = turn_rates(replace(transfer, controls=controls))
        fast = np.flatnonzero(rates > rate)
        if not fast.size:
            break
        for k in fast:
            middle = _mean(transfer.grid.weights @ controls[k], controls[k])
            drawn = middle + (1.0 - MARGIN) * rate / rates[k] * (controls[k] - middle)
            controls[k] = drawn / np.linalg.norm(drawn, axis=1, keepdims=True)
    return replace(transfer, controls=controls)


def held_shares(transfer: Transfer) -> Array:
    """The share of a bound (K,) for |p'| on the bounded points, so that the direction of this p keeps it in between, too."""
    bounded = np.linalg.norm(slope_matrix(transfer.grid.size) @ transfer.controls, axis=2).max(axis=1)
    peaks = np.array([peak_rate(transfer.grid, each) for each in transfer.controls])
    shares = np.where(peaks > STILL, bounded / np.maximum(peaks, STILL), 1.0)
    return np.asarray(np.clip(shares, LEAST_SHARE, 1.0) - 2.0 * MARGIN)


def _mean(middle: Array, directions: Array) -> Array:
    """The unit vector along a sum of directions (N, 3); the direction half-way where they cancel."""
    size = float(np.linalg.norm(middle))
    return middle / size if size > 0.1 else directions[len(directions) // 2]
