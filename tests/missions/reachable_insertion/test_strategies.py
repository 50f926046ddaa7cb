"""The search as values: a strategy finds nothing that it may not claim, and one rule says which attempt counts."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import FrozenInstanceError, replace
from pathlib import Path

import numpy as np
import pytest

from orbsoc.guidance.scp import ExitReason, Outcome, Rules
from orbsoc.missions.reachable_insertion import Attempt, load_scenario
from orbsoc.missions.reachable_insertion.model.proof import Proof
from orbsoc.missions.reachable_insertion.search.run import (
    Claim,
    Search,
    SearchResult,
    Standing,
    Strategy,
    verified,
)
from orbsoc.missions.reachable_insertion.search.setup import InsertionSetup
from orbsoc.missions.reachable_insertion.search.strategies import STRATEGIES
from orbsoc.missions.reachable_insertion.targets.rows import Row
from orbsoc.solving.solver import solve

SCENARIO = Path(__file__).resolve().parents[3] / "scenarios" / "rec1.toml"
SETUP = InsertionSetup.of(load_scenario(SCENARIO))
SEARCH = Search(solve, Rules())


def made(claim: Claim = Claim.BEST_FOUND, slack: float = 0.0) -> Attempt:
    iterate = replace(SETUP.cold_start(), slack=((Row.MOMENTUM, slack),))
    return Attempt("made up", Outcome(ExitReason.INFEASIBLE, iterate, (), "made up"), claim=claim)


def strategy(*found: Attempt | Proof, may: frozenset[Claim]) -> Strategy:
    return Strategy("made up", lambda _: True, lambda *_: iter(found), may)


def test_a_strategy_finds_nothing_that_it_may_not_claim() -> None:
    smooth, proof = made(Claim.SMOOTH_TURN), Proof("made up", 2.0, 1.0)
    may = frozenset({Claim.BEST_FOUND})
    with pytest.raises(RuntimeError, match="'made up' may not claim SMOOTH_TURN"):
        SEARCH.run(SETUP, [strategy(made(), smooth, may=may)])
    with pytest.raises(RuntimeError, match="may not claim INFEASIBLE"):
        SEARCH.run(SETUP, [strategy(proof, may=may)])
    kept = SEARCH.run(SETUP, [strategy(smooth, proof, may=frozenset({Claim.SMOOTH_TURN, Claim.INFEASIBLE}))])
    assert kept.attempts == (smooth,)
    assert kept.proof is proof


def test_every_strategy_of_the_search_says_what_it_may_claim() -> None:
    assert all(each.may_claim for each in STRATEGIES)
    assert {claim for each in STRATEGIES for claim in each.may_claim} == set(Claim)


def test_the_best_attempt_is_the_first_of_the_lowest_rank_whatever_the_order() -> None:
    close, far = made(slack=1e-3), made(slack=1e-2)
    flown = verified(SETUP, SEARCH.sequence(SETUP, SETUP.cold_start(), "cold start"))
    assert flown.verified
    on_the_way, without_bound = flown.on_the_way, replace(flown, standing=Standing.WITHOUT_BOUND)
    result = SearchResult(SETUP, (far, close, on_the_way, without_bound))
    assert result.best is close
    assert SearchResult(SETUP, (on_the_way, without_bound)).best is without_bound
    better = result.plus(flown).plus(replace(flown))
    assert better.best is flown
    assert result.best is close  # a value: what was known then does not change
    with pytest.raises(FrozenInstanceError):
        result.attempts = ()  # type: ignore[misc]


def test_a_verified_burn_ends_a_proof_of_another_ignition_and_an_interruption_the_search() -> None:
    proof = Proof("made up", 2.0, 1.0)
    flown = verified(SETUP, SEARCH.sequence(SETUP, SETUP.cold_start(), "cold start"))
    assert SearchResult(SETUP).plus(proof).plus(made()).proof is proof
    assert SearchResult(SETUP).plus(proof).plus(flown).proof is None

    def interrupted(_search: Search, _result: SearchResult) -> Iterator[Attempt]:
        yield made()
        raise KeyboardInterrupt

    may = frozenset({Claim.BEST_FOUND})
    stopped = Strategy("the first", lambda _: True, interrupted, may)
    result = SEARCH.run(SETUP, [stopped, strategy(flown, may=may)])
    assert result.interrupted == "interrupted in the search by the first"
    assert len(result.attempts) == 1
    nothing = SEARCH.run(SETUP, [Strategy("the first", lambda _: True, _at_once, may)])
    assert [each.note for each in nothing.attempts] == ["interrupted"]
    assert np.isfinite(nothing.time_of_flight_s)


def _at_once(_search: Search, _result: SearchResult) -> Iterator[Attempt]:
    raise KeyboardInterrupt
    yield made()
