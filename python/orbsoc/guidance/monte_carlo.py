"""Dispersed cases of a scenario: the same mission from where the vehicle may really be, with the engine it may have.

Each case has its own random numbers, drawn from (seed, number): case 7 is the same whether or not 0 to 6 were made.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np

from .scenario_file import BaseScenario, Complaint, ScenarioError, checked, merged, nested

CLIP_SIGMA = 3.0
"""Draws are normal, cut off here."""

S = TypeVar("S", bound=BaseScenario)


@dataclass(frozen=True, slots=True)
class Spread:
    """Standard deviation of a number of a scenario, or of each component of a vector; `relative`: to the value itself."""

    name: str
    key: str
    """Dotted key of the scenario."""
    sigma: float
    relative: bool = False


@dataclass(frozen=True, slots=True)
class Dispersion:
    """What varies from case to case, in the order in which it is drawn; `source` says where the numbers come from."""

    spreads: tuple[Spread, ...]
    source: str

    def to_dict(self) -> dict[str, float]:
        """Standard deviations by name."""
        return {spread.name: spread.sigma for spread in self.spreads}

    def case(self, scenario: S, number: int, seed: int = 0, **changes: Any) -> S:
        """Case `number` ≥ 0 of `scenario`, a checked scenario named NAME-case-NUMBER; case 0 is not dispersed.

        `changes`: keys that every case has otherwise. Raises ScenarioError where a draw contradicts physics, or for a
        negative number or seed.
        """
        for key, value in (("case", number), ("seed", seed)):
            if value < 0:
                raise ScenarioError(scenario.name, [Complaint(key, str(value), "must be 0 or more")])
        document = scenario.model_dump() | {"name": f"{scenario.name}-case-{number:04d}"} | changes
        random = np.random.default_rng([seed, number])
        for spread in self.spreads if number else ():
            document = merged(document, nested({spread.key: _drawn(document, spread, random)}))
        return checked(type(scenario), document, source=f"{scenario.name}, case {number}")


def _drawn(document: Mapping[str, Any], spread: Spread, random: np.random.Generator) -> Any:
    """The value of a spread's key, dispersed."""
    value: Any = document
    for part in spread.key.split("."):
        value = value[part]
    draws = random.standard_normal(np.size(value)).clip(-CLIP_SIGMA, CLIP_SIGMA)
    if spread.relative:
        moved = np.atleast_1d(value) * (1.0 + spread.sigma * draws)
    else:
        moved = np.atleast_1d(value) + spread.sigma * draws
    return tuple(moved.tolist()) if np.ndim(value) else float(moved[0])
