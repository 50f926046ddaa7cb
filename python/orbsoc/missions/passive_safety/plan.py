"""A plan of an approach as data."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from orbsoc.guidance.impulses import ImpulseProgramme
from orbsoc.guidance.mission import PlanStatus
from orbsoc.guidance.scp import ExitReason, Iteration

from .analysis import Analysis
from .dispersion import MonteCarlo
from .model.approach import Approach
from .scenario import Scenario
from .search.front import FrontPoint
from .search.timing import Timed
from .verification import LIMIT_M, Verification


@dataclass(frozen=True, slots=True, eq=False)
class ApproachPlan:
    """How planning ended, the programme, what was solved for it, and what its flights found; None where there is none."""

    scenario: Scenario
    approach: Approach
    status: PlanStatus
    exit_reason: ExitReason
    message: str
    programme: ImpulseProgramme | None = None
    timed: Timed | None = None
    verification: Verification | None = None
    analysis: Analysis | None = None

    @property
    def flights(self) -> Mapping[str, MonteCarlo]:
        """`Analysis.flights`; empty without a programme that was flown."""
        return self.analysis.flights if self.analysis else {}

    @property
    def front(self) -> tuple[FrontPoint, ...]:
        """`Analysis.front`; empty without a programme that was flown."""
        return self.analysis.front if self.analysis else ()

    @property
    def subproblems(self) -> tuple[Iteration, ...]:
        return self.timed.subproblems if self.timed else ()

    @property
    def cost(self) -> float:
        """As the scenario asks for it, m/s; NaN without a programme."""
        if self.programme is None:
            return float("nan")
        norms = self.scenario.cost == "norms"
        return self.programme.total_m_s if norms else self.programme.total_absolutes_m_s

    @property
    def nearest_m(self) -> float:
        """How near to the target the drift after any completed impulse comes, over all later time; infinite without."""
        cuts = self.verification.cuts if self.verification else ()
        return min((cut.completed_m for cut in cuts), default=float("inf"))

    @property
    def safe(self) -> bool:
        """For all time after every completed impulse."""
        return self.nearest_m >= self.scenario.keep_out_m - LIMIT_M

    @property
    def safe_when_cut(self) -> bool:
        """For all time after every impulse, wherever in it the engine stops."""
        cuts = self.verification.cuts if self.verification else ()
        return all(cut.distance_m >= self.scenario.keep_out_m - LIMIT_M for cut in cuts)
