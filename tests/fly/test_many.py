"""Many flights: the same bits on any number of workers and after a kill, and each flight as it is alone."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from orbsoc.fly.computer import Computer
from orbsoc.fly.loop import Timing, fly
from orbsoc.fly.many import Study, cost_of_delay, fly_many, quantiles, read_flights
from orbsoc.fly.solver import OnboardSolver
from orbsoc.missions import platform_launch
from orbsoc.missions import reachable_insertion as mission
from orbsoc.sweep import Inline, Processes, StoreError

SCENARIO = Path(__file__).parents[2] / "scenarios" / "rec1.toml"
RUNS = 6


@pytest.fixture(scope="module")
def study() -> Study:
    scenario = mission.load_scenario(SCENARIO).with_changes(guidance={"period_s": 15.0})
    return Study(scenario.model_dump(mode="json"), "zu9eg", "paper", 1.0, Timing(0.1), RUNS, 4)


@pytest.fixture(scope="module")
def alone(study: Study, tmp_path_factory: pytest.TempPathFactory) -> dict[str, np.ndarray]:
    folder = tmp_path_factory.mktemp("alone") / "flights"
    fly_many(study, folder, Inline(), lambda *_: None, resume=False)
    return read_flights(folder)


def assert_same(one: dict[str, np.ndarray], other: dict[str, np.ndarray]) -> None:
    assert list(one) == list(other)
    for name, values in one.items():
        pairs = zip(values, other[name], strict=True)
        assert all(np.asarray(a).tobytes() == np.asarray(b).tobytes() for a, b in pairs), name


def test_two_workers_give_the_same_bits(study: Study, alone: dict[str, np.ndarray], tmp_path: Path) -> None:
    fly_many(study, tmp_path / "two", Processes(2), lambda *_: None, resume=False)
    assert_same(alone, read_flights(tmp_path / "two"))


def test_a_flight_of_many_is_the_flight_alone(study: Study, alone: dict[str, np.ndarray]) -> None:
    solver = OnboardSolver()
    scenario = mission.load_scenario(SCENARIO).with_changes(guidance={"period_s": 15.0})
    loop = mission.closed_loop(scenario, solver)
    flight = fly(loop, Computer("zu9eg", "paper"), solver, study.timing, seed=4, number=5)
    [row] = np.flatnonzero(alone["flight"] == 5)
    assert all(alone[name][row] == value for name, value in flight.outcome.items())
    assert alone["replans"][row] == flight.replans >= 3


def test_a_shard_is_small_enough_that_a_kill_loses_five_percent_at_most(study: Study) -> None:
    for runs in (100, 1000, 10_000, 100_000):
        tasks = replace(study, runs=runs).tasks()
        assert sum(task.rows for task in tasks) == runs
        assert 2 * max(task.rows for task in tasks) <= 0.05 * runs


def test_killed_and_resumed_it_has_the_same_bits(alone: dict[str, np.ndarray], tmp_path: Path) -> None:
    folder = tmp_path / "killed"
    command = [
        sys.executable, "-m", "orbsoc", "fly", str(SCENARIO), "--runs", str(RUNS), "--seed", "4", "--workers", "1",
        "--set", "guidance.period_s=15.0", "--out", str(folder), "--no-report",
    ]  # fmt: skip
    process = subprocess.Popen(
        command, stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL, start_new_session=True
    )
    limit = time.monotonic() + 240.0
    while time.monotonic() < limit and not list(folder.glob("flights/shard=*/part.parquet")):
        time.sleep(0.05)
    os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    kept = len(list(folder.glob("flights/shard=*/part.parquet")))
    assert kept >= 1
    done = subprocess.run([*command, "--resume"], capture_output=True, text=True, check=False)
    assert done.returncode in (0, 1), done.stderr
    assert_same(alone, read_flights(folder))
    assert (folder / "flights.csv").read_text().count("\n") == RUNS + 1


def test_another_study_is_refused(study: Study, tmp_path: Path) -> None:
    fly_many(replace(study, runs=1), tmp_path / "one", Inline(), lambda *_: None, resume=False)
    with pytest.raises(StoreError, match="another scenario"):
        fly_many(replace(study, runs=1, seed=5), tmp_path / "one", Inline(), lambda *_: None, resume=True)


def test_quantiles_are_values_that_occurred() -> None:
    found = quantiles(np.arange(1.0, 101.0))
    assert found == {"least": 1.0, "p50": 50.0, "p99": 99.0, "worst": 100.0}


def test_what_delay_costs_is_told_in_what_a_mission_spends() -> None:
    launch = platform_launch.load_scenario(SCENARIO.parent / "paper002_dispersed.toml")
    study = Study(launch.model_dump(mode="json"), "zu9eg", "paper", 1.0, Timing(60.0), 2, 4)
    rows = cost_of_delay(study)
    assert {each.spent for each in rows} == {"velocity change (m/s)"}
    assert all(np.isfinite(each.more_spent) for each in rows)
    assert rows[0].more_spent == 0.0
