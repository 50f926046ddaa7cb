"""Insertion into a target orbit, and the largest orbit within reach (Li et al. 2025, problems A and B).

>>> scenario = load_scenario("scenarios/rec1.toml")  # doctest: +SKIP
>>> plan(scenario).time_of_flight_s  # doctest: +SKIP
56.570006
"""

from orbsoc.guidance.scenario_file import ScenarioError

from .dispersion import Dispersion, dispersed
from .planner import Plan, PlanStatus, Stage, plan
from .scenario import Scenario, load_scenario

__all__ = [
    "Dispersion",
    "Plan",
    "PlanStatus",
    "Scenario",
    "ScenarioError",
    "Stage",
    "dispersed",
    "load_scenario",
    "plan",
]
