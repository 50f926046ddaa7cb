"""What the search came to, and the rule by which one attempt is better than another."""

from __future__ import annotations

from dataclasses import dataclass, field

from orbsoc.guidance.mission import PlanStatus
from orbsoc.guidance.scp import ExitReason

from ..model.problems import Iterate
from ..model.proof import Proof
from ..plan.burn_plan import Stage
from ..verification import Verification
from .setup import InsertionSetup


@dataclass(slots=True)
class Found:
    """What the search came to: every stage, the one that counts, and its verification."""

    ready: InsertionSetup
    stages: list[Stage] = field(default_factory=list)
    best: Stage | None = None
    verification: Verification | None = None
    proof: Proof | None = None
    interrupted: str = ""

    @property
    def verified(self) -> bool:
        return self.verification is not None and self.verification.verified

    def consider(self, stage: Stage, verification: Verification | None) -> None:
        """Keep the better of this and what was found before: verified before flown before closest."""
        if self.best is None or self._rank(stage, verification) < self._rank(self.best, self.verification):
            self.best, self.verification = stage, verification

    def _rank(self, stage: Stage, verification: Verification | None) -> tuple[float, ...]:
        iterate = stage.outcome.iterate
        if verification is None:
            violation = sum(abs(value) for _, value in iterate.slack)
            led_anywhere = stage.outcome.reason is ExitReason.INFEASIBLE
            return (2.0, 0.0 if led_anywhere else 1.0, float(f"{violation:.4g}"))  # the first of equals
        aim = iterate.trajectory.duration
        if self.ready.scenario.problem == "max_energy":
            aim = -verification.planned_orbit.sma_m
        if verification.verified:
            return (0.0, aim)
        return (1.0, float(len(verification.failures)), verification.angular_momentum_rel)

    @property
    def iterate(self) -> Iterate:
        assert self.best is not None
        return self.best.outcome.iterate

    @property
    def reason(self) -> ExitReason:
        if self.interrupted:
            return ExitReason.INTERRUPTED
        assert self.best is not None
        return self.best.outcome.reason

    @property
    def message(self) -> str:
        if self.interrupted:
            return self.interrupted
        assert self.best is not None
        return self.best.outcome.message

    @property
    def status(self) -> PlanStatus:
        if self.interrupted:
            return PlanStatus.INTERRUPTED
        if self.verification is not None and not self.verification.below_ground:
            return PlanStatus.VERIFIED if self.verification.verified else PlanStatus.NOT_VERIFIED
        if self.proof is not None:
            return PlanStatus.INFEASIBLE
        led_somewhere = self.verification is not None or self.reason is ExitReason.INFEASIBLE
        return PlanStatus.NOT_FOUND if led_somewhere else PlanStatus.FAILED
