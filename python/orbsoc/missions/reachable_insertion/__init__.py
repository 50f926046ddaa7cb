"""Insertion into a target orbit, and the largest orbit within reach (Li et al. 2025, problems A and B).

>>> scenario = load_scenario("scenarios/rec1.toml")  # doctest: +SKIP
>>> plan(scenario).time_of_flight_s  # doctest: +SKIP
56.570006
"""

from orbsoc.guidance.mission import PlanStatus
from orbsoc.guidance.scenario_file import ScenarioError

from .dispersion import DISPERSION, disperse
from .flight.loop import InsertionLoop
from .on_board import on_board
from .outer_loop import outer_loop
from .plan import Plan, plan, reproduce
from .planner import COLUMNS
from .scenario import Scenario, load_scenario
from .search.run import Attempt
from .two_burns.planner import TwoBurnPlan

PAPER = "004"
closed_loop = InsertionLoop.of

__all__ = [
    "COLUMNS",
    "DISPERSION",
    "PAPER",
    "Attempt",
    "Plan",
    "PlanStatus",
    "Scenario",
    "ScenarioError",
    "TwoBurnPlan",
    "closed_loop",
    "disperse",
    "load_scenario",
    "on_board",
    "outer_loop",
    "plan",
    "reproduce",
]


def __dir__() -> list[str]:
    return sorted(__all__)
