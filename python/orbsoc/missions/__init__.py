"""Missions: one folder each, with a scenario, a model, a plan and its figures; all satisfy `guidance.mission.Mission`.

Missions are imported when they are first used: `orbsoc.missions.reachable_insertion.plan(scenario)`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from .registry import MISSIONS

if TYPE_CHECKING:
    from orbsoc.guidance.mission import Mission

__all__ = ["MISSIONS"]


def __getattr__(name: str) -> Mission:
    if name not in MISSIONS:
        raise AttributeError(
            f"module 'orbsoc.missions' has no attribute {name!r}; missions: {', '.join(MISSIONS)}"
        )
    return MISSIONS[name]


def __dir__() -> list[str]:
    return sorted({*__all__, *MISSIONS})
