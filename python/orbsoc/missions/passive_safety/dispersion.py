"""Dispersed cases: where the chaser holds before the approach."""

from __future__ import annotations

from orbsoc.guidance.monte_carlo import Dispersion, Spread

from .scenario import Scenario

DISPERSION = Dispersion((Spread("position", "start.x_m", 10.0),), source="assumed")


def disperse(scenario: Scenario, number: int, seed: int = 0) -> Scenario:
    """Case `number` of `scenario`; it is no row of the paper. Raises ScenarioError as `Dispersion.case` does."""
    return DISPERSION.case(scenario, number, seed, compare_with=None)
