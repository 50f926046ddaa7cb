"""The reachable domain: every orbit that a vehicle can still reach (Li et al. 2025, problem C)."""

from orbsoc.guidance.scenario_file import ScenarioError

from .scenario import Scenario, load_scenario

__all__ = ["Scenario", "ScenarioError", "load_scenario"]
