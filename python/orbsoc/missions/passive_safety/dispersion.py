"""Dispersed cases, and flights with errors: where the chaser holds before the approach, and what errors on the way do.

Fly the approach with navigation and execution errors, many times: re-planned before every burn, or as planned.

Dynamics are those of the model; a run is unsafe if the drift after any of its burns, should no other follow, enters the
keep-out within one orbit. Every re-plan is one relaxed problem, so that there is always an answer, and what it gave up is
counted: depth that the margins ask for, and the capture point.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from orbsoc.conic.settings import Settings
from orbsoc.guidance.impulses import ImpulseProgramme
from orbsoc.guidance.monte_carlo import Dispersion, Spread
from orbsoc.guidance.safety import drift_clearance
from orbsoc.guidance.scp import Solve
from orbsoc.orbit.array import Array

from .model.approach import Approach
from .model.margins import Margins
from .model.problem import GIVEN_UP, assemble
from .scenario import Scenario
from .search.timing import usable

GIVEN_UP_M = 0.01
"""Depth from which on a re-plan counts as one that could not keep its margins."""

DISPERSION = Dispersion((Spread("position", "start.x_m", 10.0),), source="assumed")


def disperse(scenario: Scenario, number: int, seed: int = 0) -> Scenario:
    """Case `number` of `scenario`; it is no row of the paper. Raises ScenarioError as `Dispersion.case` does."""
    return DISPERSION.case(scenario, number, seed, compare_with=None)


@dataclass(frozen=True, slots=True, eq=False)
class MonteCarlo:
    """Of `runs` flights: how many came into the keep-out, least distances (runs,), misses of the capture point (runs,),
    Δv (runs,); and of the re-plans, how many gave up some of their margin, the most of it, and how many failed."""

    runs: int
    seed: int
    unsafe: int
    nearest_m: Array
    miss_m: Array
    delta_v_m_s: Array
    replans: int
    fallbacks: int
    most_given_up_m: float
    failed: int

    def to_dict(self) -> dict[str, Any]:
        """Of `monte_carlo` in plan.json."""
        return {
            "runs": self.runs,
            "seed": self.seed,
            "unsafe": self.unsafe,
            "nearest_m": float(self.nearest_m.min()),
            "miss_m": {"mean": float(self.miss_m.mean()), "largest": float(self.miss_m.max())},
            "delta_v_m_s": {"mean": float(self.delta_v_m_s.mean()), "largest": float(self.delta_v_m_s.max())},
            "replans": self.replans,
            "fallbacks": self.fallbacks,
            "most_given_up_m": self.most_given_up_m,
            "failed": self.failed,
        }


def fly_many(
    approach: Approach,
    programme: ImpulseProgramme,
    solve: Solve,
    *,
    replan: bool = True,
    margins: bool = True,
    runs: int | None = None,
) -> MonteCarlo:
    """Fly with the errors of the scenario's uncertainty: `programme` as it is, or re-planned at its times.

    Run k draws from (seed, k), so that other runs do not change it. Raises KeyboardInterrupt in a solve that is.
    """
    errors = approach.scenario.uncertainty
    assert errors is not None
    count = errors.runs if runs is None else runs
    nearest, miss, spent = np.empty(count), np.empty(count), np.zeros(count)
    replans = fallbacks = failed = 0
    most = 0.0
    for run in range(count):
        random = np.random.default_rng([errors.seed, run])
        state, at = approach.start, 0.0
        planned = programme.dv_m_s
        after = []
        for k, t in enumerate(programme.times_s.tolist()):
            state = approach.motion.transition(t, at) @ state
            at = t
            estimate = errors.navigated(state, random)
            if replan:
                found, given_up, solved = replanned(
                    approach, programme.times_s[k:], estimate, k, solve, margins=margins
                )
                replans += 1
                failed += not solved
                fallbacks += solved and given_up > GIVEN_UP_M
                most = max(most, given_up)
                if solved:
                    planned = np.concatenate([planned[:k], found])
            dv = errors.executed(planned[k], random)
            spent[run] += float(np.linalg.norm(dv))
            state = state.copy()
            state[3:] += dv
            after.append(state)
        nearest[run] = drift_clearance(after, approach.mean_motion_rad_s, approach.period_s).distance_m.min()
        end = approach.motion.transition(approach.duration_s, at) @ state
        miss[run] = float(np.linalg.norm(end[:3] - approach.capture))
    unsafe = int((nearest < approach.keep_out_m).sum())
    return MonteCarlo(count, errors.seed, unsafe, nearest, miss, spent, replans, fallbacks, most, failed)


def replanned(
    approach: Approach, times_s: Array, estimate: Array, done: int, solve: Solve, *, margins: bool
) -> tuple[Array, float, bool]:
    """Impulses (N − done, 3) from an estimated state, the depth given up in m, and whether there is an answer."""
    kept = Margins.of(approach, times_s.size) if margins else None
    impulses = assemble(approach, times_s, margins=kept, start=estimate, done=done, relaxed=True)
    solution = solve(impulses.builder.build(), Settings(tol=1e-8))
    if not usable(solution):
        return np.zeros((times_s.size, 3)), 0.0, False
    given_up = float(impulses.builder.value(solution, GIVEN_UP)[0]) / approach.mean_motion_rad_s
    return impulses.programme(solution).dv_m_s, max(0.0, given_up), True
