"""docs/solver.md says what is true: its code runs in order, its tables are those of the code."""

from __future__ import annotations

import json
import re
import shlex
from pathlib import Path

import pytest
from typer.testing import CliRunner

import orbsoc
from orbsoc.commands.app import app

ROOT = Path(__file__).resolve().parents[2]
GUIDE = (ROOT / "docs" / "solver.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"^```(\w+)\n(.*?)^```$", GUIDE, flags=re.DOTALL | re.MULTILINE)


def rows(heading: str) -> list[list[str]]:
    """The cells of the table below a heading, header left out."""
    section = re.search(rf"^## {heading}\n(.*?)(?=^## )", GUIDE, flags=re.DOTALL | re.MULTILINE)
    assert section
    table = [line.strip("|").split("|") for line in section[1].splitlines() if line.startswith("|")]
    return [[cell.strip().strip("`") for cell in row] for row in table[2:]]


def test_every_block_runs_in_order(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    seen: set[str] = set()
    for language, code in BLOCKS:
        seen.add(language)
        if language == "python":
            exec(compile(code, "docs/solver.md", "exec"), names)
        elif language == "sh":
            for line in code.splitlines():
                program, *arguments = shlex.split(line)
                assert program == "orbsoc"
                result = CliRunner().invoke(app, arguments)
                assert result.exit_code == 0, result.output
        else:
            assert language == "json", language
            Path("block.json").write_text(json.dumps(json.loads(code)))
            assert orbsoc.solve(orbsoc.Problem.load("block.json")) is not None
    assert seen == {"python", "sh", "json"}
    assert GUIDE.count("```") == 2 * len(BLOCKS)


def test_the_table_of_statuses_is_complete() -> None:
    assert [row[0] for row in rows("Statuses")] == [status.name for status in orbsoc.Status]


def test_the_table_of_settings_has_every_field_with_its_default() -> None:
    printed = dict(line.split() for line in str(orbsoc.Settings()).splitlines())
    assert {row[0]: row[1] for row in rows("Settings")} == printed
