"""`orbsoc hw`, as a user and as another program meet it."""

from __future__ import annotations

import csv
import json
import math
import re
from pathlib import Path
from typing import Any, get_args

import pytest
from matplotlib.image import imread
from typer.testing import CliRunner, Result

from hw_model.platform.parameter import Tag
from orbsoc import Cones, Problem
from orbsoc.commands.app import app
from tests.integration.small_problem import small_problem

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def workload(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A problem with cones, equalities and bounds, as a file."""
    path = tmp_path_factory.mktemp("hw") / "small.json"
    small_problem().save(path)
    return path


def invoke(*arguments: str | Path) -> Result:
    return CliRunner().invoke(app, ["hw", *map(str, arguments)])


def test_partition_prices_all_and_judges_the_papers(workload: Path, tmp_path: Path) -> None:
    result = invoke(
        "partition",
        workload,
        "--device",
        "zu9eg,xc7z020",
        "--lanes",
        "2,4",
        "--clocks",
        "150",
        "--out",
        tmp_path,
    )
    assert result.exit_code == 0, result.output
    assert result.stdout.splitlines()[0].endswith("520 configurations")
    assert "Pareto-optimal" in result.stdout
    document = json.loads((tmp_path / "partition.json").read_text())
    assert document["schema"] == "orbsoc.hardware-partitions/1"
    assert len(document["paper"]) == 4
    assert all(verdict["pareto_optimal"] == (verdict["better"] is None) for verdict in document["paper"])
    with (tmp_path / "partition.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 520
    assert {row["device"] for row in rows} == {"zu9eg", "xc7z020"}
    names = {path.name for path in tmp_path.iterdir()}
    assert names == {
        "partition.json",
        "partition.csv",
        "pareto.csv",
        "energy_sensitivity.csv",
        "pareto.png",
        "amdahl.png",
        "roofline.png",
        "speedup.png",
    }


def test_sweep_takes_its_workload_from_its_file_or_the_command_line(workload: Path, tmp_path: Path) -> None:
    file = tmp_path / "sweep.toml"
    file.write_text("[axes]\n'pl.lanes' = [1, 2, 4]\n", encoding="utf-8")
    assert invoke("sweep", file, "--out", tmp_path / "a").exit_code == 2
    given = invoke("sweep", file, workload, "--out", tmp_path / "a", "--json")
    assert given.exit_code == 0, given.output
    file.write_text(
        f"workload = {json.dumps(str(workload))}\n[axes]\n'pl.lanes' = [1, 2, 4]\n", encoding="utf-8"
    )
    named = invoke("sweep", file, "--out", tmp_path / "b", "--json")
    assert json.loads(given.stdout) == json.loads(named.stdout)
    assert json.loads(named.stdout)["points"] == 3
    assert (tmp_path / "a" / "sweep.csv").read_text() == (tmp_path / "b" / "sweep.csv").read_text()


def test_a_sweep_of_which_nothing_fits_says_what_is_nearest_and_what_it_lacks(
    workload: Path, tmp_path: Path
) -> None:
    file = tmp_path / "sweep.toml"
    file.write_text("[axes]\n'pl.lanes' = [2, 4]\n'resources.dsp' = [3]\n", encoding="utf-8")
    found = invoke("sweep", file, workload, "--estimate", "--out", tmp_path / "a")
    assert found.exit_code == 0, found.output
    assert "2 points, 0 fit, 0 on the Pareto front" in found.stdout
    assert re.search(
        r"none fits; nearest to it: zu9eg paper 2 lanes .*, dsp at \d+ % of its ceiling", found.stdout
    )


def test_explain_adds_up_in_the_table_that_is_printed(workload: Path, tmp_path: Path) -> None:
    result = invoke("explain", workload, "zu9eg:paper", "zu9eg:factor_only:pl.lanes=8", "--out", tmp_path)
    assert result.exit_code == 0, result.output
    assert "differs: pl.lanes = 4 → 8" in result.stdout
    table = [line.split() for line in result.stdout.splitlines() if len(line.split()) == 4]
    differences = {row[0]: float(row[3]) for row in table if row[0] not in ("cause", "written")}
    total = differences.pop("sum")
    assert sum(differences.values()) == pytest.approx(total, abs=0.001 * len(differences))


def test_trace_writes_the_viewers_document_and_a_record_that_can_be_priced_again(
    workload: Path, tmp_path: Path
) -> None:
    settings = ("--set", "pl.lanes=2", "--set", "runtime.completion=polling")
    result = invoke("trace", workload, *settings, "--estimate", "--out", tmp_path)
    assert result.exit_code == 0, result.output
    document = json.loads((tmp_path / "trace.json").read_text())
    assert document["otherData"]["parameters"]["pl.lanes"]["value"] == 2
    again = invoke("trace", tmp_path / "recorded.json", *settings, "--estimate", "--out", tmp_path / "again")
    assert again.exit_code == 0, again.output
    repeated = json.loads((tmp_path / "again" / "trace.json").read_text())
    assert repeated["traceEvents"] == document["traceEvents"]


def test_cycles_are_the_schedules_unless_there_is_only_a_trace(workload: Path, tmp_path: Path) -> None:
    def cycles(what: Path, *options: str) -> list[int]:
        folder = tmp_path / "-".join(("cycles", what.stem, *options))
        result = invoke("trace", what, *options, "--out", folder)
        assert result.exit_code == 0, result.output
        events = json.loads((folder / "trace.json").read_text())["traceEvents"]
        return [event["args"]["cycles"] for event in events if event.get("name") == "equilibrate"]

    assert cycles(workload) == cycles(workload, "--exact") != cycles(workload, "--estimate")
    recorded = tmp_path / "-".join(("cycles", workload.stem)) / "recorded.json"
    assert cycles(recorded) == cycles(workload)
    problem = recorded.with_name("pattern_0.json")
    Problem(c=[1.0], G=[[-1.0]], h=[-2.0], cones=Cones(l=1)).save(problem)
    foreign = invoke("trace", recorded, "--out", tmp_path / "refused")
    assert foreign.exit_code == 2
    assert "is no problem of that pattern of recorded.json" in foreign.output + foreign.stderr
    problem.unlink()
    assert cycles(recorded) == cycles(workload, "--estimate")
    refused = invoke("trace", recorded, "--exact", "--out", tmp_path / "refused")
    assert refused.exit_code == 2
    assert "--exact" in refused.output + refused.stderr


def test_the_order_is_chosen_by_the_modelled_run(tmp_path: Path) -> None:
    """Where pivots wait for one another, the shallow tree wins on an engine that is wide enough."""
    problem = ROOT / "scenarios" / "rendezvous_40.json"

    def run_ms(*options: str) -> float:
        result = invoke("trace", problem, *options, "--out", tmp_path / "out")
        assert result.exit_code == 0, result.output
        return float(result.stdout.split(": ")[2].split(" ms")[0])

    wide = ("--set", "pl.lanes=8", "--set", "pl.dividers=4")
    times = {name: run_ms(*wide, "--ordering", name) for name in ("amd", "nested_dissection", "automatic")}
    assert times["nested_dissection"] < times["amd"]
    assert times["automatic"] == times["nested_dissection"]
    refused = invoke("trace", problem, "--ordering", "metis")
    assert (refused.exit_code, "--ordering 'metis'" in refused.output + refused.stderr) == (2, True)


def test_budget_exits_1_when_it_does_not_fit(workload: Path, tmp_path: Path) -> None:
    fits = invoke("budget", workload, "--out", tmp_path)
    assert (fits.exit_code, "FITS" in fits.stdout) == (0, True)
    over = invoke(
        "budget", workload, "--device", "xc7z020", "--set", "pl.lanes=16", "--out", tmp_path, "--json"
    )
    assert over.exit_code == 1
    document = json.loads(over.stdout)
    assert document["fits"] is False
    assert "DOES NOT FIT" in document["headline"]
    assert {row["tag"] for row in document["assumptions"]} <= set(get_args(Tag))


def test_budget_says_that_streamed_microcode_is_not_on_the_chip(workload: Path, tmp_path: Path) -> None:
    done = invoke("budget", workload, "--set", "pl.microcode_memory=streamed", "--out", tmp_path)
    assert done.exit_code == 0
    assert "streamed from memory, through buffers of" in done.stdout
    assert "nothing is on the PL" not in done.stdout


def test_calibrate_writes_a_platform_that_the_other_commands_take(workload: Path, tmp_path: Path) -> None:
    times = tmp_path / "times.csv"
    times.write_text("stage,runs,microseconds\nfactorize,10,50.0\nstatistics,10,60.0\n", encoding="utf-8")
    result = invoke("calibrate", workload, times, "--set", "ps.clock_mhz=1200.0", "--out", tmp_path)
    assert result.exit_code == 0, result.output
    document = json.loads((tmp_path / "calibration.json").read_text())
    [row] = [row for row in document["assumptions"] if row["key"] == "ps.flop_per_cycle"]
    assert (row["tag"], row["value"]) == ("measured", document["flop_per_cycle"])
    used = invoke(
        "budget", workload, "--device", tmp_path / "zu9eg-calibrated.toml", "--out", tmp_path, "--json"
    )
    assert row in json.loads(used.stdout)["assumptions"]


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("trace", "{w}", "--device", "zu8"), "platform 'zu8' is not known"),
        (("trace", "{w}", "--partition", "half"), "partition 'half' is not known"),
        (("trace", "{w}", "--set", "pl.lanes"), "must be KEY=VALUE"),
        (("trace", "{w}", "--set", "pl.lanes=-1"), "`pl.lanes` = -1"),
        (("trace", "{w}", "--set", "pl.lanez=1"), "`pl.lanez` is not a parameter"),
        (("trace", "{w}", "--set", "link.register_write_ns=-1.0"), "`link.register_write_ns` = -1.0"),
        (("explain", "{w}", "zu9eg", "zu9eg:paper"), "must be DEVICE:PARTITION"),
        (("partition", "{w}", "--lanes", "two"), "must be numbers joined by commas"),
        (("budget", "{w}.missing"), "No such file"),
        (("budget", "{root}/pyproject.toml"), "`mission`: is missing; allowed: reachable_domain, "),
        (("budget", "{root}/tests/strategies.py"), "is not JSON"),
    ],
)
def test_bad_input_exits_2_and_is_named(
    workload: Path, tmp_path: Path, arguments: tuple[str, ...], says: str
) -> None:
    filled = [text.format(w=workload, root=ROOT) for text in arguments]
    result = invoke(*filled, "--out", tmp_path, "--json")
    assert result.exit_code == 2, result.output
    document = json.loads(result.stdout)
    assert document["exit_code"] == 2
    assert says in document["error"]
    assert not list(tmp_path.iterdir())


def test_a_trace_of_another_schema_version_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "trace.json"
    path.write_text(json.dumps({"schema": "orbsoc.trace/3"}), encoding="utf-8")
    result = invoke("budget", path, "--out", tmp_path / "out")
    assert result.exit_code == 2
    assert "orbsoc.trace/2" in result.output


def test_a_scenario_is_planned_once_and_priced(tmp_path: Path) -> None:
    result = invoke("budget", ROOT / "scenarios" / "rec1.toml", "--out", tmp_path, "--json")
    assert result.exit_code == 0, result.output
    assert json.loads(result.stdout)["workload"].startswith("plan of rec1.toml (")


def test_partition_tells_what_it_is_at_and_takes_one_device(workload: Path, tmp_path: Path) -> None:
    result = invoke("partition", workload, "--lanes", "4", "--clocks", "150", "--out", tmp_path)
    assert result.exit_code == 0, result.output
    assert result.stderr.startswith(f"recording {workload.name}\npricing ")
    document = json.loads((tmp_path / "partition.json").read_text())
    assert list(document["assumptions"]) == ["zu9eg"]


def test_all_devices_and_one_device_contradict(workload: Path) -> None:
    result = invoke("partition", workload, "--all", "--device", "zu9eg")
    assert result.exit_code == 2
    assert "--all: --device 'zu9eg' asks for others; give one of the two" in result.stderr


def test_the_opening_figure_of_the_docs_is_what_its_command_draws(tmp_path: Path) -> None:
    """Same bars under the same names; their heights follow the solver, so that only the picture's size is compared."""
    text = (ROOT / "docs" / "hardware-experiments.md").read_text(encoding="utf-8")
    figure = re.search(r"!\[[^]]*\]\((figures/[^)]*)\)", text)
    command = re.search(r"^orbsoc hw (partition \S+ --all) --out \S+ .*speedup\.png", text, re.MULTILINE)
    assert figure
    assert command
    name, scenario, every = command[1].split()
    result = invoke(name, ROOT / scenario, every, "--out", tmp_path)
    assert result.exit_code == 0, result.output
    drawn, shown = (imread(path).shape for path in (tmp_path / "speedup.png", ROOT / "docs" / figure[1]))
    assert drawn == shown


def test_precision_lists_every_datapath_and_says_why_one_fails(tmp_path: Path) -> None:
    result = invoke("precision", ROOT / "scenarios" / "rec1.toml", "--out", tmp_path, "--json")
    assert result.exit_code == 0, result.output
    rows = json.loads(result.stdout)["rows"]
    found = {(row["bits"], row["narrow_modules"]): row for row in rows}
    assert len(found) == len(rows) == 8
    assert found[24, "factorization"]["reached"]
    assert found[24, "factorization"]["dsp"] < found[53, "factorization"]["dsp"]
    assert all(bool(row["why_not"]) != row["reached"] for row in rows)
    assert "do not reach 1e-06" in result.stderr


@pytest.mark.parametrize("tol", ["-1", "0", "nan", "1"])
def test_precision_refuses_an_impossible_tolerance(workload: Path, tmp_path: Path, tol: str) -> None:
    result = invoke("precision", workload, "--tol", tol, "--out", tmp_path / "p")
    assert result.exit_code == 2, result.output
    assert "must be above 0 and below 1" in result.output


def test_the_budget_and_the_run_name_one_compression(workload: Path, tmp_path: Path) -> None:
    run = invoke("run", workload, "--out", tmp_path / "run", "--json")
    segments = json.loads(run.stdout)["patterns"][0]["segments"].values()
    budget = json.loads(invoke("budget", workload, "--out", tmp_path / "b", "--json").stdout)
    assert budget["microcode_bits"] == sum(segment["compressed_bits"] for segment in segments)
    assert budget["microcode_flat_bits"] == sum(segment["flat_bits"] for segment in segments)
    ratio = budget["microcode_flat_bits"] / budget["microcode_bits"]
    assert f"{ratio:.1f} times less" in run.stderr
    told = invoke("budget", workload, "--out", tmp_path / "b").stdout
    assert f"compressed {ratio:.1f} times, counted in the schedules' own microcode" in told
    assumed = invoke("budget", workload, "--estimate", "--out", tmp_path / "b").stdout
    assert "compressed 4 times, which is assumed" in assumed


def test_a_device_without_block_ram_is_drawn_too(workload: Path, tmp_path: Path) -> None:
    result = invoke("budget", workload, "--set", "resources.bram36=0", "--out", tmp_path)
    assert result.exit_code == 1, result.output
    assert (tmp_path / "budget.png").exists()


def test_every_report_of_a_run_echoes_its_parameters(workload: Path, tmp_path: Path) -> None:
    document = json.loads(invoke("run", workload, "--lanes", "2", "--out", tmp_path, "--json").stdout)
    rows = {row["key"]: row for row in document["assumptions"]}
    assert (rows["pl.lanes"]["value"], rows["pl.lanes"]["tag"]) == (2, "assumed")
    assert {key for key, row in rows.items() if row["used"] and not key.startswith("pl.latencies")} == {
        "pl.clock_mhz", "pl.lanes", "pl.dividers", "pl.banks", "pl.clusters", "pl.interleaved", "area.bram36_ceiling", "resources.bram36",
        "energy.add_f64_pj", "energy.mul_f64_pj", "energy.div_f64_pj", "energy.logic_f64_pj",
        "energy.bank_read_bit_pj", "energy.bank_write_bit_pj", "energy.microcode_bit_pj",
    }  # fmt: skip


def test_a_run_says_which_microcode_has_room_in_block_ram(workload: Path, tmp_path: Path) -> None:
    def memory(bram36: int) -> tuple[dict[str, Any], str]:
        settings = ("--set", f"resources.bram36={bram36}", "--set", "area.bram36_ceiling=0.5")
        done = invoke("run", workload, *settings, "--out", tmp_path, "--json")
        assert done.exit_code == 0, done.output
        return json.loads(done.stdout)["memory"][0], done.stderr

    found, _ = memory(1000)
    assert found["compressed"] < found["flat"]
    for form in ("flat", "compressed"):
        least = math.ceil(2 * (found["storage"] + found[form]))
        enough, said = memory(least)
        assert enough[f"{form}_fits"]
        assert f"{form} microcode {found[form]:g} FITS" in said
        short, said = memory(least - 1)
        assert not short[f"{form}_fits"]
        assert f"{form} microcode {found[form]:g} DOES NOT FIT" in said
        assert short["compressed_fits"] is (form == "flat")


def test_precision_needs_numbers_and_says_so_of_a_trace(workload: Path, tmp_path: Path) -> None:
    assert invoke("trace", workload, "--out", tmp_path).exit_code == 0
    (tmp_path / "pattern_0.json").unlink()
    result = invoke("precision", tmp_path / "recorded.json", "--out", tmp_path / "p")
    assert result.exit_code == 2
    assert "a trace holds no problem to solve again" in result.output
