"""What the tests of the reachable domain share: the paper's scenario and small parts of it."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np

from orbsoc.missions.reachable_domain import Scenario, load_scenario
from orbsoc.missions.reachable_domain.domain import Domain

SCENARIOS = Path(__file__).resolve().parents[2] / "scenarios"


@cache
def paper() -> Scenario:
    return load_scenario(SCENARIOS / "paper004_reach.toml")


@cache
def domain() -> Domain:
    return Domain.of(paper())


def perigees(*heights_km: float) -> np.ndarray:
    """Perigee radii, canonical."""
    return 1.0 + 1e3 * np.array(heights_km) / 6378137.0
