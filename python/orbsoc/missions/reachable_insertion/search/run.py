"""The search: strategies tried in their order; what they yield becomes the result."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace

from orbsoc.guidance.scp import ExitReason, Iteration, Outcome, Rules, Solve, sequential_convex
from orbsoc.orbit import PropagationError

from ..model.problems import Iterate
from ..model.proof import Proof
from ..starts.directions import Start
from ..verification import Verification
from .result import COLD, Attempt, Claim, SearchResult, Standing
from .setup import InsertionSetup

Findings = Iterator[Attempt | Proof]


@dataclass(frozen=True, slots=True)
class Strategy:
    """One way to a burn: when it applies, what it finds from what is known, and the claims that its findings may carry."""

    name: str
    applies: Callable[[SearchResult], bool]
    run: Callable[[Search, SearchResult], Findings]
    may_claim: frozenset[Claim]


@dataclass(frozen=True, slots=True)
class Search:
    """How burns are sought: the solver of the subproblems, the rules of the sequence, and what sees its iterations."""

    solve: Solve
    rules: Rules
    callback: Callable[[Iteration], None] | None = None

    def run(self, setup: InsertionSetup, strategies: Iterable[Strategy]) -> SearchResult:
        """Every strategy that applies, in order; Ctrl-C ends the search with what it has.

        Raises RuntimeError where a strategy finds what it may not claim.
        """
        result = SearchResult(setup)
        for strategy in strategies:
            if not result.interrupted and strategy.applies(result):
                result = self._tried(strategy, result)
        if not result.attempts and result.interrupted:
            outcome = Outcome(ExitReason.INTERRUPTED, setup.cold_start(), (), result.interrupted)
            result = result.plus(attempt_of(setup, "interrupted", outcome))
        return result

    def _tried(self, strategy: Strategy, result: SearchResult) -> SearchResult:
        try:
            for found in strategy.run(self, result):
                claim = Claim.INFEASIBLE if isinstance(found, Proof) else found.claim
                if claim not in strategy.may_claim:
                    raise RuntimeError(f"the strategy {strategy.name!r} may not claim {claim.name}")
                result = result.plus(found)
                if result.interrupted:
                    break
        except KeyboardInterrupt:
            return replace(result, interrupted=f"interrupted in the search by {strategy.name}")
        return result

    def sequence(
        self,
        setup: InsertionSetup,
        reference: Iterate,
        note: str,
        *,
        start: Start = COLD,
        soft: bool = False,
        firm: bool = False,
        claim: Claim = Claim.BEST_FOUND,
    ) -> Attempt:
        """The end of the sequence of convex problems from a reference; not flown."""
        outcome = sequential_convex(
            reference,
            setup.subproblem(soft=soft, firm=firm),
            solve=self.solve,
            rules=self.rules,
            callback=self.callback,
        )
        return attempt_of(setup, note, outcome, start, claim)


def attempt_of(
    setup: InsertionSetup,
    note: str,
    outcome: Outcome[Iterate],
    start: Start = COLD,
    claim: Claim = Claim.BEST_FOUND,
) -> Attempt:
    """An attempt that is not flown yet, by the rules of its setup."""
    standing = Standing.WITHOUT_BOUND if setup.is_unbounded else Standing.AS_ASKED
    if outcome.reason is ExitReason.INTERRUPTED:
        standing = Standing.ON_THE_WAY
    return Attempt(note, outcome, start, setup.ignition_s, claim, standing=standing)


def verified(setup: InsertionSetup, attempt: Attempt) -> Attempt:
    """The attempt with its flight, judged; as it is where its sequence did not converge."""
    if attempt.outcome.reason is not ExitReason.CONVERGED:
        return attempt
    return replace(attempt, verification=fly_and_verify(setup, attempt.iterate))


def fly_and_verify(setup: InsertionSetup, iterate: Iterate) -> Verification | None:
    """The flight of an iterate, judged; None where it cannot be flown."""
    try:
        return setup.verified(iterate)
    except (PropagationError, ValueError):  # it dives to the centre, or burns the vehicle up
        return None
