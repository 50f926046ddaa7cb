"""What the tests of the reachable domain share: the paper's scenario and small parts of it."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np

from orbsoc.missions.reachable_domain import Scenario, load_scenario
from orbsoc.missions.reachable_domain.search.continuation.domain import Domain

SCENARIOS = Path(__file__).resolve().parents[3] / "scenarios"


@cache
def paper() -> Scenario:
    return load_scenario(SCENARIOS / "paper004_reach.toml")


@cache
def domain() -> Domain:
    return Domain.of(paper())


@cache
def kick_stage() -> Scenario:
    """5 t with 30 kN for 250 s from 51.6 degrees of inclination: its burn spans little of an orbit, so the domain is thin."""
    bound = {"first": 200.0, "last": 200.0, "step": 100.0}
    return Scenario.model_validate(
        {
            "mission": "reachable_domain",
            "name": "kick stage",
            "axes": "eci",
            "vehicle": {
                "mass_kg": 5000.0,
                "dry_mass_kg": 1500.0,
                "thrust_n": 30000.0,
                "mass_flow_kg_s": 8.997495996864073,
            },
            "initial": {
                "position_m": [3094818.5204263255, 4863274.553397475, 3361522.683773609],
                "velocity_m_s": [-6141.166428115682, 704.7614000295973, 4644.170890382302],
            },
            "burn": {"duration_s": 250.0},
            "grid": {
                "inclination_deg": {"first": 52.0, "last": 60.0, "step": 8.0},
                "raan_deg": {"first": 30.0, "last": 39.0, "step": 9.0},
                "perigee_height_km": {"first": 200.0, "last": 300.0, "step": 100.0},
            },
            "boundary": {"azimuths": 48, "perigee_height_km": bound},
        }
    )


def perigees(*heights_km: float) -> np.ndarray:
    """Perigee radii, canonical."""
    return 1.0 + 1e3 * np.array(heights_km) / 6378137.0


SMALL = {
    "inclination_deg = { first = 16.30, last = 40.30, step = 1.0 }": "inclination_deg = { first = 24.30, last = 30.30, step = 2.0 }",
    "raan_deg = { first = 318.25, last = 350.25, step = 1.0 }": "raan_deg = { first = 330.25, last = 350.25, step = 5.0 }",
    "perigee_height_km = { first = 100.0, last = 500.0, step = 10.0 }": "perigee_height_km = { first = 100.0, last = 500.0, step = 200.0 }",
    "azimuths = 144": "azimuths = 16",
    "step = 50.0": "step = 200.0",
}
"""The paper's scenario, 4 × 5 planes × 3 bounds."""


def small_scenario(folder: Path, **changes: str) -> Path:
    """A scenario file of a small grid in shards of 8 planes; `changes` replace whole lines by their key."""
    text = (SCENARIOS / "paper004_reach.toml").read_text(encoding="utf-8")
    for old, new in SMALL.items():
        assert old in text, old
        text = text.replace(old, new)
    for key, line in changes.items():
        lines = text.splitlines()
        where = [k for k, found in enumerate(lines) if found.startswith(f"{key} =")]
        assert where, key
        lines[where[0]] = line
        text = "\n".join(lines)
    path = folder / "small.toml"
    path.write_text(text + "\n[method]\nplanes_per_shard = 8\n", encoding="utf-8")
    return path
