"""A platform launches one of its servers towards a target: the launch of two bodies, and the rendezvous that costs least.

>>> scenario = load_scenario("scenarios/paper002.toml")  # doctest: +SKIP
>>> round(plan(scenario).meeting.time_s, 2)  # doctest: +SKIP
920.95
"""

from orbsoc.guidance.mission import PlanStatus
from orbsoc.guidance.scenario_file import ScenarioError

from .dispersion import DISPERSION, disperse
from .flight import LaunchLoop
from .paper import reproduce, samples
from .plan import Plan, plan
from .planner import COLUMNS
from .scenario import Scenario, load_scenario

PAPER = "002"
closed_loop = LaunchLoop.of

__all__ = [
    "COLUMNS",
    "DISPERSION",
    "PAPER",
    "Plan",
    "PlanStatus",
    "Scenario",
    "ScenarioError",
    "closed_loop",
    "disperse",
    "load_scenario",
    "plan",
    "reproduce",
    "samples",
]


def __dir__() -> list[str]:
    return sorted(__all__)
