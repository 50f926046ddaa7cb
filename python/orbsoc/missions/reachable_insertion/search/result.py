"""What a search comes to: attempts in their order, what each may be said to be, and the rule by which one of them counts."""

from __future__ import annotations

import enum
from dataclasses import dataclass, replace
from itertools import chain

from orbsoc.guidance.mission import PlanStatus
from orbsoc.guidance.powered_flight import Trajectory
from orbsoc.guidance.scp import ExitReason, Iteration, Outcome
from orbsoc.orbit import Elements

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
    SMOOTH_TURN = "a law that turns smoothly, shortened: the shortest burn turns faster than the grid follows"
    FAST_TURN = "about as fast a turn as the finest grid follows: the shortest burn turns faster"
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
        return (
            attempt.standing,
            0.0,
            -found.planned_orbit.sma_m if largest else attempt.trajectory.duration,
        )

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
