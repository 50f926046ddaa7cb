"""Scenarios at random about shipped ones: easy, hard and impossible ones, all of valid keys."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

Settings = dict[str, object]


def _deorbit(rng: np.random.Generator) -> Settings:
    # Thrust and propellant from too little to plenty.
    thrust_n, dry_kg = rng.uniform(100.0, 4000.0), rng.uniform(700.0, 980.0)
    longest_s = (1000.0 - dry_kg) * 310.0 * 9.80665 / thrust_n
    return {
        "vehicle.thrust_n": round(float(thrust_n), 1),
        "vehicle.dry_mass_kg": round(float(dry_kg), 1),
        "burn.duration_s": round(float(longest_s * rng.uniform(0.3, 0.95)), 1),
    }


def _largest(rng: np.random.Generator) -> Settings:
    return {
        "problem": "max_energy",
        "burn.duration_s": round(float(rng.uniform(10.0, 120.0)), 1),
        "target.perigee_direction": str(rng.choice(["fixed", "free"])),
        "target.perigee_height_km": round(float(rng.uniform(80.0, 220.0)), 1),
        "vehicle.thrust_n": round(float(rng.uniform(2e5, 8e5)), 1),
    }


def _approach(rng: np.random.Generator) -> Settings:
    return {
        "keep_out_m": round(float(rng.uniform(10.0, 120.0)), 1),
        "capture.z_m": round(float(rng.uniform(125.0, 200.0)), 1),
        "duration_s": round(float(rng.uniform(600.0, 6000.0)), 1),
        "condition": str(rng.choice(["short", "beyond", "none"])),
        "safety": str(rng.choice(["samples", "cone"])),
        "cost": str(rng.choice(["absolutes", "norms"])),
        "impulses.timing": "equal",
        "impulses.count": int(rng.integers(2, 7)),
        "start.x_m": round(float(rng.uniform(-3000.0, -300.0)), 1),
    }


def _fly_around(rng: np.random.Generator) -> Settings:
    return {
        "tolerance_m": round(float(rng.uniform(0.5, 10.0)), 2),
        "ellipse.period_s": round(float(rng.uniform(900.0, 5000.0)), 1),
        "ellipse.semi_axes_m": [float(v) for v in np.sort(rng.uniform(50.0, 400.0, 2).round(1))[::-1]],
        "truth.excess_share": float(rng.choice([0.0, 0.005, 0.05])),
    }


def _launch(rng: np.random.Generator) -> Settings:
    return {
        "phase_deg": round(float(rng.uniform(0.0, 359.0)), 1),
        "yaw_bias_deg": round(float(rng.uniform(-20.0, 20.0)), 1),
        "rendezvous.cost": str(rng.choice(["squares", "norms"])),
    }


def _phasing(rng: np.random.Generator) -> Settings:
    return {
        "window.revolutions": int(rng.integers(2, 14)),
        "window.latest_h": round(float(rng.uniform(12.0, 30.0)), 1),
    }


def _domain(rng: np.random.Generator) -> Settings:
    one = {name: round(float(rng.uniform(*span)), 1) for name, span in SPANS.items()}
    grid: Settings = {f"grid.{name}.{end}": value for name, value in one.items() for end in ("first", "last")}
    return grid | {"burn.duration_s": round(float(rng.uniform(100.0, 300.0)), 1)}


SPANS = {"inclination_deg": (42.0, 62.0), "raan_deg": (13.0, 43.0), "perigee_height_km": (150.0, 350.0)}
FAMILIES: dict[str, Callable[[np.random.Generator], Settings]] = {
    "deorbit": _deorbit,
    "rec1": _largest,
    "paper000_free": _approach,
    "paper001_equal": _fly_around,
    "paper002": _launch,
    "phasing_two_tles": _phasing,
    "kick_stage_reach": _domain,
}
"""By the scenario they are about."""


def random_settings(family: str, rng: np.random.Generator) -> Settings:
    """Values by key of the scenario."""
    return FAMILIES[family](rng)
