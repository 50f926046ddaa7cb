"""The search: strategies tried in their order, the attempts that they make, and the rule by which one of these counts."""

from __future__ import annotations

import enum
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from itertools import chain

from orbsoc.guidance.mission import PlanStatus
from orbsoc.guidance.powered_flight import Trajectory
from orbsoc.guidance.scp import ExitReason, Iteration, Outcome, Rules, Solve, sequential_convex
from orbsoc.orbit import Elements, PropagationError

from .. import tuning
from ..model.problems import Iterate
from ..model.proof import Proof
from ..scenario import Scenario
from ..starts.directions import Start
from ..starts.steering_law import Law, through
from ..targets.target import Target
from ..verification import Verification
from .setup import InsertionSetup


class Claim(enum.Enum):
    """What may be said of a finding. Only a proof says that nothing is better."""

    BEST_FOUND = "the end of a sequence of convex problems: a local optimum of its start"
    NOTHING_TO_BURN = "the vehicle is on its target orbit: no burn is shorter than 0 s"
    SMOOTH_TURN = "a law that turns smoothly, shortened as long as the grid follows it"
    FAST_TURN = "about as fast a turn as the finest grid follows"
    INFEASIBLE = "proved: no burn, however steered, reaches the target"


class Standing(enum.IntEnum):
    """How an attempt was judged; the lower one counts, whatever else is found."""

    AS_ASKED = 0
    WITHOUT_BOUND = 1
    """Without the bound on the attitude rate that the scenario has."""
    ON_THE_WAY = 2
    """Not at all: another attempt goes on from it."""


COLD = Start("thrust along the velocity")
"""The start that knows nothing of the target."""


@dataclass(frozen=True, slots=True, eq=False)
class Attempt:
    """One burn that was made, by a sequence on one grid or by a law alone: why, from where it set out, and what its flight says.

    `verification` is None where there was nothing to fly, or nothing that could be flown.
    """

    note: str
    outcome: Outcome[Iterate]
    start: Start = COLD
    ignition_s: float = 0.0
    claim: Claim = Claim.BEST_FOUND
    verification: Verification | None = None
    standing: Standing = Standing.AS_ASKED

    @property
    def iterate(self) -> Iterate:
        return self.outcome.iterate

    @property
    def trajectory(self) -> Trajectory:
        return self.outcome.iterate.trajectory

    @property
    def law(self) -> Law:
        """The interpolant of its thrust."""
        arc = self.trajectory
        return through(arc.grid, arc.controls, arc.duration)

    @property
    def nodes(self) -> int:
        return self.trajectory.grid.size

    @property
    def verified(self) -> bool:
        return self.verification is not None and self.verification.verified

    @property
    def violation(self) -> float:
        """Slack of all terminal rows."""
        return sum(abs(value) for _, value in self.iterate.slack)

    @property
    def is_near(self) -> bool:
        """Whether its sequence ended near the target orbit."""
        near = (ExitReason.CONVERGED, ExitReason.MAX_ITERATIONS, ExitReason.INFEASIBLE)
        return self.outcome.reason in near and self.violation <= tuning.SLACK_LEFT

    @property
    def on_the_way(self) -> Attempt:
        """The same, where another goes on from it."""
        return replace(self, standing=Standing.ON_THE_WAY)


@dataclass(frozen=True, slots=True, eq=False)
class SearchResult:
    """Attempts in the order in which they were made; `best` is the one that counts.

    It is a burn to fly only when `status` is VERIFIED. `proof` says why no burn reaches the target.
    """

    setup: InsertionSetup
    attempts: tuple[Attempt, ...] = ()
    proof: Proof | None = None
    interrupted: str = ""

    def plus(self, found: Attempt | Proof) -> SearchResult:
        """With one finding more. A burn that is verified ends a proof, which is of one ignition."""
        if isinstance(found, Proof):
            return replace(self, proof=found)
        stopped = found.outcome.reason is ExitReason.INTERRUPTED
        return replace(
            self,
            attempts=(*self.attempts, found),
            proof=None if found.verified else self.proof,
            interrupted=found.outcome.message if stopped else self.interrupted,
        )

    def rank(self, attempt: Attempt) -> tuple[float, ...]:
        """The lower, the better: judged as asked; verified before flown before neither. Of verified ones the shorter burn or the
        larger orbit, of flown ones the fewer objections, of the others the smaller violation."""
        found = attempt.verification
        if found is None:
            led_anywhere = attempt.outcome.reason is ExitReason.INFEASIBLE
            violation = float(f"{attempt.violation:.4g}")  # the first of equals
            return (attempt.standing, 2.0, 0.0 if led_anywhere else 1.0, violation)
        if not found.verified:
            return (attempt.standing, 1.0, float(len(found.failures)), found.angular_momentum_rel)
        largest = self.scenario.problem == "max_energy"
        return (attempt.standing, 0.0, -found.planned_orbit.sma_m if largest else attempt.trajectory.duration)

    @property
    def best(self) -> Attempt:
        """The attempt of the lowest rank, the first of equals. Raises ValueError where there is none yet."""
        return min(self.attempts, key=self.rank)

    @property
    def verified(self) -> bool:
        return bool(self.attempts) and self.best.verified

    @property
    def status(self) -> PlanStatus:
        if self.interrupted:
            return PlanStatus.INTERRUPTED
        found = self.verification
        if found is not None and not found.below_ground:
            return PlanStatus.VERIFIED if found.verified else PlanStatus.NOT_VERIFIED
        if self.proof is not None:
            return PlanStatus.INFEASIBLE
        led_somewhere = found is not None or self.exit_reason is ExitReason.INFEASIBLE
        return PlanStatus.NOT_FOUND if led_somewhere else PlanStatus.FAILED

    @property
    def exit_reason(self) -> ExitReason:
        return ExitReason.INTERRUPTED if self.interrupted else self.best.outcome.reason

    @property
    def message(self) -> str:
        return self.interrupted or self.best.outcome.message

    @property
    def scenario(self) -> Scenario:
        return self.setup.scenario

    @property
    def target(self) -> Target:
        return self.setup.target

    @property
    def subproblems(self) -> tuple[Iteration, ...]:
        """Every subproblem solved, over all attempts."""
        return tuple(chain.from_iterable(each.outcome.iterations for each in self.attempts))

    @property
    def claim(self) -> Claim:
        return self.best.claim

    @property
    def iterate(self) -> Iterate:
        return self.best.iterate

    @property
    def trajectory(self) -> Trajectory:
        return self.best.trajectory

    @property
    def verification(self) -> Verification | None:
        return self.best.verification

    @property
    def ignition_s(self) -> float:
        """Coast on the first orbit before the burn."""
        return self.best.ignition_s

    @property
    def time_of_flight_s(self) -> float:
        return self.trajectory.duration * self.setup.units.time_s

    @property
    def propellant_kg(self) -> float:
        return self.scenario.vehicle.mass_flow_kg_s * self.time_of_flight_s

    @property
    def orbit(self) -> Elements | None:
        """The planned orbit, ECI; None when nothing was flown."""
        return None if self.verification is None else self.verification.planned_orbit


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
