"""What was planned, as data: the stages of the sequence, the last iterate, and what the propagation says of it."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import chain

from orbsoc.guidance.mission import PlanStatus
from orbsoc.guidance.powered_flight import Trajectory
from orbsoc.guidance.scp import ExitReason, Iteration, Outcome
from orbsoc.orbit import EARTH, CanonicalUnits, Elements

from ..model.problems import Iterate
from ..model.proof import Proof
from ..scenario import Scenario
from ..targets.any_target import AnyTarget
from ..verification import Verification
from .claims import Claim

COLD = "thrust along the velocity"


@dataclass(frozen=True, slots=True, eq=False)
class Stage:
    """One run of the sequence on one grid; `note` says why it was run, `start` from where it set out."""

    nodes: int
    note: str
    outcome: Outcome[Iterate]
    start: str = COLD
    ignition_s: float = 0.0
    claim: Claim = Claim.BEST_FOUND


@dataclass(frozen=True, slots=True, eq=False)
class BurnPlan:
    """What was planned, how, and what the propagation says of it.

    `iterate` is the last one reached; it is a plan to fly only when `status` is VERIFIED. `verification` is None
    when the sequence did not converge to a feasible point.
    """

    scenario: Scenario
    target: AnyTarget
    status: PlanStatus
    exit_reason: ExitReason
    message: str
    stages: tuple[Stage, ...]
    iterate: Iterate
    verification: Verification | None
    proof: Proof | None = None
    """Why no burn reaches the target, of an INFEASIBLE plan."""
    ignition_s: float = 0.0
    """Coast on the first orbit before the burn."""

    @property
    def subproblems(self) -> tuple[Iteration, ...]:
        """Every subproblem solved, over all stages."""
        return tuple(chain.from_iterable(stage.outcome.iterations for stage in self.stages))

    @property
    def claim(self) -> Claim:
        """The claim on the attempt that the plan is."""
        if self.stages:
            return self.stages[-1].claim
        return Claim.NOTHING_TO_BURN if self.time_of_flight_s == 0.0 else Claim.BEST_FOUND

    @property
    def trajectory(self) -> Trajectory:
        return self.iterate.trajectory

    @property
    def time_of_flight_s(self) -> float:
        return self.trajectory.duration * CanonicalUnits.of(EARTH).time_s

    @property
    def propellant_kg(self) -> float:
        return self.scenario.vehicle.mass_flow_kg_s * self.time_of_flight_s

    @property
    def orbit(self) -> Elements | None:
        """The planned orbit, ECI; None when the sequence did not converge to a feasible point."""
        return None if self.verification is None else self.verification.planned_orbit
