"""Dispersed cases: where the chaser really is when the approach begins."""

from __future__ import annotations

from orbsoc.guidance.monte_carlo import Dispersion, Spread

from .scenario import Scenario

DISPERSION = Dispersion(
    (
        Spread("along", "start.x_m", 20.0),
        Spread("across", "start.y_m", 5.0),
        Spread("below", "start.z_m", 5.0),
    ),
    source="assumed",
)


def disperse(scenario: Scenario, number: int, seed: int = 0) -> Scenario:
    """Case `number` of `scenario`. Raises ScenarioError as `Dispersion.case` does."""
    return DISPERSION.case(scenario, number, seed)
