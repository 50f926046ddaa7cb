"""What every linear model of relative motion offers."""

from __future__ import annotations

from typing import Protocol

from ..array import Array


class LinearMotion(Protocol):
    """A linear model of the motion relative to a target, in the frame (R, T, N)."""

    def transition(self, t1_s: float, t0_s: float) -> Array:
        """Matrix (6, 6) that takes the state [r_m, v_m_s] at t0_s to that at t1_s; t1_s may lie before t0_s."""
        ...
