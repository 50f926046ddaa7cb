"""A plan as data, and what follows from it."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

from orbsoc.guidance.impulses import ImpulseProgramme
from orbsoc.guidance.mission import PlanStatus
from orbsoc.guidance.scenario_file import ScenarioError
from orbsoc.guidance.scp import ExitReason, Iteration, Solve
from orbsoc.orbit import PropagationError

from .dispersion.replanning import Surprised, surprise
from .model.approach import Approach, Roll, approach_between
from .model.uncertain import Meeting, meeting
from .scenario import Scenario
from .search.descent import Descended, descend, spread
from .search.first_guess import Phasing, plan_phasing, shoot
from .verification.finite import FiniteBurns, finite_burns
from .verification.flight import Flight


@dataclass(frozen=True, slots=True)
class FrontPoint:
    """What another number of revolutions costs: by the scheme of four burns in the true motion, and the least; None without."""

    revolutions: int
    duration_h: float | None
    scheme_m_s: float | None
    least_m_s: float | None


class Analysis:
    """What a report tells of a flight and the plan does not depend on, computed when it is first asked for, with
    `orbsoc.solve`, whatever solved the plan."""

    def __init__(self, approach: Approach, roll: Roll) -> None:
        self.approach, self.roll = approach, roll

    @cached_property
    def finite(self) -> FiniteBurns | None:
        """None without an engine, and where burns of this one are too long to stand for the impulses."""
        engine = self.approach.scenario.engine
        try:
            return None if engine is None else finite_burns(self.approach, self.roll, engine)
        except (PropagationError, ValueError):
            return None

    @cached_property
    def surprised(self) -> Surprised | None:
        return None if self.approach.scenario.surprise is None else surprise(self.approach, self.roll)

    @cached_property
    def meeting(self) -> Meeting | None:
        errors = self.approach.scenario.uncertainty
        return None if errors is None else meeting(self.approach, self.roll, errors)

    @cached_property
    def front(self) -> tuple[FrontPoint, ...]:
        from orbsoc.solving.solver import solve

        return tuple(
            _front_point(self.approach.scenario, n, solve) for n in self.approach.scenario.window.front
        )


@dataclass(frozen=True, slots=True, eq=False)
class PhasingPlan:
    """How planning ended; `scheme` is the flight of the paper's burns, `descended` what came of it; None where there is none."""

    scenario: Scenario
    status: PlanStatus
    exit_reason: ExitReason
    message: str
    phasing: Phasing | None = None
    scheme: Roll | None = None
    descended: Descended | None = None
    programme: ImpulseProgramme | None = None
    verification: Flight | None = None
    analysis: Analysis | None = field(default=None, repr=False)

    @property
    def subproblems(self) -> tuple[Iteration, ...]:
        return self.descended.outcome.iterations if self.descended else ()


def _front_point(scenario: Scenario, revolutions: int, solve: Solve) -> FrontPoint:
    """From the same first burn, to the meeting that this number of revolutions has."""
    window = {"end_s": None, "phasing_s": None, "revolutions": revolutions, "front": ()}
    other = scenario.with_changes(window=window, uncertainty=None)
    try:
        phasing = plan_phasing(other)
    except ScenarioError:
        return FrontPoint(revolutions, None, None, None)
    hours = (phasing.end_s - phasing.start_s) / 3600.0
    approach, scheme = shoot(other, phasing)
    if scheme is None:
        return FrontPoint(revolutions, hours, None, None)
    fine = approach_between(other, phasing.start_s, phasing.end_s, approach.times_s)
    start = spread(fine, scheme, approach.times_s)
    found = None if start is None else descend(fine, start, solve=solve)
    good = found is not None and found.outcome.reason is ExitReason.CONVERGED
    return FrontPoint(revolutions, hours, scheme.cost_m_s, found.roll.cost_m_s if found and good else None)
