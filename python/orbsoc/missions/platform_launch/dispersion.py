"""Dispersed cases: how hard the tube pushes, and where it points."""

from __future__ import annotations

from orbsoc.guidance.monte_carlo import Dispersion, Spread

from .scenario import Scenario

DISPERSION = Dispersion(
    (Spread("force", "force_n", 0.02, relative=True), Spread("yaw", "yaw_bias_deg", 0.5)), source="assumed"
)


def disperse(scenario: Scenario, number: int, seed: int = 0) -> Scenario:
    """Case `number` of `scenario`; from 1 on the server leaves at the end of the stroke. Raises ScenarioError as
    `Dispersion.case` does."""
    stroke = {"stop": "stroke", "stop_s": None} if number else {}
    return DISPERSION.case(scenario, number, seed, **stroke)
