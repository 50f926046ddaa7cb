"""Fly-around of a target on an ellipse of any attitude, within a tolerance, with the fewest pulses and the proof of it.

>>> scenario = load_scenario("scenarios/paper001_fewest.toml")  # doctest: +SKIP
>>> plan(scenario).search.pulses  # doctest: +SKIP
13
"""

from orbsoc.guidance.mission import PlanStatus
from orbsoc.guidance.scenario_file import ScenarioError

from .dispersion import DISPERSION, disperse
from .flight import FlyAroundLoop
from .paper import reproduce, samples
from .plan import Plan, audit, plan
from .planner import COLUMNS
from .scenario import Scenario, load_scenario

PAPER = "001"
closed_loop = FlyAroundLoop.of

__all__ = [
    "COLUMNS",
    "DISPERSION",
    "PAPER",
    "Plan",
    "PlanStatus",
    "Scenario",
    "ScenarioError",
    "audit",
    "closed_loop",
    "disperse",
    "load_scenario",
    "plan",
    "reproduce",
    "samples",
]


def __dir__() -> list[str]:
    return sorted(__all__)
