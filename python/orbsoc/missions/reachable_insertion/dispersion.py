"""Dispersed cases of a scenario: the same mission from where the vehicle may really be, with the engine it may have.

Each case has its own random numbers, drawn from (seed, number): case 7 is the same whether or not 0 to 6 were made.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from orbsoc.guidance.scenario_file import Complaint, ScenarioError, checked

from .scenario import Scenario

CLIP_SIGMA = 3.0
"""Draws are normal, cut off here."""


@dataclass(frozen=True, slots=True)
class Dispersion:
    """Standard deviations: of each axis of the initial state, and of mass, thrust and mass flow relative to themselves.

    The defaults are assumed: navigation and engine at the end of an upper stage's coast, from no named source.
    """

    position_m: float = 200.0
    velocity_m_s: float = 1.0
    mass: float = 0.002
    thrust: float = 0.005
    mass_flow: float = 0.005


def dispersed(scenario: Scenario, number: int, seed: int = 0, spread: Dispersion | None = None) -> Scenario:
    """Case `number` ≥ 0 of `scenario`, a checked scenario named NAME-case-NUMBER; case 0 is not dispersed.

    Raises ScenarioError where a draw contradicts physics, or for a negative number or seed.
    """
    for key, value in (("case", number), ("seed", seed)):
        if value < 0:
            raise ScenarioError(scenario.name, [Complaint(key, str(value), "must be 0 or more")])
    spread = spread or Dispersion()
    document = scenario.model_dump()
    document |= {"name": f"{scenario.name}-case-{number:04d}", "compare_with": None}
    if number:
        draws = np.random.default_rng([seed, number]).standard_normal(9).clip(-CLIP_SIGMA, CLIP_SIGMA)
        initial, vehicle = document["initial"], document["vehicle"]
        initial["position_m"] = _moved(initial["position_m"], spread.position_m * draws[:3])
        initial["velocity_m_s"] = _moved(initial["velocity_m_s"], spread.velocity_m_s * draws[3:6])
        for draw, name, sigma in zip(
            draws[6:],
            ("mass_kg", "thrust_n", "mass_flow_kg_s"),
            (spread.mass, spread.thrust, spread.mass_flow),
            strict=True,
        ):
            vehicle[name] = float(vehicle[name] * (1.0 + sigma * draw))
    return checked(Scenario, document, source=f"{scenario.name}, case {number}")


def _moved(vector: tuple[float, ...], by: np.ndarray) -> tuple[float, ...]:
    return tuple(float(value) for value in np.asarray(vector) + by)
