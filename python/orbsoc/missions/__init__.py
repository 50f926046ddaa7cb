"""Missions: one folder per paper, each a scenario, a model, a plan, its figures.

Every mission package has the same face: `Scenario`, `plan(scenario, *, solve=…) -> Plan`. A mission builds conic
problems and hands them to whatever `solve` it is given; it knows no registers, cycles or partitions.

Missions are imported when they are first used: `orbsoc.missions.reachable_insertion.plan(scenario)`.
"""

from __future__ import annotations

from importlib import import_module
from types import ModuleType

MISSIONS = ("reachable_domain", "reachable_insertion")

__all__ = ["MISSIONS"]


def __getattr__(name: str) -> ModuleType:
    if name not in MISSIONS:
        raise AttributeError(
            f"module 'orbsoc.missions' has no attribute {name!r}; missions: {', '.join(MISSIONS)}"
        )
    return import_module(f".{name}", __name__)
