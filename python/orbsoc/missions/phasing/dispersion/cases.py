"""Dispersed cases: where the target really is, and how much air it feels."""

from __future__ import annotations

from orbsoc.guidance.monte_carlo import Dispersion, Spread

from ..scenario import Scenario

DISPERSION = Dispersion(
    (
        Spread("along_track", "target.true_anomaly_deg", 0.01),
        Spread("size", "target.sma_km", 0.2),
        Spread("drag", "target.ballistic_m2_kg", 0.3, relative=True),
    ),
    source="assumed",
)


def disperse(scenario: Scenario, number: int, seed: int = 0) -> Scenario:
    """Case `number` of `scenario`; it is no row of the paper. Raises ScenarioError as `Dispersion.case` does."""
    return DISPERSION.case(scenario, number, seed, compare_with=None)
