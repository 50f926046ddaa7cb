"""Dispersed cases: where the chaser really is when the fly-around begins, and how it moves."""

from __future__ import annotations

from orbsoc.guidance.monte_carlo import Dispersion, Spread

from .scenario import Scenario

POSITION_M = 0.1
VELOCITY_M_S = 2e-3

DISPERSION = Dispersion(
    (
        *(Spread(f"{axis}_m", f"start.{axis}_m", POSITION_M) for axis in "xyz"),
        *(Spread(f"v{axis}_m_s", f"start.v{axis}_m_s", VELOCITY_M_S) for axis in "xyz"),
    ),
    source="assumed",
)


def disperse(scenario: Scenario, number: int, seed: int = 0) -> Scenario:
    """Case `number` of `scenario`, started beside it. Raises ScenarioError as `Dispersion.case` does."""
    return DISPERSION.case(scenario.with_start(), number, seed)
