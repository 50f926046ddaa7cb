"""Every mission by name: the one place outside a mission's folder that knows it. A mission is one line here.

>>> mission, scenario = load_scenario("scenarios/rec1.toml")  # doctest: +SKIP
>>> mission.plan(scenario).status  # doctest: +SKIP
<PlanStatus.VERIFIED: 'verified'>
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from importlib import import_module
from os import PathLike
from typing import TYPE_CHECKING, Any, cast

from orbsoc.files.extras import told_what_to_install
from orbsoc.files.nearest import did_you_mean

if TYPE_CHECKING:
    from orbsoc.guidance.mission import Auditable, Dispersible, Flyable, Mission
    from orbsoc.guidance.scenario_file import BaseScenario

MODULES = {
    "reachable_domain": "orbsoc.missions.reachable_domain",
    "reachable_insertion": "orbsoc.missions.reachable_insertion",
    "passive_safety": "orbsoc.missions.passive_safety",
    "fly_around": "orbsoc.missions.fly_around",
    "phasing": "orbsoc.missions.phasing",
    "platform_launch": "orbsoc.missions.platform_launch",
    "approach": "orbsoc.missions.approach",
}

EXAMPLES = {
    "reachable_domain": "kick_stage_reach",
    "reachable_insertion": "orekit_apogee",
    "passive_safety": "paper000_free",
    "fly_around": "paper001_fewest",
    "phasing": "phasing_two_tles",
    "platform_launch": "paper002_norms",
    "approach": "station_vbar",
}
"""The shipped scenario that `orbsoc new` takes its values from."""

SCHEMAS = {"scenario": "reachable_insertion", "reach-scenario": "reachable_domain"}
"""Other names that `orbsoc schema` takes."""


class _Imported(Mapping[str, "Mission"]):
    """The missions of `MODULES`, each imported when it is first asked for."""

    def __getitem__(self, name: str) -> Mission:
        with told_what_to_install():
            return cast("Mission", import_module(MODULES[name]))

    def __contains__(self, name: object) -> bool:
        return name in MODULES

    def __iter__(self) -> Iterator[str]:
        return iter(MODULES)

    def __len__(self) -> int:
        return len(MODULES)


MISSIONS: Mapping[str, Mission] = _Imported()


def load_scenario(
    path: str | PathLike[str], settings: Mapping[str, Any] | None = None
) -> tuple[Mission, BaseScenario]:
    """The mission that the file's `mission` names, and its scenario; `settings` override values, by dotted key.

    Raises `orbsoc.guidance.scenario_file.ScenarioError`.
    """
    from orbsoc.guidance.scenario_file import read_toml

    return made_scenario(read_toml(path), settings, source=str(path))


def made_scenario(
    document: Mapping[str, Any], settings: Mapping[str, Any] | None = None, *, source: str = "scenario"
) -> tuple[Mission, BaseScenario]:
    """The same of a document, the tables of a scenario file as dicts; `source` names it in errors."""
    from orbsoc.guidance.scenario_file import Complaint, ScenarioError, configured

    name = {**document, **(settings or {})}.get("mission")
    if name not in MISSIONS:
        what = "is missing" if name is None else "no such mission"
        allowed = f"{what}; allowed: {', '.join(MISSIONS)}.{did_you_mean(name, MISSIONS)}"
        raise ScenarioError(source, [Complaint("`mission`", "" if name is None else repr(name), allowed)])
    mission = MISSIONS[str(name)]
    return mission, configured(mission.Scenario, document, settings, source=source)


def dispersible(scenario: BaseScenario) -> Dispersible:
    """The scenario's mission, which has dispersed cases. Raises ScenarioError for one without."""
    from orbsoc.guidance.mission import Dispersible

    lacks = "has no dispersed cases", "without --cases it is planned once"
    return cast("Dispersible", _able(scenario, Dispersible, *lacks))


def auditable(scenario: BaseScenario) -> Auditable:
    """The scenario's mission, which judges impulses made elsewhere. Raises ScenarioError for one that does not."""
    from orbsoc.guidance.mission import Auditable

    lacks = "judges no impulses made elsewhere", "without --impulses it is planned"
    return cast("Auditable", _able(scenario, Auditable, *lacks))


def flyable(scenario: BaseScenario) -> Flyable:
    """The scenario's mission, which is flown in a closed loop. Raises ScenarioError for one without a loop."""
    from orbsoc.guidance.mission import Flyable

    return cast("Flyable", _able(scenario, Flyable, "has no closed loop", "`orbsoc plan` plans it"))


def _able(scenario: BaseScenario, protocol: type, lacks: str, otherwise: str) -> Mission:
    """The scenario's mission, which satisfies an optional protocol; the error says which missions do."""
    from orbsoc.guidance.scenario_file import Complaint, ScenarioError

    mission = MISSIONS[scenario.mission]
    if isinstance(mission, protocol):
        return mission
    able = ", ".join(name for name in MISSIONS if isinstance(MISSIONS[name], protocol))
    allowed = f"this mission {lacks}; missions with them: {able}; {otherwise}"
    raise ScenarioError(scenario.name, [Complaint("mission", repr(scenario.mission), allowed)])
