"""Approach by impulses that stays clear of the target if the engine fails (Xu & Meng, paper 000), and how clear.

>>> scenario = load_scenario("scenarios/paper000_1.toml")  # doctest: +SKIP
>>> plan(scenario).cost  # doctest: +SKIP
0.546833
"""

from orbsoc.guidance.mission import PlanStatus
from orbsoc.guidance.scenario_file import ScenarioError

from .dispersion import DISPERSION, disperse
from .flight import ApproachLoop
from .paper import reproduce, samples
from .plan import Plan, audit, plan
from .planner import COLUMNS
from .scenario import Scenario, load_scenario

PAPER = "000"
closed_loop = ApproachLoop.of

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
