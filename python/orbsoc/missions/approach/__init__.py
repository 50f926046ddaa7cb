"""An approach like a station's: keep-out sphere, approach cone, hold points, safe drifts, abort impulses.

>>> scenario = load_scenario("scenarios/station_vbar.toml")  # doctest: +SKIP
>>> plan(scenario).verification.least_m >= 200.0  # doctest: +SKIP
True
"""

from orbsoc.guidance.mission import PlanStatus
from orbsoc.guidance.scenario_file import ScenarioError

from .dispersion import DISPERSION, disperse
from .flight import ApproachLoop
from .plan import Plan, audit, plan, reproduce
from .planner import COLUMNS
from .scenario import Scenario, load_scenario

PAPER = ""
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
]


def __dir__() -> list[str]:
    return sorted(__all__)
