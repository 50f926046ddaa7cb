"""Where the shortest burn reverses its thrust faster than any grid follows: about the fastest turn that the finest one does.

`search` ends there with a law that turns smoothly. From it the sequence goes on with a bound on the attitude rate that no scenario
asked for, on few nodes, and the finest grid follows what that finds. The bound is raised until a flight no longer confirms the burn.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from orbsoc.guidance.scp import Rules

from ..model.attitude_rate import peak_rate
from ..model.problems import Iterate
from ..plan.claims import Claim
from ..starts.steering_law import grid_resolves, through
from .found import Found
from .setup import InsertionSetup
from .start_search import GROWTH, Search
from .turning import TurningSearch, finished, is_feasible

QUICK = "as fast a turn as the finest grid follows"
FIRST, FASTER = 2.5, 1.25
"""Factors on the smooth law's fastest turn, and on the last bound that a burn was found with."""
COARSE, FEWEST = 0.375, 6
"""Nodes of the sequence, in those of the finest grid, which needs the others to follow what is drawn between them; and no fewer."""
CLOSE = 1.015
"""Ratio of a bound that fails to one that leads to a plan, from which on others save some 0.01 % of the burn at most."""
MOST_TRIED = 10
RULES = Rules(step_tol=1e-5, tighten_below=1e-3, max_iterations=20)
"""The flight's correction does what is left: 17 iterations at 16 °/s end within 1e-5 of the burn that 30 lead to."""
STEPS = 96
"""Of a flight in that correction; with the usual 48 a turn of a tenth of the burn ends 1e-8 beside its orbit."""


def quickened(search: Search, found: Found) -> None:
    """Add to what a search found shorter burns, where its best one is a smooth law."""
    if found.best is None or found.best.claim is not Claim.SMOOTH_TURN or found.interrupted:
        return
    try:
        rules = replace(RULES, max_iterations=min(RULES.max_iterations, search.rules.max_iterations))
        _raise_the_bound(TurningSearch(search.solve, rules, search.callback), found)
    except KeyboardInterrupt:
        found.interrupted = "interrupted in the search for a faster turn"
    found.stages.remove(found.best)
    found.stages.append(found.best)  # the last stage is the one that counts


def _grid_resolves(ready: InsertionSetup, iterate: Iterate) -> bool:
    """Whether the finest grid follows the directions of a burn, before they are corrected in flight."""
    arc, scenario = iterate.trajectory, ready.scenario
    law = through(arc.grid, arc.controls, arc.duration)
    return grid_resolves(law, scenario.method.max_nodes, scenario.verification.thrust_excess)


def _raise_the_bound(search: TurningSearch, found: Found) -> None:
    ready, arc = found.ready, found.iterate.trajectory
    method = ready.scenario.method
    nodes = min(int(np.ceil(GROWTH * method.nodes)), max(FEWEST, int(COARSE * method.max_nodes)))
    nodes = min(nodes, method.max_nodes)
    slow = 2.0 * peak_rate(arc.grid, arc.controls) / arc.duration
    low, high, rate = slow, np.inf, FIRST * slow
    reference = ready.resampled(found.iterate, nodes)
    for _ in range(MOST_TRIED):
        stage, _price = search.at_rate(ready, found, reference, rate, name=QUICK, claim=Claim.FAST_TURN)
        if found.interrupted:
            return
        before = found.best
        if is_feasible(stage):
            reference = stage.outcome.iterate
            if _grid_resolves(ready, reference):
                found.consider(*finished(ready, found, stage, steps=STEPS))
        shorter = found.best is not before
        low, high = (rate, high) if shorter else (low, rate)
        if high < CLOSE * low:
            return
        rate = FASTER * low if high == np.inf else float(np.sqrt(low * high))
