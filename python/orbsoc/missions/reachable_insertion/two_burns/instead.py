"""Two burns onto a target that one burn was not found to reach: flown, not estimated, and not yet shortened."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

from orbsoc.guidance.mission import PlanStatus

from ..search.run import SearchResult
from ..search.setup import InsertionSetup
from .search import FLOWN, flown_starts, fly_and_verify, limits_of, proof_for_two_burns


@dataclass(frozen=True, slots=True)
class TwoBurns:
    """Burns and the coasts before them, in their order."""

    ignition_s: float
    first_s: float
    coast_s: float
    second_s: float


@lru_cache(maxsize=8)
def two_burns_instead(plan: SearchResult) -> TwoBurns | None:
    """The first two burns found that the independent integrator confirms; None for a plan that needs none, and where none are."""
    scenario = plan.scenario
    if scenario.problem != "min_time" or plan.status in (PlanStatus.VERIFIED, PlanStatus.INTERRUPTED):
        return None
    ready = InsertionSetup.of(scenario)
    if proof_for_two_burns(ready):
        return None
    for start in flown_starts(ready, limits_of(ready), FLOWN):
        if not start.flown.reaches:
            continue
        verification = fly_and_verify(ready, start.flown.transfer)
        if verification is not None and verification.verified:
            transfer = start.flown.transfer
            coasts, burns = transfer.coasts * ready.units.time_s, transfer.durations * ready.units.time_s
            return TwoBurns(float(coasts[0]), float(burns[0]), float(coasts[1]), float(burns[1]))
    return None
