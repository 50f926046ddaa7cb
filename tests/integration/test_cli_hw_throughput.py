"""`orbsoc hw throughput`: sets of engines against all cores, and input that it refuses."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner, Result

from orbsoc.commands.app import app
from tests.integration.small_problem import small_problem

GRID = ("--shapes", "2x1x16x1,4x1x16x1", "--copies", "1,2", "--engines", "1,2")


@pytest.fixture(scope="module")
def workload(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("throughput") / "small.json"
    small_problem().save(path)
    return path


def invoke(workload: Path, out: Path, *arguments: str) -> Result:
    return CliRunner().invoke(app, ["hw", "throughput", str(workload), "--out", str(out), *arguments])


def document(workload: Path, out: Path, *arguments: str, code: int = 0) -> dict[str, Any]:
    done = invoke(workload, out, *arguments, "--json")
    assert done.exit_code == code, done.output
    found: dict[str, Any] = json.loads(done.stdout)
    return found


def test_every_set_of_the_grid_has_a_row_and_two_engines_take_twice_as_much(
    workload: Path, tmp_path: Path
) -> None:
    found = document(workload, tmp_path, *GRID)
    rows = list(csv.DictReader((tmp_path / "throughput.csv").read_text().splitlines()))
    assert len(rows) == len(found["sets"]) == 8
    assert (tmp_path / "throughput.png").stat().st_size > 10_000
    pairs = zip(found["sets"][::2], found["sets"][1::2], strict=True)
    for one, two in pairs:
        assert (one["engines"], two["engines"]) == (1, 2)
        assert one["solves_per_s"] < two["solves_per_s"] <= 2.001 * one["solves_per_s"]
        assert two["share"] == pytest.approx(2.0 * one["share"])
        assert one["baseline_per_s"] == two["baseline_per_s"]
    fitting = [row["solves_per_s"] for row in found["sets"] if row["fits"]]
    assert found["best"]["solves_per_s"] == max(fitting)


def test_the_best_set_is_told_at_both_prices_with_their_bands(workload: Path, tmp_path: Path) -> None:
    found = document(workload, tmp_path, *GRID)
    assert len(found["gains"]) == 2
    for band in found["gains"].values():
        assert band["low"] < band["nominal"] < band["high"]
    assert found["best"]["gain"] in [band["nominal"] for band in found["gains"].values()]
    said = invoke(workload, tmp_path, *GRID).stdout
    assert "times as many solves a second" in said
    assert "engines  lanes" in said


def test_where_no_set_fits_it_says_so(workload: Path, tmp_path: Path) -> None:
    found = document(workload, tmp_path, *GRID, "--set", "resources.lut=3", code=1)
    assert found["best"] is None
    assert found["headline"].endswith("NO SET FITS")


def test_one_pattern_is_priced_by_itself(workload: Path, tmp_path: Path) -> None:
    whole, alone = (document(workload, tmp_path, *GRID, *more) for more in ((), ("--pattern", "most")))
    assert whole["sets"] == alone["sets"]
    assert alone["workload"].endswith("of it the 1 of pattern 0")


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("--set", "pl.lanes=8"), "--shapes sets `pl.lanes`; use that one"),
        (("--set", "pl.interleaved=8"), "--copies sets `pl.interleaved`; use that one"),
        (("--shapes", "4x1"), "--shapes '4x1'"),
        (("--shapes", "4x1x16x3"), "`pl.clusters`: 3 is no power of two"),
        (("--copies", "0"), "--copies '0': 0: allowed are whole numbers from 1"),
        (("--engines", "1,1"), "names 1 twice"),
        (("--pattern", "1"), "--pattern '1': allowed are 0, most"),
        (("--partition", "all_ps"), "has nothing on the PL"),
        (("--partition", "paper", "--copies", "2"), "only the PL's own control"),
        (("--set", 'pl.microcode_memory="streamed"'), "do not share a stream"),
    ],
)
def test_bad_input_is_told_and_nothing_is_written(
    workload: Path, tmp_path: Path, arguments: tuple[str, ...], says: str
) -> None:
    found = document(workload, tmp_path / "out", *arguments, code=2)
    assert says in found["error"], found["error"]
    assert not (tmp_path / "out").exists()
