"""The outer loop of a plan in its trace, where the mission has a program in C that makes that very plan."""

from __future__ import annotations

from typing import Any

from orbsoc.guidance.mission import Mission, OnBoard, Plan
from orbsoc.guidance.outer_loop import OuterLoop


def outer_loop_of(mission: Mission, scenario: Any, plan: Plan) -> OuterLoop | None:
    """What the program does around the solves of a plan; None where there is no such program."""
    return mission.outer_loop(scenario, plan) if isinstance(mission, OnBoard) else None


def with_outer_loop(trace: dict[str, Any], found: OuterLoop | None) -> dict[str, Any]:
    """A trace with what happens around its solves."""
    return trace if found is None else trace | {"outer_loop": found.to_dict()}
