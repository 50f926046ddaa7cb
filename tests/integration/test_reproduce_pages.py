"""The pages `docs/reproduce-NNN.md` and `docs/accuracy.md` are what `orbsoc reproduce NNN` and `accuracy` write."""

from __future__ import annotations

from pathlib import Path

import pytest
from typer.testing import CliRunner

from orbsoc.commands.app import app
from tests.printed import shows

ROOT = Path(__file__).resolve().parents[2]
RELATIVE = 1e-9
"""Between processors; what is shown with fewer digits, to a unit of the last."""
PAGES = [*sorted((ROOT / "docs").glob("reproduce-*.md")), ROOT / "docs" / "accuracy.md"]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_a_page_is_what_the_command_writes(page: Path, tmp_path: Path) -> None:
    number = page.stem.removeprefix("reproduce-")
    arguments = ["reproduce", number, "--scenarios", str(ROOT / "scenarios"), "--out", str(tmp_path / "out")]
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == 0, result.output
    pages = (page, tmp_path / "out" / "reproduce.md")
    shown, written = (each.read_text(encoding="utf-8").splitlines() for each in pages)
    assert len(shown) == len(written)
    for line, found in zip(shown, written, strict=True):
        assert line == found or shows(line, found, RELATIVE), (line, found)


def test_there_are_pages() -> None:
    assert PAGES
