"""What a report tells of a plan and the plan does not depend on, computed when it is first asked for."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property

from orbsoc.guidance.impulses import ImpulseProgramme

from .dispersion import MonteCarlo, fly_many
from .model.approach import Approach
from .search.front import FrontPoint, interruption_front


class Analysis:
    """Of a programme; solved with `orbsoc.solve`, whatever solved the plan. KeyboardInterrupt goes to the caller."""

    def __init__(self, approach: Approach, programme: ImpulseProgramme) -> None:
        self.approach, self.programme = approach, programme

    @cached_property
    def flights(self) -> Mapping[str, MonteCarlo]:
        """With the errors of the scenario: "as_planned", without re-planning, and "re_planned" before every burn."""
        from orbsoc.solving.solver import solve

        errors = self.approach.scenario.uncertainty
        if errors is None or not errors.runs:
            return {}
        return {
            "as_planned": fly_many(self.approach, self.programme, solve, replan=False),
            "re_planned": fly_many(self.approach, self.programme, solve),
        }

    @cached_property
    def front(self) -> tuple[FrontPoint, ...]:
        """With `interruption_orbits`: what other durations cost, by the orbits that an interrupted burn stays safe."""
        from orbsoc.solving.solver import solve

        return interruption_front(self.approach, solve) if self.approach.scenario.interruption_orbits else ()
