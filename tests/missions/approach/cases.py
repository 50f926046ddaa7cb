"""Scenarios of this mission that the tests change."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

from orbsoc.guidance.scenario_file import checked, merged, nested, read_toml
from orbsoc.missions import approach
from orbsoc.missions.approach.plan import Plan
from orbsoc.missions.approach.scenario import Scenario

SCENARIOS = Path(__file__).parents[3] / "scenarios"
STATIONS = ("station_vbar", "station_rbar")


def station(name: str = "station_vbar", **changes: Any) -> Scenario:
    """A shipped scenario with other values, by keys whose dots are double underscores."""
    dotted = {key.replace("__", "."): value for key, value in changes.items()}
    return checked(Scenario, merged(read_toml(SCENARIOS / f"{name}.toml"), nested(dotted)), source=name)


@cache
def planned(name: str = "station_vbar") -> Plan:
    """The plan of a shipped scenario."""
    return approach.plan(station(name))
