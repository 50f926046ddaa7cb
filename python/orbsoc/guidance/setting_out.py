"""What a closed loop has before it can be flown: errors to fly with, a programme that was planned on the ground, and its lead."""

from __future__ import annotations

from typing import Any, Protocol, TypeVar

from .mission import PlanStatus
from .scenario_file import Complaint, ScenarioError

Given = TypeVar("Given")


class Planned(Protocol):
    """How planning on the ground ended."""

    @property
    def status(self) -> PlanStatus: ...

    @property
    def message(self) -> str: ...


def given_errors(scenario: str, errors: Given | None, of: str) -> Given:
    """The errors of the scenario of that name. Raises ScenarioError where it has none; `of`: what they are of, in words."""
    if errors is None:
        allowed = f"is missing; a closed loop needs the errors of {of}"
        raise ScenarioError(scenario, [Complaint("uncertainty", "", allowed)])
    return errors


def programme_of(scenario: str, found: Planned, programme: Given | None, key: str, value: str = "") -> Given:
    """What a flight sets out with. Raises ScenarioError by a key and its value where there is none, KeyboardInterrupt where planning
    was interrupted."""
    if found.status is PlanStatus.INTERRUPTED:
        raise KeyboardInterrupt
    if programme is None:
        allowed = f"no programme to set out with: {found.message}"
        raise ScenarioError(scenario, [Complaint(key, value, allowed)])
    return programme


class Lead:
    """Guidance that begins `[guidance] lead_s` before it fires, and has that long for its answer."""

    scenario: Any

    @property
    def period_s(self) -> float:
        return float(self.scenario.guidance.lead_s)

    @property
    def allowance_s(self) -> float:
        return self.period_s
