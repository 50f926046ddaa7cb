"""What `orbsoc hw validate --solve --quick` prints is in the tables of docs/rtl.md: minutes, so only by `make long`."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
COMMANDS = ("--solve --quick", "--set pl.interleaved=4 --solve --quick")


def rows(text: str) -> list[list[str]]:
    """Cells of the lines of tables, rules and heads left out."""
    lines = [line for line in text.splitlines() if line.startswith("|") and re.search(r"\d", line)]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]


STATED = rows((ROOT / "docs" / "rtl.md").read_text(encoding="utf-8"))


@pytest.mark.parametrize("command", COMMANDS)
def test_each_row_that_is_printed_is_stated(command: str, tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "orbsoc", "hw", "validate", *command.split(), "--out", "run"],
        cwd=tmp_path, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    (table,) = (tmp_path / "run").glob("*.md")
    printed = rows(table.read_text(encoding="utf-8"))
    assert printed
    assert [row for row in printed if row not in STATED] == []


def test_a_number_that_changes_is_found() -> None:
    row = next(row for row in STATED if row[0].startswith("24 variables, cones 3 3 9, f64, 4 lanes, flat"))
    assert [*row[:-1], "+9.999 %"] not in STATED
