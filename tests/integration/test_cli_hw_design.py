"""`orbsoc hw design` as a user meets it: files, resumption, refusals."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from hw_model import load_platform, speedup
from orbsoc.commands.app import app
from orbsoc.hw.exact_cycles import exact_cycles
from orbsoc.hw.workload import load_workload
from tests.integration.small_problem import small_problem

SMALL = ("--lanes", "2,4", "--dividers", "1", "--banks", "16", "--clocks", "100,150", "--threads", "1")


def invoke(*arguments: str | Path) -> Result:
    return CliRunner().invoke(app, ["hw", "design", *map(str, arguments)])


@pytest.fixture(scope="module")
def searched(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path, Result]:
    """Workload, results folder, and what the command printed."""
    folder = tmp_path_factory.mktemp("design")
    small_problem().save(folder / "small.json")
    out = folder / "out"
    return folder / "small.json", out, invoke(folder / "small.json", *SMALL, "--out", out)


def test_a_search_prices_every_design_and_places_the_papers(searched: tuple[Path, Path, Result]) -> None:
    workload, out, result = searched
    assert result.exit_code == 0, result.output
    document = json.loads((out / "design.json").read_text())
    with (out / "designs.csv").open() as lines:
        rows = list(csv.DictReader(lines))
    assert len(rows) == document["designs"] == 2 * 2 * 2 * 2 * 129
    assert document["schedules"] == 4
    with (out / "front.csv").open() as lines:
        assert len(list(csv.DictReader(lines))) == len(document["front"])
    assert (out / "design.png").read_bytes().startswith(b"\x89PNG")
    assert "the paper's design takes" in result.stdout
    record = load_workload(workload)
    platform = load_platform("zu9eg").with_values({"pl.lanes": 2, "pl.clock_mhz": 100.0})
    cycles = exact_cycles(record.problems, (), record.settings)
    (mine,) = (
        row
        for row in rows
        if (row["ordering"], row["lanes"], row["pl_clock_mhz"]) == ("amd", "2", "100.0")
        and (row["microcode_memory"], row["partition"]) == ("block_ram", "paper")
    )
    report = speedup(record.trace, platform, "paper", cycles=cycles)
    assert float(mine["time_ms"]) == report.makespan_ms.nominal
    assert float(mine["energy_mj"]) == report.energy.nominal_mj
    assert {"resident", "paper_streams"} <= {row["partition"] for row in rows}
    paper = speedup(record.trace, "zu9eg", "paper", cycles=cycles)
    assert document["paper"]["paper"]["time_ms"] == paper.makespan_ms.nominal


def test_a_search_is_resumed_and_never_mixed_with_another(searched: tuple[Path, Path, Result]) -> None:
    workload, out, _ = searched
    before = (out / "designs.csv").read_bytes()
    shard = next(out.glob("designs/shard=*/part.parquet"))
    shard.unlink()
    assert invoke(workload, *SMALL, "--out", out).exit_code == 2
    again = invoke(workload, *SMALL, "--out", out, "--resume")
    assert again.exit_code == 0, again.output
    assert (out / "designs.csv").read_bytes() == before
    other = invoke(workload, *SMALL, "--device", "zu7ev", "--out", out, "--resume")
    assert (other.exit_code, "another scenario" in other.output + other.stderr) == (2, True)


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (("--lanes", "3,32"), "`pl.lanes` = 32: no engine of rtl/ has more than 16"),
        (("--ordering", "metis"), "`ordering` = 'metis': allowed are amd, nested_dissection, automatic"),
        (("--set", "pl.lanes=2"), "--lanes sets `pl.lanes`; use that one"),
        (("--lanes", "4", "--clusters", "8"), "--clusters 8 divides none of --lanes 4: no engine is left"),
        (("--memories", "flash"), "`pl.microcode_memory` = 'flash'"),
        (("--set", "runtime.jitter_exponent=2.0"), "would do nothing here"),
    ],
)
def test_bad_input_is_refused_by_name(
    searched: tuple[Path, Path, Result], tmp_path: Path, options: tuple[str, ...], says: str
) -> None:
    result = invoke(searched[0], *options, "--out", tmp_path / "out")
    assert result.exit_code == 2
    assert says in result.output + result.stderr


ONE_LANE = ("--lanes", "1", "--dividers", "1", "--banks", "16", "--clusters", "1", "--ordering", "amd")


def test_designs_whose_lines_are_too_short_to_stream_are_left_out(tmp_path: Path) -> None:
    """A line of one lane has 32 bits, a port 64."""
    small_problem().save(tmp_path / "small.json")
    result = invoke(tmp_path / "small.json", *ONE_LANE, "--out", tmp_path / "out")
    assert result.exit_code == 0, result.output
    document = json.loads((tmp_path / "out" / "design.json").read_text())
    assert document["designs"] == document["left_out"] == 129
    assert "129 that rtl/ cannot stream are left out" in result.stdout
    alone = invoke(tmp_path / "small.json", *ONE_LANE, "--memories", "streamed", "--out", tmp_path / "alone")
    assert (alone.exit_code, "no design is left" in alone.output + alone.stderr) == (2, True)
