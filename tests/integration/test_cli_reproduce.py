"""`orbsoc reproduce`: the Monte Carlo on request, and nothing lost by Ctrl-C."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from orbsoc.commands.app import app
from orbsoc.guidance.mission import BROKEN, PaperRow
from orbsoc.missions import registry
from tests.guidance import toy_mission

TOY = "tests.guidance.toy_mission"


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """What the toy mission is asked for, in order; it is the only mission, and its second draw is interrupted once."""
    calls: list[str] = []

    def drawn(name: str) -> tuple[PaperRow, ...]:
        calls.append(name)
        if calls.count("pulls") == 1 and name == "pulls":
            raise KeyboardInterrupt
        return (PaperRow(name, "", "not printed", f"{len(calls)}", "inferred", ""),)

    monkeypatch.setattr(registry, "MODULES", {"toy": TOY})
    monkeypatch.setattr(toy_mission, "drawn", drawn)
    return calls


def run(out: Path, *options: str) -> Result:
    arguments = ["reproduce", "toy", "--scenarios", str(out.parent), "--out", str(out), *options]
    return CliRunner().invoke(app, arguments)


def test_without_full_nothing_is_drawn(asked: list[str], tmp_path: Path) -> None:
    assert run(tmp_path / "out").exit_code == 0
    assert asked == []


def test_what_is_finished_is_not_computed_again(asked: list[str], tmp_path: Path) -> None:
    out = tmp_path / "out"
    cut = run(out, "--full")
    assert cut.exit_code == 130
    assert "--resume goes on" in cut.output
    assert "3 of 3: toy, pulls" in cut.output
    assert not (out / "reproduce.json").exists()
    assert run(out, "--full", "--resume").exit_code == 0
    assert asked == ["pushes", "pulls", "pulls"]
    rows = json.loads((out / "reproduce.json").read_text(encoding="utf-8"))["missions"]["toy"]
    assert [(row["quantity"], row["ours"]) for row in rows] == [("pushes", "1"), ("pulls", "3")]
    assert [path.name for path in sorted(out.iterdir())] == ["reproduce.json", "reproduce.md"]


@pytest.mark.parametrize("change", ["no --resume", "other scenarios"])
def test_parts_of_another_run_are_not_taken(asked: list[str], tmp_path: Path, change: str) -> None:
    out = tmp_path / "out"
    assert run(out, "--full").exit_code == 130
    if change == "other scenarios":
        (tmp_path / "new.toml").touch()
    assert run(out, "--full", *(["--resume"] if change == "other scenarios" else [])).exit_code == 0
    assert asked == ["pushes", "pulls", "pushes", "pulls"]


def test_a_draw_that_does_not_hold_is_exit_code_1(
    asked: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(toy_mission, "drawn", lambda name: (PaperRow(name, "", "", "", BROKEN, ""),))
    found = run(tmp_path / "out", "--full")
    assert found.exit_code == 1
    assert "does not hold as stated: pushes, pulls" in found.output
    assert asked == []
