"""What it costs to be safe also when a burn stops half-way, by how long the approach may take."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, isfinite, pi
from typing import Any

import numpy as np

from orbsoc.conic.settings import Settings
from orbsoc.guidance.scp import Solve

from ..model.approach import Approach
from ..model.problem import assemble
from .timing import usable

DURATIONS = 6
LONGEST_ORBITS = 0.8
"""By which the longest approach of the front is longer than the scenario's."""
SECONDS = 24
"""Times of the second impulse that are tried for each point."""
CANDIDATES = 24
"""Times between it and the end at which another impulse may come."""


@dataclass(frozen=True, slots=True)
class FrontPoint:
    """The cheapest approach of a duration on a coarse grid of times; infinite where there is none."""

    duration_s: float
    orbits: int
    cost: float

    def to_dict(self) -> dict[str, Any]:
        """A row of `front` in plan.json."""
        cost = self.cost if isfinite(self.cost) else None
        return {"duration_s": self.duration_s, "interruption_orbits": self.orbits, "cost": cost}


def interruption_front(approach: Approach, solve: Solve) -> tuple[FrontPoint, ...]:
    """Points for durations from the scenario's on and 0, 1, 2 orbits. Raises KeyboardInterrupt in a solve that is."""
    longest = approach.duration_s + LONGEST_ORBITS * approach.period_s
    return tuple(
        FrontPoint(float(duration), orbits, _cost(approach, float(duration), orbits, solve))
        for orbits in (0, 1, 2)
        for duration in np.linspace(approach.duration_s, longest, DURATIONS)
    )


def _cost(approach: Approach, duration_s: float, orbits: int, solve: Solve) -> float:
    changed = approach.scenario.with_changes(
        duration_s=duration_s, interruption_orbits=orbits, compare_with=None
    )
    varied = Approach.of(changed)
    latest = min(duration_s, pi / approach.mean_motion_rad_s)
    best = inf
    for second in np.linspace(0.0, latest, SECONDS + 2)[1:-1]:
        rest = np.linspace(second, duration_s, CANDIDATES + 1)
        times = np.concatenate([[0.0], rest if varied.capture_velocity is not None else rest[:-1]])
        solution = solve(assemble(varied, times).builder.build(), Settings())
        if usable(solution):
            best = min(best, solution.objective)
    return best
