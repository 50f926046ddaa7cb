"""`orbsoc hw validate`'s tables and mutations: what they print, write and end with."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from orbsoc.commands.app import app
from orbsoc.conic.settings import Settings
from orbsoc.hw.schedules import EngineError, scheduled
from orbsoc.rtl import mutations as rtl_mutations
from orbsoc.rtl import validation as rtl_validation
from orbsoc.rtl.mutations import CHECK_MUTATIONS, ENGINE, MODEL_MUTATIONS, MUTATIONS, Catch, Mutation, catches
from orbsoc.rtl.validation import RtlError, problems
from tests.rtl.verilator import require_verilator

RTL = Path(__file__).resolve().parents[2] / "rtl"
SMALLEST, SMALL = list(problems())[:2]


def test_a_problem_catches_what_is_wrong_in_rtl_checks_and_scheduler_and_passes_what_is_right(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Every mutation of the scheduler, and one of the RTL and of its checks; the others are in tests/rtl."""
    require_verilator()
    longer, unchecked = "adder one cycle longer", "checks left out"
    monkeypatch.setattr(rtl_mutations, "MUTATIONS", {longer: MUTATIONS[longer]})
    monkeypatch.setattr(rtl_mutations, "CHECK_MUTATIONS", {unchecked: CHECK_MUTATIONS[unchecked]})
    found = {catch.mutation: catch for catch in catches(RTL, SMALL, problems()[SMALL])}
    assert list(found) == [None, longer, unchecked, *MODEL_MUTATIONS]
    assert all(catch.good for catch in found.values()), found
    assert [mutation for mutation, catch in found.items() if not catch.caught] == [None]
    assert {catch.segments for catch in found.values()} == {25}
    assert (found[unchecked].silent, found[unchecked].asserted) == (8, 0)
    assert all(catch.silent == 0 for mutation, catch in found.items() if mutation != unchecked)


@pytest.mark.parametrize("misread", [("lanes", 1), ("add", -7), ("div", 1000)])
def test_a_scheduler_cannot_misread_what_no_engine_has(misread: tuple[str, int]) -> None:
    with pytest.raises(
        EngineError,
        match=r"allowed is (add, mul, div, sqrt, div_interval, sqrt_interval or simple|1 to 50 cycles)",
    ):
        scheduled(problems()[SMALLEST], Settings(), ENGINE, misread=misread)


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
        Catch(None, "none", "flat", 25, 0, 0, 0, 0, 0),
        Catch("banks swapped", "RTL", "flat", 25, 0, 0, asserted, signalled, 0),
    ]
    monkeypatch.setattr(rtl_mutations, "catches", lambda *_: iter(found))
    monkeypatch.setattr(rtl_validation.shutil, "which", lambda _: "/verilator")
    arguments = ["hw", "validate", "--mutations", "--rtl", str(RTL), "--out", str(tmp_path)]
    done = CliRunner().invoke(app, arguments)
    assert done.exit_code == code, done.output
    assert (
        f"| banks swapped | RTL | flat | 25 | 0 | 0 | {asserted} | {signalled} | 0 | {verdict} |"
        in done.output
    )
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
    assert (tmp_path / "pl-utilisation.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--tables", "--mutations"], "--tables and --mutations are runs of their own"),
        (["--mutations", "--solve", "--quick"], "--mutations and --solve are runs of their own"),
        (["--mutations", "--quick"], "--quick chooses points for the RTL, and --mutations has none"),
    ],
)
def test_an_option_that_would_be_ignored_is_refused(arguments: list[str], words: str, tmp_path: Path) -> None:
    done = CliRunner().invoke(app, ["hw", "validate", *arguments, "--out", str(tmp_path / "out")])
    assert done.exit_code == 2, done.output
    assert words in " ".join(done.output.split())
    assert not (tmp_path / "out").exists()


def test_an_installed_package_finds_the_rtl_of_the_tree_it_is_called_in(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(
        rtl_validation, "__file__", str(tmp_path / "site" / "orbsoc" / "rtl" / "validation.py")
    )
    monkeypatch.chdir(RTL.parent)
    assert rtl_validation.rtl_sources(None) == RTL
    monkeypatch.chdir(tmp_path)
    with pytest.raises(
        RtlError, match=f"{tmp_path / 'rtl'}: no RTL there; run from the top of a source tree"
    ):
        rtl_validation.rtl_sources(None)


@pytest.mark.parametrize("run", [[], ["--solve"], ["--mutations"]])
def test_a_folder_that_cannot_be_written_ends_a_run_before_it_begins(
    run: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(rtl_validation.shutil, "which", lambda _: "/verilator")
    monkeypatch.setattr(rtl_validation.subprocess, "run", lambda *_, **__: pytest.fail("it began"))
    (tmp_path / "file").touch()
    done = CliRunner().invoke(
        app, ["hw", "validate", *run, "--rtl", str(RTL), "--out", str(tmp_path / "file" / "out")]
    )
    assert done.exit_code == 2, done.output
    assert "file" in done.output


def test_what_ran_before_an_interrupt_is_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(*_: Any, **__: Any) -> Iterator[list[Any]]:
        yield []
        raise KeyboardInterrupt

    monkeypatch.setattr(rtl_validation, "validate", interrupted)
    monkeypatch.setattr(rtl_validation.shutil, "which", lambda _: "/verilator")
    arguments = ["hw", "validate", "--quick", "--rtl", str(RTL), "--out", str(tmp_path)]
    assert CliRunner().invoke(app, arguments).exit_code == 130
    points = json.loads((tmp_path / "validation.json").read_text())["points"]
    assert points["done"] == 1 < points["of"]


@pytest.mark.parametrize("option", [["--tables"], [], ["--quick"], ["--solve", "--quick"]])
def test_an_rtl_folder_without_scenarios_beside_it_is_refused_by_their_path(
    option: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """And nothing takes the place of mission 004's problem."""
    monkeypatch.setattr(rtl_validation.shutil, "which", lambda _: "/verilator")
    rtl = tmp_path / "rtl"
    rtl.mkdir()
    (rtl / "build.sh").touch()
    arguments = ["hw", "validate", *option, "--rtl", str(rtl), "--out", str(tmp_path / "out")]
    done = CliRunner().invoke(app, arguments)
    assert done.exit_code == 2, done.output
    assert f"{tmp_path / 'scenarios' / 'rec1.toml'}: no scenario there" in done.output
    assert not (tmp_path / "out").exists()
