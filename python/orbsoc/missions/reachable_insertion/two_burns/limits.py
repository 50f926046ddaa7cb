"""What bounds a transfer: how long the vehicle may coast, for how long it can burn, and how fast its thrust may turn."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from orbsoc.orbit.array import Array, Flags

from .transfer import Transfer


@dataclass(frozen=True, slots=True)
class Limits:
    """Canonical times: the latest ignition, the longest coast between burns, and all burns together; the least radius of a coast;
    the fastest turn of the thrust over a burn, rad per canonical time, None for any."""

    ignition: float
    coast: float
    burning: float
    lowest: float
    rate: float | None = None

    def clipped(self, transfer: Transfer) -> Transfer:
        """The transfer with its times within the limits; burns that are too long together, cut alike."""
        coasts = np.clip(transfer.coasts, 0.0, [self.ignition, self.coast])
        durations = np.maximum(transfer.durations, SHORTEST)
        durations *= min(1.0, self.burning / durations.sum())
        return Transfer(transfer.grid, coasts, durations, transfer.controls)

    def open(self, transfer: Transfer, step: Array) -> Flags:
        """Of a step of [coasts, durations] (2K,), which times it may move: not those at a bound that it leads over."""
        now = np.concatenate([transfer.coasts, transfer.durations])
        low = np.concatenate([np.zeros(2), np.full(2, SHORTEST)])
        high = np.concatenate([[self.ignition, self.coast], np.full(2, self.burning)])
        return np.asarray(~((now <= low) & (step < 0.0) | (now >= high) & (step > 0.0)))


SHORTEST = 1e-7
"""Canonical time of a burn that a linearisation can still be made about."""
