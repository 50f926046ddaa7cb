"""The rendezvous after a launch in a closed loop: corrections bring the server to the target that it misses as planned."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from orbsoc.fly.computer import Computer
from orbsoc.fly.loop import Fate, Timing, fly
from orbsoc.fly.solver import OnboardSolver
from orbsoc.guidance.scenario_file import ScenarioError
from orbsoc.missions import platform_launch as mission
from orbsoc.missions.platform_launch.flight import LaunchLoop

SCENARIOS = Path(__file__).parents[3] / "scenarios"


@pytest.fixture(scope="module")
def loop() -> LaunchLoop:
    return LaunchLoop.of(mission.load_scenario(SCENARIOS / "paper002_dispersed.toml"), OnboardSolver())


def test_corrected_it_ends_nearer_to_the_target(loop: LaunchLoop) -> None:
    computer, solver, timing = Computer("zu9eg", "paper"), OnboardSolver(), Timing(loop.allowance_s)
    flights = [fly(loop, computer, solver, timing, seed=1, number=k) for k in range(1, 21)]
    still = [fly(loop, None, solver, timing, seed=1, number=k).outcome["miss_m"] for k in range(1, 21)]
    assert {cycle.fate for each in flights for cycle in each.cycles} == {Fate.FLOWN}
    assert np.mean([each.outcome["miss_m"] for each in flights]) < 0.4 * np.mean(still)
    assert len(solver.patterns) == 1


def test_an_answer_that_is_late_leaves_the_plan(loop: LaunchLoop) -> None:
    computer, solver = Computer("zu9eg", "paper", slower=1e8), OnboardSolver()
    slow = fly(loop, computer, solver, Timing(loop.allowance_s), seed=1, number=4)
    still = fly(loop, None, solver, Timing(loop.allowance_s), seed=1, number=4)
    assert not slow.replans
    assert slow.outcome == pytest.approx(still.outcome, rel=1e-6)


@pytest.mark.parametrize(
    ("changes", "key"),
    [
        ({"uncertainty": None}, "uncertainty"),
        (
            {"guidance": {"corrections": 20, "lead_s": 60.0}},
            r"guidance\.lead_s = 60: 20 corrections in 921 s",
        ),
    ],
)
def test_what_cannot_be_flown_is_told(changes: dict[str, object], key: str) -> None:
    scenario = mission.load_scenario(SCENARIOS / "paper002_dispersed.toml").with_changes(**changes)  # type: ignore[arg-type]
    with pytest.raises(ScenarioError, match=key):
        mission.closed_loop(scenario, OnboardSolver())
