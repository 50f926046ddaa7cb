"""A sequence whose cones hold a rate of the attitude, at full thrust, and its result on a grid that follows it.

Relaxed to |u| ≤ 1, a turn that the cones slow down takes the short way through the inside of the ball, at part of the thrust.
Where that happens, thrust that is missing gets a price above its worth, linearised about the last iterate (the convex–concave
procedure, Yuille & Rangarajan 2003), and the sequence ends on the sphere again.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from orbsoc.guidance.scp import ExitReason, Outcome

from ..model.attitude_rate import RateBound
from ..model.problems import Iterate
from ..plan.burn_plan import Stage
from ..plan.claims import Claim
from ..starts.directions import REACHED
from ..starts.steering_law import through, unit_on
from ..verification import Verification
from .found import Found
from .setup import InsertionSetup
from .start_search import SLACK_LEFT, Search, fly_and_verify, nodes_that_follow

TURNING = "turning within the bound"
FIRST_PRICE, HIGHEST_PRICE = 2.0, 32.0
LOOSE = 1e-4
"""1 − |u| at a node, from which on the relaxation is not tight."""


@dataclass(frozen=True, slots=True)
class TurningSearch(Search):
    """A search that can hold the rate of the thrust."""

    def at_rate(
        self,
        ready: InsertionSetup,
        found: Found,
        reference: Iterate,
        rate: float,
        price: float = 0.0,
        *,
        name: str = TURNING,
        claim: Claim = Claim.BEST_FOUND,
    ) -> tuple[Stage, float]:
        """The burn on the grid of a reference whose cones hold a rate, at full thrust, and the price that this took."""

        def turning(reference: Iterate, price: float) -> Stage:
            note = name if price == 0.0 else f"{name}, at full thrust"
            within = replace(ready, turn=RateBound(rate, price))
            return self._stage(
                within, found, replace(reference, slack=()), note, firm=True, start=name, claim=claim
            )

        stage = turning(reference, price)
        while _loose(stage) and is_feasible(stage) and price < HIGHEST_PRICE:
            price = max(FIRST_PRICE, 4.0 * price)
            stage = turning(stage.outcome.iterate, price)
        return stage, price


def _loose(stage: Stage) -> bool:
    return float(np.linalg.norm(stage.outcome.iterate.trajectory.controls, axis=1).min()) < 1.0 - LOOSE


def is_feasible(stage: Stage) -> bool:
    """Whether a sequence ended near the target orbit."""
    near = (ExitReason.CONVERGED, ExitReason.MAX_ITERATIONS, ExitReason.INFEASIBLE)
    left = sum(abs(value) for _, value in stage.outcome.iterate.slack)
    return stage.outcome.reason in near and left <= SLACK_LEFT


def finished(
    ready: InsertionSetup, found: Found, stage: Stage, *, steps: int | None = None
) -> tuple[Stage, Verification | None]:
    """The stage as it is where its flight confirms it; else its directions on a grid that follows them, corrected in flight."""
    verification = fly_and_verify(ready, stage.outcome.iterate)
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
    return moved, fly_and_verify(ready, outcome.iterate)
