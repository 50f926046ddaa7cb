"""The reachable domain: every orbit that a vehicle can still reach (Li et al. 2025, problem C).

`orbsoc reach` solves it and `orbsoc.reach` reads it; `plan` plans one point of it.
"""

from orbsoc.guidance.scenario_file import ScenarioError

from .paper import reproduce
from .plan import Plan, plan
from .planner import COLUMNS
from .scenario import Scenario, load_scenario

PAPER = "004"

__all__ = ["COLUMNS", "PAPER", "Plan", "Scenario", "ScenarioError", "load_scenario", "plan", "reproduce"]


def __dir__() -> list[str]:
    return sorted(__all__)
