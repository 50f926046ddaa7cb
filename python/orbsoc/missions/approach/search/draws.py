"""Starts that are drawn about flights: all go a little way, and the cheapest of them to the end.

Planes seen from a flight keep the next one on its side of the keep-out, and in its time. A plan that passes on another side, or goes
round the target before it comes to the gate, may cost less. Draws of the impulses begin there.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from orbsoc.guidance.impulses import ImpulseProgramme
from orbsoc.guidance.scp import Iteration, Solve
from orbsoc.orbit.array import Array

from ..model.approach import Approach
from ..model.instants import Instants, at_nodes
from ..model.nearest import Search
from ..model.problem import Forms
from .sequence import RULES, Attempt, Found, attempt

DRAWS = 5
"""About each flight."""
SPREAD = 0.3
"""Standard deviation of each component of an impulse, as a share of the keep-out by the mean motion."""
A_LITTLE = replace(RULES, max_iterations=16)
TO_THE_END = replace(RULES, max_iterations=80)
FINALISTS = 2
"""Starts that go to the end."""
OF_AN_ARC = 96
"""Intervals of an arc at which it is looked at: flights round the target turn more on it."""


def drawn(
    approach: Approach,
    flights: Sequence[ImpulseProgramme],
    solve: Solve,
    callback: Callable[[Iteration], None] | None,
) -> list[Attempt]:
    """Sequences about draws of these flights, the same at each call; those that went to the end come first."""
    solid = replace(approach, across=True)
    forms, search, random = Forms(solid), Search(solid, OF_AN_ARC), np.random.default_rng(0)
    to_gate = _that_arrive(approach)
    size = SPREAD * float(np.max(approach.outer_m)) * approach.mean_motion_rad_s
    found: list[Attempt] = []
    for flight in (each for each in flights for _ in range(DRAWS)):
        dv = flight.dv_m_s.copy()
        kicks = (to_gate @ random.standard_normal(len(to_gate))).reshape(-1, 3)
        dv[: len(kicks)] += size * kicks
        start = Found(ImpulseProgramme(flight.times_s, dv), forms.begun(at_nodes(solid), Instants()))
        name = f"about draw {len(found) + 1}"
        found.append(attempt(solid, forms, name, None, solve, callback, start, rules=A_LITTLE, search=search))
    found.sort(key=lambda each: each.reference.cost if each.found else np.inf)
    for k, each in enumerate(found[:FINALISTS]):
        if each.found:
            more = attempt(
                solid,
                forms,
                each.side,
                None,
                solve,
                callback,
                each.reference,
                rules=TO_THE_END,
                search=search,
            )
            better = more if more.found and more.reference.cost < each.reference.cost else each
            found[k] = replace(better, subproblems=(*each.subproblems, *more.subproblems))
    return [replace(each, forms=forms, drawn=True) for each in found]


def _that_arrive(approach: Approach) -> Array:
    """From draws of G impulses, up to the arrival at the gate, to those that change nothing of the state there, (3 G, 3 G)."""
    arrive_s = approach.scenario.gate.arrive_s
    times = approach.times_s[approach.times_s <= arrive_s + 1e-6].tolist()
    moved = np.hstack([approach.motion.transition(arrive_s, t)[:, 3:] for t in times])
    return np.asarray(np.eye(moved.shape[1]) - np.linalg.pinv(moved) @ moved)
