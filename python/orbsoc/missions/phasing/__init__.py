"""A long approach by plane change, phasing and rendezvous (Zheng et al. 2018, paper 003), about an oblate Earth with air.

>>> scenario = load_scenario("scenarios/paper003_socp.toml")  # doctest: +SKIP
>>> plan(scenario).programme.total_m_s  # doctest: +SKIP
385.3422782
"""

from orbsoc.guidance.mission import PlanStatus
from orbsoc.guidance.scenario_file import ScenarioError

from .dispersion.cases import DISPERSION, disperse
from .flight import PhasingLoop
from .paper.reproduction import reproduce, samples
from .plan import Plan, audit, plan
from .planner import COLUMNS
from .scenario import Scenario, load_scenario

PAPER = "003"
closed_loop = PhasingLoop.of

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
