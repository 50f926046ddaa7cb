"""`orbsoc plan … --cases`: the verdict over dispersed cases, and going on where it stopped."""

from __future__ import annotations

import csv
import gzip
import json
import shutil
from collections import OrderedDict
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner, Result

import orbsoc.hw.deadlines as study
from hw_model import load_partition, load_platform, speedup
from hw_model.platform.platform_toml import to_toml
from hw_model.report.run import simulate
from orbsoc import Problem, PsScheduler
from orbsoc.commands.app import app
from orbsoc.conic.pattern import pattern_digest
from orbsoc.hw import schedules as pl_program
from orbsoc.hw.exact_cycles import exact_cycles
from orbsoc.hw.outer_loop import with_outer_loop
from orbsoc.missions.reachable_insertion import disperse, load_scenario, outer_loop, plan

REC1 = Path(__file__).resolve().parents[2] / "scenarios" / "rec1.toml"
ZU9EG, PAPER = load_platform("zu9eg"), load_partition("paper")


def invoke(*arguments: str | Path) -> Result:
    return CliRunner().invoke(app, ["plan", str(REC1), *map(str, arguments)])


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[study.Case]]:
    """Four cases, planned once for all tests."""
    folder = tmp_path_factory.mktemp("recorded") / "cases"
    return folder, study.record_cases(load_scenario(REC1), 4, 0, folder, resume=False)


def test_the_study_writes_its_verdict_and_a_row_per_case(tmp_path: Path) -> None:
    result = invoke("--cases", 3, "--deadline-ms", 1000, "--out", tmp_path, "--json")
    assert result.exit_code == 0, result.output
    document = json.loads(result.stdout)
    assert document["verdict"] == "PASS"
    assert "binding is " in document["headline"]
    assert "modelled" in document["headline"]
    assert document["margin_ms"] == pytest.approx(1000 - document["worst_ms"]["max"])
    assert document["dispersion"]["tag"] == "assumed"
    with (tmp_path / "deadline.csv").open() as file:
        assert [row["case"] for row in csv.DictReader(file)] == ["0", "1", "2"]
    assert {path.name for path in tmp_path.iterdir()} == {
        "cases",
        "deadline.csv",
        "deadline.json",
        "deadline.png",
    }
    missed = invoke("--cases", 3, "--deadline-ms", 1, "--out", tmp_path, "--resume")
    assert missed.exit_code == 1
    assert "FAIL" in missed.stdout


def test_a_priced_case_is_what_its_own_report_says(recorded: tuple[Path, list[study.Case]]) -> None:
    cases = recorded[1]
    found = study.judge(cases, ZU9EG, PAPER, 50.0)
    for case, priced in zip(cases, found.cases, strict=True):
        report = speedup(case.trace, ZU9EG, PAPER)
        assert priced.time_ms == report.makespan_ms.nominal
        assert len(report.prices) == 2
        assert priced.fast_ms == min(found.makespan_ms.low for found in report.prices)
        assert priced.worst_ms == max(found.worst_case_ms for found in report.prices)
        assert priced.ipm_iterations == sum(solve["iterations"] for solve in case.trace["solves"])


def test_cases_are_judged_by_schedules_and_their_pattern_is_scheduled_once(
    recorded: tuple[Path, list[study.Case]], monkeypatch: pytest.MonkeyPatch
) -> None:
    folder, cases = recorded
    made: list[str] = []
    schedule = pl_program.scheduled

    def counted(*arguments: Any, **named: Any) -> pl_program.PlProgram:
        made.append(pattern_digest(arguments[0]).hex()[:16])
        return schedule(*arguments, **named)

    monkeypatch.setattr(pl_program, "scheduled", counted)
    monkeypatch.setattr(pl_program, "_programs", OrderedDict())
    found = study.judge(cases, ZU9EG, PAPER, 50.0, study.exact_cycles_of(cases, folder))
    assert made == list(cases[0].patterns) == [path.stem[8:] for path in folder.glob("pattern-*.json")]
    scheduler, scenario = PsScheduler(), disperse(load_scenario(REC1), 0, 0)
    found_plan = plan(scenario, solve=scheduler)
    trace = with_outer_loop(scheduler.trace, outer_loop(scenario, found_plan))
    report = speedup(trace, ZU9EG, PAPER, cycles=exact_cycles(scheduler.patterns))
    assert (found.cases[0].time_ms, found.cases[0].worst_ms) == (
        report.makespan_ms.nominal, max(price.worst_case_ms for price in report.prices),
    )  # fmt: skip
    assert found.cases[0].time_ms != study.judge(cases, ZU9EG, PAPER, 50.0).cases[0].time_ms
    assert "exact PL cycles" in found.headline
    assert "estimated PL cycles" in study.judge(cases, ZU9EG, PAPER, 50.0).headline


def test_a_verdict_says_whether_the_engine_fits(
    recorded: tuple[Path, list[study.Case]], tmp_path: Path
) -> None:
    folder, cases = recorded
    small = study.judge(cases, load_platform("xc7z020"), PAPER, 1e6, study.exact_cycles_of(cases, folder))
    assert small.margin_ms is not None
    assert small.margin_ms > 0.0
    assert (small.verdict, small.fits) == ("FAIL", False)
    assert "the engine does NOT FIT: bram36 at " in small.headline
    large = study.judge(cases, ZU9EG, PAPER, 1e6, study.exact_cycles_of(cases, folder))
    assert large.fits
    assert "the engine fits, bram36 at " in large.headline
    shutil.copytree(folder, tmp_path / "cases")
    device = ("--device", "xc7z020", "--resume", "--out", tmp_path)
    assert invoke("--cases", 4, "--deadline-ms", 1e6, *device).exit_code == 1
    assert invoke("--cases", 4, "--deadline-ms", 1e6, *device, "--partition", "all_ps").exit_code == 0


def test_a_pattern_that_was_deleted_is_named(recorded: tuple[Path, list[study.Case]], tmp_path: Path) -> None:
    with pytest.raises(study.CaseError, match=r"pattern-[0-9a-f]{16}\.json.*ask for --estimate"):
        study.exact_cycles_of(recorded[1], tmp_path)


def test_the_verdict_is_that_of_the_worst_case(recorded: tuple[Path, list[study.Case]]) -> None:
    cases = recorded[1]

    def verdict(deadline_ms: float, cases: list[study.Case] = cases) -> str:
        return study.judge(cases, ZU9EG, PAPER, deadline_ms).verdict

    rows = study.judge(cases, ZU9EG, PAPER, 50.0).cases
    worst, fastest = max(row.worst_ms for row in rows), max(row.fast_ms for row in rows)
    assert [verdict(time) for time in (worst, worst * 0.999, fastest, fastest * 0.999)] == [
        "PASS", "MARGINAL", "MARGINAL", "FAIL",
    ]  # fmt: skip
    lost = [*cases[:-1], replace(cases[-1], status="infeasible")]
    assert verdict(1e6, lost) == "FAIL"  # a case without a plan meets no deadline


def test_a_study_goes_on_where_it_stopped(
    recorded: tuple[Path, list[study.Case]], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder, cases = recorded
    half = tmp_path / "cases"
    half.mkdir()
    for name in ("case-0000.json.gz", "case-0002.json.gz"):
        (half / name).write_bytes((folder / name).read_bytes())
    planned: list[int] = []
    plan_one = study._plan

    def counted(scenario: object, number: int, seed: int) -> tuple[study.Case, tuple[Problem, ...]]:
        planned.append(number)
        return plan_one(scenario, number, seed)

    monkeypatch.setattr(study, "_plan", counted)
    resumed = study.record_cases(load_scenario(REC1), 4, 0, half, resume=True)
    assert planned == [1, 3]
    assert [case.ipm_iterations for case in resumed] == [case.ipm_iterations for case in cases]
    assert [case.patterns for case in resumed] == [case.patterns for case in cases]
    assert [case.trace for case in resumed] == [json.loads(json.dumps(case.trace)) for case in cases]


def test_what_was_planned_survives_an_interruption(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    plan_one = study._plan

    def stopped(scenario: object, number: int, seed: int) -> tuple[study.Case, tuple[Problem, ...]]:
        if number == 1:
            raise KeyboardInterrupt
        return plan_one(scenario, number, seed)

    monkeypatch.setattr(study, "_plan", stopped)
    result = invoke("--cases", 3, "--deadline-ms", 50, "--out", tmp_path)
    assert result.exit_code == 130
    assert "--resume goes on" in result.output
    left = {path.name.partition("-")[0] for path in (tmp_path / "cases").iterdir()}
    assert left == {"case", "pattern"}
    assert [path.name for path in (tmp_path / "cases").glob("case-*")] == ["case-0000.json.gz"]


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (b"not gzip", "not a recorded case"),
        (gzip.compress(b"{}", mtime=0), "not a recorded case"),
        (gzip.compress(b'{"study": "x", "schema": "orbsoc.case/9"}', mtime=0), "another schema"),
        (
            gzip.compress(
                b'{"study": "x", "schema": "orbsoc.case/3", "number": 0, "status": "verified", "scp_iterations": 1,'
                b' "ipm_iterations": [1], "trace": {}, "patterns": []}',
                mtime=0,
            ),
            "recorded for another scenario, seed or version",
        ),
    ],
)
def test_a_foreign_or_damaged_record_is_refused_by_name(tmp_path: Path, content: bytes, says: str) -> None:
    (tmp_path / "cases").mkdir()
    (tmp_path / "cases" / "case-0000.json.gz").write_bytes(content)
    result = invoke("--cases", 1, "--deadline-ms", 50, "--out", tmp_path, "--resume")
    assert result.exit_code == 2
    assert says in result.output
    assert "case-0000.json.gz" in result.output


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("--cases", 0, "--deadline-ms", 50), "--cases = 0: must be at least 1"),
        (("--cases", 1), "give --deadline-ms"),
        (
            ("--cases", 1, "--deadline-ms", 50, "--device", "{vendor}"),
            "`pl.latency_preset` = 'vendor_ip': schedules are made with the latencies of 'orbsoc_rtl' only",
        ),
        (("--cases", 1, "--deadline-ms", -5), "--deadline-ms = -5.0: must be a positive number"),
        (("--cases", 1, "--deadline-ms", 50, "--device", "zu1"), "platform 'zu1' is not known"),
        (("--cases", 2, "--deadline-ms", 50, "--seed", -1), "seed = -1: must be 0 or more"),
    ],
)
def test_bad_input_exits_2(tmp_path: Path, arguments: tuple[object, ...], says: str) -> None:
    vendor = tmp_path / "vendor.toml"
    vendor.write_text(to_toml(ZU9EG.with_value("pl.latency_preset", "vendor_ip")), encoding="utf-8")
    filled = [str(argument).format(vendor=vendor) for argument in arguments]
    result = invoke(*filled, "--out", tmp_path / "out")
    assert result.exit_code == 2, result.output
    assert says in result.output
    assert not list(tmp_path.glob("out/*.*"))


def test_a_study_without_a_verified_plan_has_no_margin(recorded: tuple[Path, list[study.Case]]) -> None:
    lost = [replace(case, status="not converged") for case in recorded[1]]
    found = study.judge(lost, ZU9EG, PAPER, 1e6)
    assert found.verdict == "FAIL"
    assert (found.margin_ms, found.nominal_margin_ms, found.binding_cause) == (None, None, None)
    assert "no verified plan to hold against 1e+06 ms, no margin; 4 without a verified plan" in found.headline
    # One of them lost: the verdict fails, the margin is that of the others.
    found = study.judge([*lost[:1], *recorded[1][1:]], ZU9EG, PAPER, 1e6)
    assert found.verdict == "FAIL"
    assert found.margin_ms == 1e6 - max(case.worst_ms for case in found.cases[1:])


def test_what_binds_is_the_longest_plans_critical_path(recorded: tuple[Path, list[study.Case]]) -> None:
    platform = ZU9EG.with_values({"runtime.schedule": "overlapped", "runtime.cores_used": 2})
    found = study.judge(recorded[1], platform, PAPER, 50.0)
    longest = max(range(4), key=lambda k: found.cases[k].worst_ms)
    timeline = simulate(recorded[1][longest].trace, platform, PAPER)
    shares = {
        cause: picoseconds / timeline.makespan_picoseconds
        for (cause,), picoseconds in timeline.totals("cause").items()
    }
    assert found.binding_cause == max(shares, key=lambda cause: shares[cause])
    assert found.binding_share == pytest.approx(max(shares.values()))
