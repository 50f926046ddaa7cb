"""From impulses of the mean motion to those of the true one: flown onto the target, descended, their instants made finer."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from orbsoc.guidance.scp import ExitReason, Iteration, Solve, TrustRules
from orbsoc.orbit.array import Array

from ..model.approach import Approach, approach_at, approach_between
from ..scenario import Scenario
from .descent import Descended, descend, spread
from .drift import Transfer

BESIDE_S = ((40.0, 80.0, 160.0), (10.0, 20.0))
"""Before and after each impulse: instants of a round where it may be given instead."""
SMALL = 1e-5
"""Of the cost: smaller impulses are left out."""
RULES = TrustRules(radius=1e2, least_gain=1e-5, max_iterations=6)


def refine(
    scenario: Scenario,
    transfer: Transfer,
    *,
    solve: Solve,
    callback: Callable[[Iteration], None] | None = None,
) -> Descended | None:
    """The cheapest impulses near a transfer; None where Newton's method does not make it meet the target.

    `scenario` has the chaser on the state from which it departs.
    """
    ends, found = (transfer.start_s, transfer.end_s), None
    times, dv = _with_ends(transfer.times_s, transfer.dv_m_s, ends)
    for beside in BESIDE_S:
        roll = approach_at(scenario, times, by_elements=True).restore(dv)
        if roll is None:
            return found
        offsets = np.concatenate([-np.array(beside), beside])
        near = np.concatenate([times, (times[:, None] + offsets).ravel()])
        fine = approach_between(scenario, *ends, near, keep_s=times, by_elements=True)
        start = spread(fine, roll, times)
        if start is None:
            return found
        found = descend(fine, start, solve=solve, callback=callback, rules=RULES)
        if found.outcome.reason is ExitReason.INTERRUPTED:
            raise KeyboardInterrupt
        found = _without_small(fine, found)
        fired = np.any(found.roll.dv_m_s, axis=1)
        times, dv = _with_ends(fine.times_s[fired], found.roll.dv_m_s[fired], ends)
    return found


def _without_small(approach: Approach, found: Descended) -> Descended:
    """Without impulses that cost less than those of a programme may, but after weeks are hundreds of metres."""
    dv = found.roll.dv_m_s.copy()
    sizes = np.linalg.norm(dv, axis=1)
    dv[sizes < SMALL * sizes.sum()] = 0.0
    again = approach.restore(dv)
    if again is None or again.cost_m_s > (1.0 + 10.0 * SMALL) * found.roll.cost_m_s:
        return found
    return replace(found, outcome=replace(found.outcome, iterate=again))


def _with_ends(times_s: Array, dv_m_s: Array, ends_s: tuple[float, float]) -> tuple[Array, Array]:
    """Impulses with zeros at both ends where there are none; those within a second of each other are one."""
    times = np.concatenate([ends_s[:1], times_s, ends_s[1:]])
    dv = np.vstack([np.zeros(3), dv_m_s, np.zeros(3)])
    groups = np.cumsum(np.diff(times, prepend=-np.inf) > 1.0) - 1
    joined = np.zeros((groups[-1] + 1, 3))
    np.add.at(joined, groups, dv)
    first = times[np.unique(groups, return_index=True)[1]]
    first[-1] = ends_s[1]
    return first, joined
