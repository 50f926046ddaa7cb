"""`pl.interleaved` on the command line: what prints several problems in one stream, and what refuses them in words."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner, Result

from hw_model import load_platform
from hw_model.platform.platform_toml import to_toml
from orbsoc import Cones, Problem
from orbsoc.commands.app import app
from orbsoc.hw.schedules import Engine
from orbsoc.rtl import group_cases
from orbsoc.rtl import validation as rtl_validation
from orbsoc.rtl.group import GroupOutcome
from orbsoc.rtl.solve import Launch
from tests.integration.small_problem import small_problem

RESIDENT = ("--partition", "resident")
ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def workload(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("interleaved") / "small.json"
    small_problem().save(path)
    return path


@pytest.fixture(scope="module")
def device(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A platform file that interleaves four problems."""
    path = tmp_path_factory.mktemp("device") / "four.toml"
    path.write_text(to_toml(load_platform("zu9eg").with_value("pl.interleaved", 4)), encoding="utf-8")
    return path


def invoke(*arguments: str | Path) -> Result:
    return CliRunner().invoke(app, ["hw", *map(str, arguments)])


def document(*arguments: str | Path, code: int = 0) -> dict[str, Any]:
    done = invoke(*arguments, "--json")
    assert done.exit_code == code, done.output
    found: dict[str, Any] = json.loads(done.stdout)
    return found


def refusal(*arguments: str | Path) -> str:
    return str(document(*arguments, code=2)["error"])


def test_trace_prints_the_throughput_of_groups_beside_the_timeline_of_one(
    workload: Path, device: Path, tmp_path: Path
) -> None:
    one = document("trace", workload, *RESIDENT, "--out", tmp_path / "one")
    four = document("trace", workload, *RESIDENT, "--set", "pl.interleaved=4", "--out", tmp_path / "four")
    assert [row["interleaved"] for row in four["throughput"]] == [4, 4, 4]
    assert [row["interleaved"] for row in one["throughput"]] == [1, 1, 1]
    for row, alone in zip(four["throughput"], one["throughput"], strict=True):
        assert row["most_per_s"] > alone["most_per_s"]
        assert row["buffer_words"] == 4 * alone["buffer_words"]
    events = [
        json.loads((tmp_path / name / "trace.json").read_text())["traceEvents"] for name in ("one", "four")
    ]
    assert events[0] == events[1]
    by_file = document("trace", workload, *RESIDENT, "--device", device, "--out", tmp_path / "file")
    assert by_file["throughput"] == four["throughput"]
    said = invoke("trace", workload, *RESIDENT, "--device", device, "--out", tmp_path / "file").stdout
    assert "the same solve in 4 independent runs of the workload, which need the same iterations" in said
    assert "with 2 of 4 interleaved in flight" in said


def test_trace_says_that_solves_are_taken_as_independent(workload: Path, tmp_path: Path) -> None:
    """A record of two solves, priced in groups of two."""
    assert invoke("trace", workload, *RESIDENT, "--out", tmp_path / "one").exit_code == 0
    recorded = tmp_path / "one" / "recorded.json"
    record = json.loads(recorded.read_text())
    recorded.write_text(json.dumps(record | {"solves": 2 * record["solves"]}))
    done = invoke("trace", recorded, *RESIDENT, "--set", "pl.interleaved=2", "--out", tmp_path / "two")
    assert done.exit_code == 0, done.output
    assert "groups of 2 solves of a pattern as they follow, taken as independent problems" in done.stdout


def test_budget_has_the_words_of_all_until_they_do_not_fit(workload: Path, tmp_path: Path) -> None:
    one = document("budget", workload, *RESIDENT, "--out", tmp_path)
    four = document("budget", workload, *RESIDENT, "--set", "pl.interleaved=4", "--out", tmp_path)
    assert four["storage_words"] == pytest.approx(4 * one["storage_words"], abs=4)
    assert one["microcode_bits"] < four["microcode_bits"] < 5 * one["microcode_bits"]
    few = ("--set", "resources.bram36=150")
    assert invoke("budget", workload, *RESIDENT, *few, "--out", tmp_path).exit_code == 0
    most = invoke("budget", workload, *RESIDENT, *few, "--set", "pl.interleaved=8", "--out", tmp_path)
    assert most.exit_code == 1, most.output
    assert "DOES NOT FIT; tightest is bram36" in most.stdout
    assert "the buffers of 8 interleaved problems" in most.stdout


def test_run_lists_segments_that_work_on_several_problems(workload: Path, tmp_path: Path) -> None:
    one = document("run", workload, "--out", tmp_path)
    four = document("run", workload, "--set", "pl.interleaved=4", "--out", tmp_path)
    (alone,), (together,) = one["patterns"], four["patterns"]
    assert (alone["interleaved"], together["interleaved"]) == (1, 4)
    picojoules = load_platform("zu9eg").energy.microcode_bit_pj.value
    for name, segment in alone["segments"].items():
        several = together["segments"][name]
        # Products are taken off sums, two operations for one, where lanes would wait for the chain: they wait less now.
        assert 2 * segment["operations"] < several["operations"] <= 4 * segment["operations"] + 100
        assert segment["cycles"] < several["cycles"] < 4 * segment["cycles"]
        fetch, all_fetch = (1e-3 * picojoules * each["flat_bits"] for each in (segment, several))
        energy, all_energy = (found["energy_nj"][0][name]["energy_nj"] for found in (one, four))
        assert all_energy - all_fetch == pytest.approx(4 * (energy - fetch), rel=1e-9)
    assert "4 problems interleaved in every segment" in invoke(
        "run", workload, "--set", "pl.interleaved=4", "--out", tmp_path
    ).stdout  # fmt: skip


def test_an_engine_whose_storage_does_not_hold_all_is_refused(tmp_path: Path) -> None:
    """2^20 words are the most that an engine of rtl/ addresses."""
    wide = Problem(c=[1.0] * 20, G=[[-1.0] * 20] * 400, h=[1.0] * 400, cones=Cones(l=400))
    wide.save(tmp_path / "wide.json")
    said = refusal("run", tmp_path / "wide.json", "--set", "pl.interleaved=1024", "--out", tmp_path)
    assert "`address_bits`" in said
    assert "the engine has 1048576" in said


ONE = "this report is of one problem after the other"


@pytest.mark.parametrize("value", [1, 4])
@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("trace", "{w}"), "only the PL's own control runs several problems in one stream"),
        (("budget", "{w}"), "only the PL's own control runs several problems in one stream"),
        (("budget", "{w}", "--partition", "all_ps"), "the partition leaves the PL idle"),
        (("budget", "{w}", "--partition", "resident", "--estimate"), "the estimate knows no interleaved problems"),
        (("partition", "{w}", "--device", "zu9eg"), ONE),
        (("precision", "{w}"), ONE),
        (("design", "{w}"), ONE),
    ],
    ids=lambda given: " ".join(given).replace("{w} ", "") if isinstance(given, tuple) else "",
)  # fmt: skip
def test_what_has_no_use_for_several_problems_refuses_the_key(
    workload: Path, tmp_path: Path, arguments: tuple[str, ...], says: str, value: int
) -> None:
    filled = [item.format(w=workload) for item in arguments]
    few = (
        ("--lanes", "2", "--dividers", "1", "--banks", "16", "--clusters", "1")
        if "design" in arguments
        else ()
    )
    said = refusal(*filled, *few, "--set", f"pl.interleaved={value}", "--out", tmp_path / "out")
    assert f"`pl.interleaved` = {value}" in said
    assert says in said


def test_explain_and_sweep_refuse_it_too(workload: Path, tmp_path: Path) -> None:
    said = refusal(
        "explain", workload, "zu9eg:resident", "zu9eg:resident:pl.interleaved=2", "--out", tmp_path
    )
    assert ONE in said
    axes = tmp_path / "sweep.toml"
    axes.write_text("[axes]\n'pl.interleaved' = [1, 2]\npartition = ['resident']\n", encoding="utf-8")
    assert ONE in refusal("sweep", axes, workload, "--out", tmp_path / "out")


@pytest.mark.parametrize("value", ["0", "1025", "2.0", "two"])
def test_a_value_that_no_group_has_is_refused(workload: Path, tmp_path: Path, value: str) -> None:
    said = refusal("run", workload, "--set", f"pl.interleaved={value}", "--out", tmp_path)
    assert "pl.interleaved" in said


def test_a_plan_on_a_device_that_interleaves_is_refused_before_it_is_made(
    device: Path, tmp_path: Path
) -> None:
    arguments = [
        "plan",
        str(ROOT / "scenarios" / "rec1.toml"),
        "--device",
        str(device),
        "--out",
        str(tmp_path / "out"),
    ]
    done = CliRunner().invoke(app, arguments)
    assert done.exit_code == 2, done.output
    assert ONE in " ".join(done.output.split())
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (
            ("--set", "pl.lanes=8"),
            "`pl.lanes` = 8 would do nothing here: the points have engines of their own",
        ),
        (("--tables", "--set", "pl.interleaved=2"), "--tables has no points to interleave"),
        (("--mutations", "--set", "pl.interleaved=2"), "--mutations has no points to interleave"),
        (("--set", "pl.interleaved=0"), "pl.interleaved"),
        (("--tables", "--set", "pl.storage_depth=exact"), "--tables has no points with other banks"),
        (("--set", "pl.storage_depth=deep"), "pl.storage_depth"),
    ],
)
def test_validate_takes_few_keys_and_each_where_it_counts(
    arguments: tuple[str, ...], says: str, tmp_path: Path
) -> None:
    assert says in refusal("validate", *arguments, "--out", tmp_path / "out")


def test_validate_runs_its_points_on_as_many_problems(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked, depths = list[Any](), list[bool]()
    monkeypatch.setattr(
        rtl_validation,
        "validate",
        lambda _, points, *__, **how: asked.extend(points) or depths.append(how["exact_depth"]) or iter(()),
    )
    monkeypatch.setattr(rtl_validation.shutil, "which", lambda _: "/verilator")
    arguments = ["validate", "--quick", "--set", "pl.interleaved=3", "--rtl", ROOT / "rtl", "--out", tmp_path]
    assert invoke(*arguments).exit_code == 1  # no point was run
    assert {point.interleaved for point in asked} == {3}
    assert {point.engine.address_bits for point in asked} == {17}
    assert invoke(*arguments, "--set", "pl.storage_depth=exact").exit_code == 1
    assert depths == [False, True]


def test_validate_solves_groups_and_writes_what_they_came_to(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    good = GroupOutcome(
        "small", Engine(), "flat", ("SOLVED", "SOLVED"), (8, 9), (Launch("unscale", 40, 40),), 258, 0, True, {}, 0, 50, 48
    )  # fmt: skip
    bad = GroupOutcome(
        "small", Engine(), "flat", ("SOLVED", "SOLVED"), (8, 9), (Launch("unscale", 41, 40),), 258, 0, True, {}, 0, 50, 48
    )  # fmt: skip
    monkeypatch.setattr(rtl_validation.shutil, "which", lambda _: "/verilator")
    arguments = (
        "validate",
        "--solve",
        "--quick",
        "--set",
        "pl.interleaved=2",
        "--rtl",
        ROOT / "rtl",
        "--out",
        tmp_path,
    )
    for outcomes, code in (([good], 0), ([good, bad], 1)):
        monkeypatch.setattr(group_cases, "run_groups", lambda *_, found=outcomes: iter(found))
        found = document(*arguments, code=code)
        assert (found["schema"], found["equal"], found["interleaved"]) == (
            "orbsoc.rtl-groups/1",
            code == 0,
            2,
        )
        assert (
            "| 2 × small, f64, 4 lanes, clusters 1, flat | 8, 9 | 258 | 0 |"
            in (tmp_path / "rtl-groups.md").read_text()
        )
    assert len(found["groups"]) == 2
