"""What `orbsoc hw validate` prints of solves and mutations is in the tables of docs/rtl.md: minutes, so only by `make long`."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
COMMANDS = ("--solve", "--set pl.interleaved=4 --solve", "--mutations")


def rows(text: str) -> list[list[str]]:
    """Cells of the lines of tables, rules and heads left out."""
    lines = [line for line in text.splitlines() if line.startswith("|") and re.search(r"\d", line)]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]


PAGE = (ROOT / "docs" / "rtl.md").read_text(encoding="utf-8")
STATED = rows(PAGE)


@pytest.mark.parametrize("command", COMMANDS)
def test_each_row_that_is_printed_is_stated(command: str, tmp_path: Path) -> None:
    for name in ("rtl", "scenarios"):
        (tmp_path / name).symlink_to(ROOT / name)
    done = subprocess.run(
        [sys.executable, "-m", "orbsoc", "hw", "validate", *command.split(), "--out", "run"],
        cwd=tmp_path, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    (table,) = (tmp_path / "run").glob("*.md")
    printed = rows(table.read_text(encoding="utf-8"))
    assert printed
    assert [row for row in printed if row not in STATED] == []


def test_what_microcode_costs_is_of_the_table() -> None:
    """Compressed beside flat, in the sentence below the table."""
    clocks = {row[0]: int(row[7]) for row in STATED if row[0].startswith("mission 004") and len(row) == 10}
    longer = [
        f"{100.0 * clocks[f'{name}, N = 12, f64, {lanes} lanes, compressed'] / clocks[f'{name}, N = 12, f64, {lanes} lanes, flat'] - 100.0:.1f} %"
        for name in ("mission 004 C", "mission 004")
        for lanes in (4, 2)
    ]
    sentence = PAGE[PAGE.index("Compressed microcode takes C's solve") :][:200]
    assert re.findall(r"\d\.\d %", sentence)[:4] == longer
