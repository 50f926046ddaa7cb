"""The fly-around in a closed loop stays in the tube that its plan alone leaves."""

from __future__ import annotations

from pathlib import Path

import pytest

from orbsoc.fly.computer import Computer
from orbsoc.fly.loop import Timing, fly
from orbsoc.fly.solver import OnboardSolver
from orbsoc.guidance.scenario_file import ScenarioError
from orbsoc.missions import fly_around as mission

SCENARIOS = Path(__file__).parents[3] / "scenarios"


def test_replanned_before_each_pulse_it_stays_in_the_tube() -> None:
    scenario = mission.load_scenario(SCENARIOS / "paper001_margin.toml")
    loop = mission.closed_loop(scenario, OnboardSolver())
    computer, timing = Computer("zu9eg", "all_ps"), Timing(loop.allowance_s)
    for number in (1, 2, 3):
        flight = fly(loop, computer, OnboardSolver(), timing, seed=1, number=number)
        still = fly(loop, None, OnboardSolver(), timing, seed=1, number=number)
        assert flight.outcome["error_m"] <= scenario.tolerance_m
        assert still.outcome["error_m"] > 3.0 * scenario.tolerance_m
        assert flight.replans == len(loop.first.programme) - 1
        assert flight.outcome["delta_v_m_s"] == pytest.approx(still.outcome["delta_v_m_s"], rel=0.03)


def test_without_errors_there_is_no_loop() -> None:
    with pytest.raises(ScenarioError, match="uncertainty"):
        mission.closed_loop(mission.load_scenario(SCENARIOS / "paper001_equal.toml"), OnboardSolver())
