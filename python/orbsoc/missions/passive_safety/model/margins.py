"""How much further than the keep-out a plan stays, so that it holds under navigation and execution errors."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from orbsoc.guidance.uncertainty import drift_rows
from orbsoc.orbit.array import Array

from .approach import Approach, after_half_orbit


@dataclass(frozen=True, slots=True, eq=False)
class Margins:
    """Lengths, and lengths by m/s of an impulse's size: of the first drift's far vertex, of the drift after each impulse."""

    first_m: float
    first_by_size_s: float
    drift_m: Array
    drift_by_size_s: float

    @classmethod
    def of(cls, approach: Approach, impulses: int) -> Margins | None:
        """Those of the scenario's uncertainty for a plan of that number of impulses; None without one.

        After an impulse, `sigmas` deviations of R at the worst time of the drift: of navigation and of the fixed part of
        the engine's error together, and of the share of its size, which an unknown bounds.
        """
        errors = approach.scenario.uncertainty
        if errors is None:
            return None
        n = approach.mean_motion_rad_s
        radial = drift_rows(approach.motion, np.eye(6)[:1], 0.0, approach.period_s)[:, 0]
        far = after_half_orbit(n)
        return cls(
            first_m=errors.sigmas * float(errors.deviation(far)),
            first_by_size_s=errors.sigmas * float(errors.gain(far)),
            drift_m=np.full(impulses, errors.sigmas * float(errors.deviation(radial).max())),
            drift_by_size_s=errors.sigmas * float(errors.gain(radial).max()),
        )
