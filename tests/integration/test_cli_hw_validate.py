"""`orbsoc hw validate`'s tables and mutations: what they print, write and end with."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from orbsoc import rtl_mutations, rtl_validation
from orbsoc.cli import app
from orbsoc.rtl_mutations import MUTATIONS, Catch, Mutation, catches
from orbsoc.rtl_validation import RtlError, problems
from tests.rtl.verilator import require_verilator

RTL = Path(__file__).resolve().parents[2] / "rtl"
SMALLEST, SMALL = list(problems())[:2]


def test_the_schedules_of_a_problem_catch_a_longer_adder_and_pass_the_engine_as_it_is(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    require_verilator()
    name = "adder one cycle longer"
    monkeypatch.setattr(rtl_mutations, "MUTATIONS", {name: MUTATIONS[name]})
    as_it_is, longer = catches(RTL, SMALLEST, problems()[SMALLEST])
    assert (as_it_is.mutation, as_it_is.caught, as_it_is.good) == (None, False, True)
    assert (longer.mutation, longer.caught, longer.good) == (name, True, True)
    assert as_it_is.segments == longer.segments > 20


def test_a_mutation_whose_line_is_gone_is_refused(tmp_path: Path) -> None:
    with pytest.raises(RtlError, match="there 0 times"):
        Mutation("latency.svh", "F32_ADD_CYCLES = 99", "").apply(RTL, tmp_path)


@pytest.mark.parametrize(
    ("asserted", "signalled", "verdict", "code"),
    [(2, 0, "caught", 0), (0, 3, "caught", 0), (0, 0, "UNNOTICED", 1)],
)
def test_the_table_of_mutations_says_which_goes_unnoticed(
    asserted: int, signalled: int, verdict: str, code: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = [
        Catch(None, "flat", 25, 0, 0, 0, 0),
        Catch("banks swapped", "flat", 25, 0, 0, asserted, signalled),
    ]
    monkeypatch.setattr(rtl_mutations, "catches", lambda *_: iter(found))
    monkeypatch.setattr(rtl_validation.shutil, "which", lambda _: "/verilator")
    arguments = ["hw", "validate", "--mutations", "--rtl", str(RTL), "--out", str(tmp_path)]
    done = CliRunner().invoke(app, arguments)
    assert done.exit_code == code, done.output
    assert f"| banks swapped | flat | 25 | 0 | 0 | {asserted} | {signalled} | {verdict} |" in done.output
    document = json.loads((tmp_path / "rtl-mutations.json").read_text())
    assert [row["good"] for row in document["engines"]] == [True, code == 0]


def test_the_tables_are_those_of_both_problems_and_need_no_verilator(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    small: dict[bool, Any] = {free: problems()[SMALL if free else SMALLEST] for free in (True, False)}
    monkeypatch.setattr(rtl_validation, "mission_004", lambda _, free_perigee: small[free_perigee])
    monkeypatch.setattr(rtl_validation.shutil, "which", lambda _: None)
    arguments = ["hw", "validate", "--tables", "--rtl", str(RTL), "--out", str(tmp_path), "--json"]
    done = CliRunner().invoke(app, arguments)
    assert done.exit_code == 0, done.output
    document = json.loads((tmp_path / "pl-tables.json").read_text())
    assert {"mission 004 C, N = 12", "mission 004 A, N = 12"} < set(document)
    assert "| matrix scaling |" in (tmp_path / "pl-tables.md").read_text()


def test_tables_without_a_scenario_are_refused_by_its_path(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(rtl_validation, "mission_004", lambda *_, **__: None)
    done = CliRunner().invoke(app, ["hw", "validate", "--tables", "--rtl", str(RTL), "--out", str(tmp_path)])
    assert done.exit_code == 2
    assert "rec1.toml" in done.output
