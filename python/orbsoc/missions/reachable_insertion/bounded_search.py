"""The search under a bound on the attitude rate: first without it; where that burn turns too fast, within it.

Relaxed to |u| ≤ 1, a turn that the bound slows down takes the short way through the inside of the ball, at part of the thrust.
Where that happens, thrust that is missing gets a price above its worth, linearised about the last iterate (the convex–concave
procedure, Yuille & Rangarajan 2003), and the sequence ends on the sphere again.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from orbsoc.guidance.scp import ExitReason, Outcome

from .attitude_rate import RateBound, peak_rate
from .burn_plan import Stage
from .made_ready import MadeReady
from .problems import Iterate
from .rows import Row
from .search import GROWTH, SLACK_LEFT, SMOOTH, Found, Search, judged, nodes_that_follow
from .smooth_burn import through, unit_on
from .starts import REACHED, Start
from .verification import Verification

TURNING = "turning within the bound"
TOO_QUICK = "the same, and the bound on the attitude rate"
MARGIN = 1e-4
"""Share of the bound that the convex problem keeps free, for what its interpolant turns faster between the cones."""
FIRST_PRICE, HIGHEST_PRICE = 2.0, 32.0
LOOSE = 1e-4
"""1 − |u| at a node, from which on the relaxation is not tight."""
ROUNDS = 4
"""In which the bound of the convex problem is lowered by what the flown attitude exceeds the true one."""
TOO_FAST = 1.05
"""Of the bound; an attitude that turns faster still was not stopped by the interpolant."""
GAIN = 1e-3
"""Share of the burn that a finer grid has to save, before the next one is tried."""


@dataclass(frozen=True, slots=True)
class BoundedSearch(Search):
    """A search whose burns turn no faster than the scenario allows."""

    def run(self, ready: MadeReady) -> Found:
        return self._bounded(ready, Search.run(self, ready.unbounded))

    def run_from(self, ready: MadeReady, start: Start) -> Found:
        return self._bounded(ready, Search.run_from(self, ready.unbounded, start), refine=False)

    def _bounded(self, ready: MadeReady, free: Found, *, refine: bool = True) -> Found:
        found = Found(ready, list(free.stages), proof=free.proof, interrupted=free.interrupted)
        if free.best is None or found.interrupted or found.proof is not None:
            found.best, found.verification = free.best, free.verification
            return found
        allowed = None if free.verification is None else judged(ready, free.iterate)
        if allowed is not None and allowed.verified:
            found.best, found.verification = free.best, allowed
            if free.best.note != SMOOTH:  # the shortest without the bound
                return found
        try:
            self._grids(ready, found, free.iterate, refine=refine)
        except KeyboardInterrupt:
            found.interrupted = "interrupted in the search within the attitude rate"
        if not found.verified:
            _conclude(ready, found, free)
        return found

    def _grids(self, ready: MadeReady, found: Found, reference: Iterate, *, refine: bool) -> None:
        """From coarse to fine, as long as a finer grid finds a shorter or better burn."""
        method, nodes = ready.scenario.method, ready.scenario.method.nodes
        last: float | None = None
        while True:
            ended = self._within(ready, found, ready.resampled(reference, nodes))
            if ended is None or found.interrupted:
                return
            reference, verified = ended
            aim = _aim(ready, reference)
            settled = verified and last is not None and last - aim < GAIN * abs(last)
            if settled or not refine or nodes == method.max_nodes:
                return
            last = aim if verified else None
            nodes = min(method.max_nodes, int(np.ceil(GROWTH * nodes)))

    def _within(self, ready: MadeReady, found: Found, reference: Iterate) -> tuple[Iterate, bool] | None:
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

    def at_rate(
        self,
        ready: MadeReady,
        found: Found,
        reference: Iterate,
        rate: float,
        price: float = 0.0,
        *,
        name: str = TURNING,
    ) -> tuple[Stage, float]:
        """The burn on the grid of a reference whose cones hold a rate, at full thrust, and the price that this took."""

        def turning(reference: Iterate, price: float) -> Stage:
            note = name if price == 0.0 else f"{name}, at full thrust"
            within = replace(ready, turn=RateBound(rate, price))
            return self._stage(within, found, replace(reference, slack=()), note, firm=True, start=name)

        stage = turning(reference, price)
        while _loose(stage) and is_feasible(stage) and price < HIGHEST_PRICE:
            price = max(FIRST_PRICE, 4.0 * price)
            stage = turning(stage.outcome.iterate, price)
        return stage, price


def _aim(ready: MadeReady, iterate: Iterate) -> float:
    """What a finer grid makes smaller: the burn time, or the energy with its sign changed."""
    arc = iterate.trajectory
    if ready.scenario.problem == "min_time":
        return arc.duration
    return float(1.0 / np.linalg.norm(arc.end[:3]) - 0.5 * arc.end[3:] @ arc.end[3:])


def _loose(stage: Stage) -> bool:
    return float(np.linalg.norm(stage.outcome.iterate.trajectory.controls, axis=1).min()) < 1.0 - LOOSE


def is_feasible(stage: Stage) -> bool:
    """Whether a sequence ended near the target orbit."""
    near = (ExitReason.CONVERGED, ExitReason.MAX_ITERATIONS, ExitReason.INFEASIBLE)
    left = sum(abs(value) for _, value in stage.outcome.iterate.slack)
    return stage.outcome.reason in near and left <= SLACK_LEFT


def finished(
    ready: MadeReady, found: Found, stage: Stage, *, steps: int | None = None
) -> tuple[Stage, Verification | None]:
    """The stage as it is where its flight confirms it; else its directions on a grid that follows them, corrected in flight."""
    verification = judged(ready, stage.outcome.iterate)
    if ready.scenario.problem != "min_time" or (verification is not None and verification.verified):
        return stage, verification
    arc = stage.outcome.iterate.trajectory
    law = through(arc.grid, arc.controls, arc.duration)
    nodes = max(stage.nodes, nodes_that_follow(ready, law))
    unit = unit_on(ready.burn, ready.target, law, nodes, REACHED, steps=steps)
    if unit is None:
        return stage, verification
    message = f"{stage.outcome.message}; its directions were then corrected in flight"
    outcome = Outcome(ExitReason.CONVERGED, ready.by_interpolant(unit, nodes), (), message)
    moved = replace(stage, nodes=nodes, note=f"{stage.start}, corrected in flight", outcome=outcome)
    found.stages.append(moved)
    return moved, judged(ready, outcome.iterate)


def _conclude(ready: MadeReady, found: Found, free: Found) -> None:
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
    stage = replace(free.best, note=TOO_QUICK, outcome=Outcome(ExitReason.INFEASIBLE, iterate, (), message))
    found.stages.append(stage)
    found.best, found.verification = stage, None
