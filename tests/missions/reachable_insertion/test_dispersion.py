"""Dispersed cases: reproducible one by one, bounded, and checked like any scenario."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from orbsoc.guidance.monte_carlo import CLIP_SIGMA
from orbsoc.missions.reachable_insertion import DISPERSION, ScenarioError, disperse, load_scenario

SCENARIO = load_scenario(Path(__file__).resolve().parents[3] / "scenarios" / "rec1.toml")


def test_a_case_is_its_seed_and_number() -> None:
    assert disperse(SCENARIO, 7, 3) == disperse(SCENARIO, 7, 3)
    others = [disperse(SCENARIO, 7, 4), disperse(SCENARIO, 8, 3), SCENARIO]
    assert all(disperse(SCENARIO, 7, 3).initial != other.initial for other in others)


def test_case_0_is_the_scenario_but_for_its_name() -> None:
    case = disperse(SCENARIO, 0)
    assert case.name == "rec1-case-0000"
    assert (case.initial, case.vehicle, case.target) == (SCENARIO.initial, SCENARIO.vehicle, SCENARIO.target)
    assert case.compare_with is None


def test_draws_have_the_stated_spread_and_stay_within_the_clip() -> None:
    spread = DISPERSION.to_dict()
    cases = [disperse(SCENARIO, number) for number in range(1, 400)]
    position = np.array([case.initial.position_m for case in cases]) - SCENARIO.initial.position_m
    velocity = np.array([case.initial.velocity_m_s for case in cases]) - SCENARIO.initial.velocity_m_s
    thrust = np.array([case.vehicle.thrust_n / SCENARIO.vehicle.thrust_n - 1.0 for case in cases])
    for found, sigma in (
        (position, spread["position_m"]),
        (velocity, spread["velocity_m_s"]),
        (thrust, spread["thrust"]),
    ):
        assert np.std(found) == pytest.approx(sigma, rel=0.1)
        assert np.abs(found).max() <= CLIP_SIGMA * sigma * (1 + 1e-9)


def test_a_draw_against_physics_and_a_negative_number_are_refused() -> None:
    with pytest.raises(ScenarioError, match="case = -1: must be 0 or more"):
        disperse(SCENARIO, -1)
    with pytest.raises(ScenarioError, match="seed = -2: must be 0 or more"):
        disperse(SCENARIO, 1, -2)
    spreads = (replace(each, sigma=0.99) if each.name == "mass" else each for each in DISPERSION.spreads)
    heavy = replace(DISPERSION, spreads=tuple(spreads))
    drawn = [number for number in range(1, 200) if _mass_draw(number) < -1.05]
    with pytest.raises(ScenarioError, match=rf"rec1, case {drawn[0]}: vehicle\.mass_kg"):
        heavy.case(SCENARIO, drawn[0])


def _mass_draw(number: int) -> float:
    return float(np.random.default_rng([0, number]).standard_normal(9)[6])
