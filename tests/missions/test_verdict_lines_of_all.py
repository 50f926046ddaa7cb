"""What `orbsoc plan` prints: few short lines that end, the exit code they mean, and no contradiction in words."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from orbsoc.commands.app import app
from tests.fuzz_budget import TIMES
from tests.missions.printed_rules import assert_printed
from tests.missions.random_scenarios import FAMILIES, random_settings

SCENARIOS = Path(__file__).parents[2] / "scenarios"
QUICK = (
    "deorbit",
    "kick_stage_reach",
    "paper000_1",
    "paper000_1_printed",
    "paper001_equal",
    "paper003_socp",
    "rec1",
    "rec2",
)
"""Scenarios that are planned within a few seconds."""
EACH = 3 * max(1, TIMES)
"""Random scenarios of a family."""


def assert_plan_is_well_told(path: Path, settings: dict[str, object], folder: Path) -> None:
    """Plan through the command line, and hold its console output against its `plan.json`."""
    pairs = [part for key, value in settings.items() for part in ("--set", f"{key}={json.dumps(value)}")]
    options = ["--no-report", "--device", "zu9eg", "--out", str(folder / "out"), "--estimate"]
    result = CliRunner().invoke(app, ["plan", str(path), *pairs, *options])
    assert result.exit_code in (0, 1), (settings, result.output)
    document = json.loads((folder / "out" / "plan.json").read_text())
    try:
        assert_printed(result.output, document, result.exit_code)
    except AssertionError as error:
        error.add_note(f"{path.name} with {settings}")
        raise


@pytest.mark.parametrize("name", QUICK)
def test_printed_verdict_is_short_and_its_worst_word_is_the_exit_code(name: str, tmp_path: Path) -> None:
    assert_plan_is_well_told(SCENARIOS / f"{name}.toml", {}, tmp_path)


@pytest.mark.parametrize("number", range(EACH))
@pytest.mark.parametrize("family", FAMILIES)
def test_random_scenario_is_told_without_a_contradiction(family: str, number: int, tmp_path: Path) -> None:
    rng = np.random.default_rng([number, *family.encode()])
    assert_plan_is_well_told(SCENARIOS / f"{family}.toml", random_settings(family, rng), tmp_path)
