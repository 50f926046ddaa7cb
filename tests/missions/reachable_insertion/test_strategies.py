"""The list of strategies: an attempt carries no claim that its strategy may not make."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from orbsoc.guidance.scp import ExitReason, Outcome, Rules
from orbsoc.missions.reachable_insertion import load_scenario
from orbsoc.missions.reachable_insertion.plan.burn_plan import Stage
from orbsoc.missions.reachable_insertion.plan.claims import Claim
from orbsoc.missions.reachable_insertion.search.found import Found
from orbsoc.missions.reachable_insertion.search.setup import InsertionSetup
from orbsoc.missions.reachable_insertion.search.start_search import Search, Strategy
from orbsoc.solving.solver import solve

Run = Callable[[Search, InsertionSetup, Found], None]
SCENARIO = Path(__file__).resolve().parents[3] / "scenarios" / "rec1.toml"


def _smooth(_search: Search, ready: InsertionSetup, found: Found) -> None:
    outcome = Outcome(ExitReason.INFEASIBLE, ready.cold_start(), (), "made up")
    found.stages.append(Stage(ready.scenario.method.nodes, "made up", outcome, claim=Claim.SMOOTH_TURN))


def _smooth_as_best(search: Search, ready: InsertionSetup, found: Found) -> None:
    _smooth(search, ready, found)
    found.consider(found.stages.pop(), None)


@pytest.mark.parametrize("run", [_smooth, _smooth_as_best])
def test_a_strategy_refuses_an_attempt_with_a_claim_that_it_may_not_make(run: Run) -> None:
    ready, search = InsertionSetup.of(load_scenario(SCENARIO)), Search(solve, Rules())
    strategy = Strategy("made up", lambda *_: True, run, frozenset({Claim.BEST_FOUND}))
    with pytest.raises(RuntimeError, match="may not claim SMOOTH_TURN"):
        strategy.attempt(search, ready, Found(ready))


def test_a_strategy_keeps_an_attempt_with_a_claim_that_it_may_make() -> None:
    ready, search = InsertionSetup.of(load_scenario(SCENARIO)), Search(solve, Rules())
    found = Found(ready)
    Strategy("made up", lambda *_: True, _smooth, frozenset({Claim.SMOOTH_TURN})).attempt(
        search, ready, found
    )
    assert [stage.claim for stage in found.stages] == [Claim.SMOOTH_TURN]
