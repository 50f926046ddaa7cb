"""Upsets: bits of the RTL that are turned over in a solve, what the PS sees of them, and the command that counts them."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from orbsoc.commands.app import app
from orbsoc.hw.schedules import Engine
from orbsoc.rtl.flip_flops import PLACES
from orbsoc.rtl.upsets import CAUSES, OUTCOMES, UpsetStudy
from tests.integration.small_problem import small_problem
from tests.rtl.verilator import require_verilator

RTL = Path(__file__).parents[2] / "rtl"
LANES = 2


@pytest.fixture(scope="module")
def study() -> UpsetStudy:
    require_verilator()
    return UpsetStudy(RTL, small_problem(), engine=Engine(lanes=LANES, banks=16), parity=True)


@pytest.fixture(scope="module")
def workload(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("upsets") / "small.json"
    small_problem().save(path)
    return path


def drawn(study: UpsetStudy, register: str, monkeypatch: pytest.MonkeyPatch, bit: int = 0) -> str:
    """What comes of one chosen bit at clock 2000."""
    found = next(each for each in study.registers if f"{each.scope}.{each.name}".endswith(register))
    flip, _ = study.flip(1, 0)
    command = f"flip {found.scope} {found.name} {found.in_memory(bit)}"
    monkeypatch.setattr(study, "flip", lambda *_: (type(flip)(0, found.place, register, bit, 2000), command))
    (row,) = study.run(1, [0])
    assert (row.found_by in CAUSES) == (row.outcome == "right after retry")
    return f"{row.first}: {row.outcome}"


def test_every_place_has_registers_and_every_draw_can_be_repeated(study: UpsetStudy) -> None:
    assert {register.place for register in study.registers} == set(PLACES)
    assert [study.flip(3, k)[0].place for k in range(len(PLACES))] == list(PLACES)
    assert study.flip(3, 5) == study.flip(3, 5) != study.flip(4, 5)
    words = [register for register in study.registers if register.name == "words"]
    assert len(words) == 3 * 16  # three replicas of every bank
    assert all(register.width == 65 for register in words)


def test_a_fault_code_that_turns_up_is_seen_and_the_solve_is_repeated(
    study: UpsetStudy, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert drawn(study, "control.fault", monkeypatch) == "LaunchWhileBusy: right after retry"


def test_an_attempt_that_loses_its_way_ends_at_the_limit_and_is_repeated(
    study: UpsetStudy, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = drawn(study, "g_resident.sequencer.state", monkeypatch, bit=2)
    assert found == "LaunchTimeout: right after retry"


def test_flips_of_every_place_end_right(study: UpsetStudy) -> None:
    rows = list(study.run(7, range(2 * len(PLACES))))
    assert {row.outcome for row in rows} <= set(OUTCOMES) - {"silent", "reported"}


@pytest.mark.parametrize("place", ["storage", "microcode"])
def test_what_has_an_effect_in_a_memory_is_found_by_parity(study: UpsetStudy, place: str) -> None:
    at = list(PLACES).index(place)
    numbers = range(at, 12 * len(PLACES), len(PLACES))
    covered = [
        number for number in numbers if study.flip(7, number)[0].register.endswith((".words", ".code"))
    ]
    rows = list(study.run(7, covered))
    assert {(row.outcome, row.found_by) for row in rows} == {
        ("no effect", None),
        ("right after retry", "parity"),
    }


def test_the_command_counts_by_place_and_goes_on_where_it_was_stopped(
    study: UpsetStudy, workload: Path, tmp_path: Path
) -> None:
    def run(flips: int, *more: str, code: int = 0) -> str:
        arguments = [
            "hw",
            "upsets",
            str(workload),
            "--lanes",
            str(LANES),
            "--flips",
            str(flips),
            "--parity",
            "--json",
        ]
        done = CliRunner().invoke(app, [*arguments, "--out", str(tmp_path / "out"), *more])
        assert done.exit_code == code, done.output
        return done.stdout

    first = json.loads(run(3))
    assert [row["number"] for row in first["flips"]] == [0, 1, 2]
    assert "holds flips already" in run(5, code=2)
    rows = tmp_path / "out" / "upsets.jsonl"
    rows.write_text(rows.read_text()[:-20])  # as a kill leaves it
    after = json.loads(run(5, "--resume"))
    assert after["flips"][:3] == first["flips"]
    assert len(after["flips"]) == 5
    assert sum(sum(counts.values()) for counts in after["by_place"].values()) == 5
    assert after["parity"] is True
    assert "another problem, engine, seed" in run(5, "--resume", "--seed", "2", code=2)
    assert "--flips = 0" in run(0, code=2)
    assert study.clocks == after["clean"]["clocks"]
