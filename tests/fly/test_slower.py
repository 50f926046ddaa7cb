"""A computer that is too slow: the flight shows it, and the verdict names the re-plan and the slowest that would do."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from orbsoc.commands.app import app
from orbsoc.fly.computer import Computer
from orbsoc.fly.loop import Fate, Timing, fly
from orbsoc.fly.slower import enough_for
from orbsoc.fly.solver import OnboardSolver
from orbsoc.missions import reachable_insertion as mission

SCENARIO = Path(__file__).parents[2] / "scenarios" / "rec1.toml"
FLIGHT = 3


@pytest.fixture(scope="module")
def ready() -> tuple[mission.Scenario, OnboardSolver]:
    return mission.load_scenario(SCENARIO).with_changes(guidance={"period_s": 15.0}), OnboardSolver()


def test_the_slowest_that_would_do_does_and_one_a_little_slower_does_not(ready) -> None:  # type: ignore[no-untyped-def]
    scenario, solver = ready
    loop, timing = mission.closed_loop(scenario, solver), Timing(0.05, 0.05)
    computer = Computer("zu9eg", "paper")
    flight = fly(loop, computer, solver, timing, number=FLIGHT)
    assert flight.lost == 0
    factor = enough_for(loop, flight, computer, solver, timing).factor
    assert factor > 1.0
    again = [fly(loop, computer.at(s * factor), solver, timing, number=FLIGHT) for s in (1.0, 1.03)]
    assert again[0].lost == 0 < again[1].lost


def test_ten_times_too_slow_loses_every_replan_and_the_target(ready) -> None:  # type: ignore[no-untyped-def]
    scenario, solver = ready
    loop, timing = mission.closed_loop(scenario, solver), Timing(0.05, 0.05)
    computer = Computer("zu9eg", "paper")
    right, slow = (fly(loop, computer.at(s), solver, timing, number=FLIGHT) for s in (1.0, 10.0))
    still = fly(loop, None, solver, timing, number=FLIGHT)
    assert right.outcome["on_target"] == 1.0
    assert {each.fate for each in slow.cycles} == {Fate.MISSED}
    assert abs(slow.outcome["perigee_off_km"]) > 4.0 * abs(right.outcome["perigee_off_km"])
    assert slow.outcome["perigee_off_km"] == pytest.approx(still.outcome["perigee_off_km"], abs=1e-3)


def test_the_command_tells_the_damage_the_missed_cycle_and_what_would_do(tmp_path: Path) -> None:
    options = [
        "--deadline-ms",
        "50",
        "--slower",
        "10",
        "--flight",
        str(FLIGHT),
        "--set",
        "guidance.period_s=15.0",
    ]
    result = CliRunner().invoke(app, ["fly", str(SCENARIO), *options, "--out", str(tmp_path / "slow")])
    assert result.exit_code == 1, result.output
    text = " ".join(result.output.split())
    assert "Answer MISSED" in text
    assert "Deadline FAIL re-plan 1 at 15.0 s took" in text
    assert "of 50 ms" in text
    assert "the slowest that would do is" in text
    document = json.loads((tmp_path / "slow" / "flight.json").read_text())
    assert document["computer"]["slowest_that_would_do"] < 1.0
    assert {each["fate"] for each in document["cycles"]} == {"missed its window"}
    assert set(document["files"]) == {"cycles.csv", "flight.json", "flight.png", "report.html"}
    rows = (tmp_path / "slow" / "cycles.csv").read_text().splitlines()
    assert len(rows) == 1 + len(document["cycles"])
