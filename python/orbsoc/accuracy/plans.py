"""Plans of shipped scenarios against other programs and closed forms."""

from __future__ import annotations

from collections.abc import Iterator
from math import nan, sqrt
from pathlib import Path

from orbsoc.missions.registry import load_scenario
from orbsoc.orbit import EARTH

from .number import Number


def numbers(scenarios: Path) -> Iterator[Number]:
    """Burn times and velocity changes."""
    yield Number("apogee burn of a satellite on a transfer orbit", "Orekit's test of ConstantThrustManeuver", "3653.99",
                 _figure(scenarios / "orekit_apogee.toml", "time_of_flight_s"), 0.01, "s")  # fmt: skip
    yield Number("raise from 300 to 1000 km by two burns: Δv", "Hohmann 1925, closed form of impulses",
                 f"{_hohmann_m_s(6678137.0, 7378137.0):.4f}", _figure(scenarios / "raise_two_burns.toml", "delta_v_m_s"), 0.04, "m/s",
                 "burns of 37 s lose 1e-4 of it to gravity, and no plan may cost less")  # fmt: skip


def _figure(path: Path, name: str) -> float:
    """A figure of the scenario's plan; NaN where it is not verified."""
    mission, scenario = load_scenario(path)
    plan = mission.plan(scenario)
    return float(getattr(plan, name)) if plan.status.value == "verified" else nan


def _hohmann_m_s(inner_m: float, outer_m: float) -> float:
    """Two impulses between circles in one plane."""
    mu, total = EARTH.mu_m3_s2, 0.0
    for radius in (inner_m, outer_m):
        total += abs(sqrt(mu * (2.0 / radius - 2.0 / (inner_m + outer_m))) - sqrt(mu / radius))
    return total
