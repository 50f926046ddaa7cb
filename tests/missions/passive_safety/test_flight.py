"""The approach in a closed loop: safe after every impulse, and nearer to its capture point than as planned."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from orbsoc.fly.computer import Computer
from orbsoc.fly.loop import Fate, Flight, Timing, fly
from orbsoc.fly.solver import OnboardSolver
from orbsoc.guidance.impulses import ImpulseProgramme
from orbsoc.guidance.impulsive_flight import Chaser, Impulses
from orbsoc.guidance.relative_flight import fly as fly_programme
from orbsoc.guidance.relative_flight import oblate
from orbsoc.guidance.scenario_file import ScenarioError
from orbsoc.guidance.uncertainty import Uncertainty
from orbsoc.missions import passive_safety as mission
from orbsoc.missions.passive_safety.flight import ApproachLoop

SCENARIOS = Path(__file__).parents[3] / "scenarios"


@pytest.fixture(scope="module")
def loop() -> ApproachLoop:
    return ApproachLoop.of(mission.load_scenario(SCENARIOS / "paper000_robust.toml"), OnboardSolver())


def flown(loop: ApproachLoop, number: int, computer: Computer | None, slower: float = 1.0) -> Flight:
    machine = None if computer is None else computer.at(slower)
    return fly(loop, machine, OnboardSolver(), Timing(loop.allowance_s), seed=2, number=number)


def test_the_chaser_flies_as_other_integrators_have_it() -> None:
    target = np.array([7.0e6, 0.0, 0.0, 0.0, 5.0e3, 5.6e3])
    start = np.array([10.0, -1000.0, 5.0, 0.01, -0.02, 0.03])
    programme = ImpulseProgramme([0.0, 700.0, 2000.0], [[0.1, 0.0, 0.0], [0.0, 0.2, -0.1], [0.05, 0.0, 0.1]])
    exact = Uncertainty(position_m=0.0, velocity_m_s=0.0)
    chaser = Chaser.at(start, target, exact, np.random.default_rng(0))
    for until_s in (300.0, 700.0, 1500.0, 2000.0):
        chaser.advance(Impulses(programme, 2000.0), until_s)
    wanted = fly_programme(programme, start, target, np.array([0.0, 2000.0]), oblate)
    assert len(chaser.after) == 3
    assert np.abs(chaser.relative - wanted.after[-1])[:3].max() < 1e-3
    assert np.abs(chaser.relative - wanted.after[-1])[3:].max() < 1e-6


def test_replanned_it_ends_nearer_and_stays_safe(loop: ApproachLoop) -> None:
    computer = Computer("zu9eg", "paper")
    closed = [flown(loop, number, computer).outcome for number in range(1, 13)]
    still = [flown(loop, number, None).outcome for number in range(1, 13)]
    assert all(each["safe"] for each in closed)
    assert np.mean([each["miss_m"] for each in closed]) < 0.3 * np.mean([each["miss_m"] for each in still])


def test_a_computer_slower_than_the_lead_fires_what_was_planned_last(loop: ApproachLoop) -> None:
    computer = Computer("zu9eg", "paper")
    slow, still = flown(loop, 3, computer, slower=1e6), flown(loop, 3, None)
    assert {each.fate for each in slow.cycles} == {Fate.MISSED}
    assert slow.outcome == pytest.approx(still.outcome, rel=1e-6)  # its coasts are cut at other times


def test_without_errors_there_is_no_loop() -> None:
    with pytest.raises(ScenarioError, match="uncertainty"):
        mission.closed_loop(mission.load_scenario(SCENARIOS / "paper000_1.toml"), OnboardSolver())
