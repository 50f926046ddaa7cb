"""The order of elimination as an axis of a sweep, and what is said where a key is another command's."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from orbsoc.commands.app import app
from tests.integration.small_problem import small_problem

SCENARIOS = Path(__file__).parents[2] / "scenarios"


def invoke(*arguments: str) -> Result:
    return CliRunner().invoke(app, [*arguments, "--json"])


@pytest.fixture
def workload(tmp_path: Path) -> Path:
    small_problem().save(tmp_path / "small.json")
    return tmp_path / "small.json"


def test_a_sweep_has_the_order_of_elimination_as_an_axis(workload: Path, tmp_path: Path) -> None:
    sweep, out = tmp_path / "sweep.toml", tmp_path / "out"
    sweep.write_text("[axes]\nordering = ['amd', 'nested_dissection']\n'pl.lanes' = [2, 4]\n")
    done = invoke("hw", "sweep", str(sweep), str(workload), "--out", str(out))
    assert done.exit_code == 0, done.output
    rows = list(csv.DictReader((out / "sweep.csv").read_text().splitlines()))
    assert [(row["ordering"], row["lanes"]) for row in rows] == [
        ("amd", "2"), ("amd", "4"), ("nested_dissection", "2"), ("nested_dissection", "4"),
    ]  # fmt: skip
    assert {"boot_load_ms", "plan_load_ms", "programs_resident"} <= rows[0].keys()
    assert json.loads(done.stdout)["axes"]["ordering"] == ["amd", "nested_dissection"]


@pytest.mark.parametrize("name", ["automatic", "best"])
def test_an_order_that_is_none_is_refused(name: str, workload: Path, tmp_path: Path) -> None:
    sweep = tmp_path / "sweep.toml"
    sweep.write_text(f"[axes]\nordering = ['{name}']\n")
    done = invoke("hw", "sweep", str(sweep), str(workload), "--out", str(tmp_path / "out"))
    assert done.exit_code == 2
    assert "allowed are amd, nested_dissection" in json.loads(done.stdout)["error"]


def test_a_number_alone_in_a_platform_file_is_told_how_a_parameter_is_written(
    workload: Path, tmp_path: Path
) -> None:
    device = tmp_path / "mine.toml"
    given = (SCENARIOS.parent / "hw_model" / "platform" / "platforms" / "zu9eg.toml").read_text()
    device.write_text(given.replace("[pl]\n", "[pl]\nlanes = 8\n"))
    done = invoke("hw", "budget", str(workload), "--device", str(device), "--out", str(tmp_path / "out"))
    assert done.exit_code == 2
    assert (
        '`pl.lanes` = 8: must be a table, such as { value = 8, tag = "assumed"'
        in json.loads(done.stdout)["error"]
    )


def test_a_key_of_the_computer_is_sent_to_where_it_can_be_set(tmp_path: Path) -> None:
    scenario = str(SCENARIOS / "paper000_1.toml")
    done = invoke("plan", scenario, "--set", "pl.clock_mhz=100", "--out", str(tmp_path / "out"))
    assert done.exit_code == 2
    assert "`orbsoc hw trace` and its --set" in json.loads(done.stdout)["error"]


def test_what_does_not_fit_is_said_by_every_command_that_prints_its_time(
    workload: Path, tmp_path: Path
) -> None:
    small = ("--set", "resources.bram36=3")
    traced = CliRunner().invoke(app, ["hw", "trace", str(workload), *small, "--out", str(tmp_path / "out")])
    assert "DOES NOT FIT" in traced.output
    explained = CliRunner().invoke(
        app,
        [
            "hw",
            "explain",
            str(workload),
            "zu9eg:paper:resources.bram36=3",
            "zu9eg:paper",
            "--out",
            str(tmp_path / "out"),
        ],
    )
    assert "A: the engine does NOT FIT" in explained.output
    sweep = tmp_path / "sweep.toml"
    sweep.write_text("[axes]\n'resources.bram36' = [3]\n")
    swept = CliRunner().invoke(
        app, ["hw", "sweep", str(sweep), str(workload), "--out", str(tmp_path / "out")]
    )
    assert "DOES NOT FIT" in swept.output
