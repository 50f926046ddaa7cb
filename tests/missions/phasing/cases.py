"""The scenarios of the paper, and the plan that the tests share."""

from __future__ import annotations

from functools import cache
from pathlib import Path

from orbsoc.missions.phasing import Plan, Scenario, load_scenario, plan

SCENARIOS = Path(__file__).resolve().parents[3] / "scenarios"


@cache
def scenario(name: str = "socp") -> Scenario:
    return load_scenario(SCENARIOS / f"paper003_{name}.toml")


@cache
def planned(name: str = "socp") -> Plan:
    return plan(scenario(name))
