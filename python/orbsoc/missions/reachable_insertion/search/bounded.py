"""The search under a bound on the attitude rate: first without it; where that burn turns too fast, within it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from orbsoc.guidance.scp import ExitReason, Outcome

from ..model.attitude_rate import peak_rate
from ..model.problems import Iterate
from ..plan.claims import Claim
from ..starts.directions import Start
from ..targets.rows import Row
from .found import Found
from .quick_turn import quickened
from .setup import InsertionSetup
from .start_search import GROWTH, Search, fly_and_verify
from .turning import TurningSearch, finished, is_feasible

TOO_QUICK = "the same, and the bound on the attitude rate"
MARGIN = 1e-4
"""Share of the bound that the convex problem keeps free, for what its interpolant turns faster between the cones."""
ROUNDS = 4
"""In which the bound of the convex problem is lowered by what the flown attitude exceeds the true one."""
TOO_FAST = 1.05
"""Of the bound; an attitude that turns faster still was not stopped by the interpolant."""
GAIN = 1e-3
"""Share of the burn that a finer grid has to save, before the next one is tried."""


@dataclass(frozen=True, slots=True)
class BoundedSearch(TurningSearch):
    """A search whose burns turn no faster than the scenario allows."""

    def run(self, ready: InsertionSetup) -> Found:
        return self._bounded(ready, Search.run(self, ready.unbounded))

    def run_from(self, ready: InsertionSetup, start: Start) -> Found:
        return self._bounded(ready, Search.run_from(self, ready.unbounded, start), refine=False)

    def _bounded(self, ready: InsertionSetup, free: Found, *, refine: bool = True) -> Found:
        found = Found(ready, list(free.stages), proof=free.proof, interrupted=free.interrupted)
        if free.best is None or found.interrupted or found.proof is not None:
            found.best, found.verification = free.best, free.verification
            return found
        allowed = None if free.verification is None else fly_and_verify(ready, free.iterate)
        if allowed is not None and allowed.verified:
            found.best, found.verification = free.best, allowed
            if free.best.claim is not Claim.SMOOTH_TURN:  # the shortest without the bound
                return found
            if refine and self._quick(ready, found, free):
                return found
        try:
            self._grids(ready, found, free.iterate, refine=refine)
        except KeyboardInterrupt:
            found.interrupted = "interrupted in the search within the attitude rate"
        if not found.verified:
            _conclude(ready, found, free)
        return found

    def _quick(self, ready: InsertionSetup, found: Found, free: Found) -> bool:
        """Whether the fastest turn that a grid follows keeps the bound: then it is the answer."""
        quick = Found(free.ready, list(free.stages), free.best, free.verification)
        quickened(self, quick)
        found.interrupted = quick.interrupted
        verification = fly_and_verify(ready, quick.iterate)
        if quick.interrupted or verification is None or not verification.verified:
            return bool(quick.interrupted)
        found.stages, found.best, found.verification = quick.stages, quick.best, verification
        return True

    def _grids(self, ready: InsertionSetup, found: Found, reference: Iterate, *, refine: bool) -> None:
        """From coarse to fine, as long as a finer grid finds a shorter or better burn."""
        method, nodes = ready.scenario.method, ready.scenario.method.nodes
        last: float | None = None
        while True:
            ended = self._within(ready, found, ready.resampled(reference, nodes))
            if ended is None or found.interrupted:
                return
            reference, verified = ended
            aim = _aim(ready, reference)
            converged = verified and last is not None and last - aim < GAIN * abs(last)
            if converged or not refine or nodes == method.max_nodes:
                return
            last = aim if verified else None
            nodes = min(method.max_nodes, int(np.ceil(GROWTH * nodes)))

    def _within(self, ready: InsertionSetup, found: Found, reference: Iterate) -> tuple[Iterate, bool] | None:
        """The burn on one grid, and whether its flight confirms it; None where the bound and the target do not go together."""
        bound = ready.rate_bound
        assert bound is not None
        share, price = 1.0 - MARGIN, 0.0
        ended: tuple[Iterate, bool] | None = None
        for _ in range(ROUNDS):
            stage, price = self.at_rate(ready, found, reference, share * bound, price)
            reference = stage.outcome.iterate
            if found.interrupted or not is_feasible(stage):
                return ended
            stage, verification = finished(ready, found, stage)
            if verification is None:
                return ended
            faster = verification.peak_rate_rad_s * ready.units.time_s / bound
            ended = reference, verification.verified
            if faster <= 1.0:
                found.consider(stage, verification)
                return ended
            if faster > TOO_FAST:
                return None
            share *= (1.0 - MARGIN) / faster
        return ended


def _aim(ready: InsertionSetup, iterate: Iterate) -> float:
    """What a finer grid makes smaller: the burn time, or the energy with its sign changed."""
    arc = iterate.trajectory
    if ready.scenario.problem == "min_time":
        return arc.duration
    return float(1.0 / np.linalg.norm(arc.end[:3]) - 0.5 * arc.end[3:] @ arc.end[3:])


def _conclude(ready: InsertionSetup, found: Found, free: Found) -> None:
    """Nothing within the bound: the burn without it, and by how much it turns too fast."""
    bound = ready.rate_bound
    assert bound is not None
    assert free.best is not None
    arc = free.iterate.trajectory
    if free.verification is None or free.verification.below_ground or found.verification is not None:
        if found.best is None:
            found.best, found.verification = free.best, None
        return
    excess = 2.0 * peak_rate(arc.grid, arc.controls) / arc.duration - bound
    iterate = replace(free.iterate, slack=((Row.ATTITUDE_RATE, excess),))
    message = "the burn that reaches the target turns faster than is allowed, and none that turns more slowly was found"
    outcome = Outcome(ExitReason.INFEASIBLE, iterate, (), message)
    stage = replace(free.best, note=TOO_QUICK, outcome=outcome, claim=Claim.BEST_FOUND)
    found.stages.append(stage)
    found.best, found.verification = stage, None
