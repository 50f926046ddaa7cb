"""Dispersed cases: navigation and engine at the end of an upper stage's coast."""

from __future__ import annotations

from orbsoc.guidance.monte_carlo import Dispersion, Spread

from .scenario import Scenario

DISPERSION = Dispersion(
    (
        Spread("position_m", "initial.position_m", 200.0),
        Spread("velocity_m_s", "initial.velocity_m_s", 1.0),
        Spread("mass", "vehicle.mass_kg", 0.002, relative=True),
        Spread("thrust", "vehicle.thrust_n", 0.005, relative=True),
        Spread("mass_flow", "vehicle.mass_flow_kg_s", 0.005, relative=True),
    ),
    source="assumed",
)


def disperse(scenario: Scenario, number: int, seed: int = 0) -> Scenario:
    """Case `number` of `scenario`; it is no case of the paper. Raises ScenarioError as `Dispersion.case` does."""
    return DISPERSION.case(scenario, number, seed, compare_with=None)
