"""That no time of the second impulse will do, proved for all of its interval about a circular target."""

from __future__ import annotations

from collections.abc import Callable
from math import pi

import numpy as np

from orbsoc.guidance.impulses import Family, Impulses, Nowhere, nowhere_feasible
from orbsoc.guidance.scp import Solve
from orbsoc.orbit.array import Array
from orbsoc.orbit.relative import DriftEllipse

from ..model.approach import Approach
from ..model.margins import Margins
from ..model.problem import assemble, first_leg

LARGEST_M_S = 100.0
"""Of an impulse's components in the proof: the largest speed that a scenario may state."""
APART_S = 1e-3
"""Of the second impulse from the first and from the end."""


def proved_impossible(
    approach: Approach, times_after: Callable[[float], Array] | None, solve: Solve
) -> Nowhere | None:
    """No second impulse will do, with the others at the times that follow from it; without these, whatever they are.

    None where nothing is proved: about an eccentric target, or without a keep-out, nothing is tried.
    """
    if not (approach.circular and approach.guarded):
        return None
    n, start = approach.mean_motion_rad_s, DriftEllipse.of(approach.start, approach.mean_motion_rad_s)

    def built(second_s: float) -> Impulses:
        if times_after is None:
            return first_leg(approach, second_s, Margins.of(approach, 2))
        times = times_after(second_s)
        return assemble(approach, times, margins=Margins.of(approach, times.size))

    low, high = APART_S, min(approach.duration_s - APART_S, pi / n)
    some = built(0.5 * (low + high))
    largest = np.full(some.builder.build().n, 2.0 * LARGEST_M_S)  # of the norms, which need not be larger
    largest[some.dv.index.ravel()] = LARGEST_M_S
    # Rows are n times a position or 1 times a velocity, after 1 m/s (4/n at most) or from the start's own ellipse.
    family = Family(
        lambda second_s: built(second_s).builder.build(), (low, high), largest, matrix_bend=4.0 * n**2,
        side_bend=n**3 * max(2.0 * start.minor_m, start.normal_m),
    )  # fmt: skip
    return nowhere_feasible(family, solve)
