"""The notebooks of examples/ run as they are, cell by cell, and give what their texts say."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import pytest

from docs.extensions.examples import NAMES, cells_of, run_cell

ROOT = Path(__file__).resolve().parents[2]
FOLDER = ROOT / "examples"
SAID = {
    "my_vehicle": ("Answer   VERIFIED", "Deadline PASS", "100% of the thrust", "110% of the thrust"),
    "solve_cones": ("SOLVED", "PRIMAL_INFEASIBLE", "the constraints cannot be met together"),
    "move_a_module": ("with the bits of the native solve: True", "resident"),
    "partition_experiment": ("of 14 choices are open",),
    "flight_code": ("the recorded bits", "| heap | 0 |"),
    "closed_loop": ("Answer   MET", "CHOSEN", "flown"),
}


def test_every_notebook_is_on_the_site_and_in_this_test() -> None:
    assert sorted(NAMES) == sorted(SAID) == sorted(path.stem for path in FOLDER.glob("*.py"))


@pytest.mark.parametrize("name", NAMES)
def test_a_notebook_runs(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    (tmp_path / "scenarios").symlink_to(ROOT / "scenarios")
    names: dict[str, Any] = {"__name__": "__main__"}
    outputs = [run_cell(cell.source, names) for cell in cells_of(FOLDER / f"{name}.py") if not cell.is_text]
    printed = "".join(output.printed for output in outputs)
    for words in SAID[name]:
        assert words in printed, printed
    assert all(output.printed or output.html or output.figures for output in outputs[1:]), (
        "a cell without a result"
    )


@pytest.mark.parametrize("name", NAMES)
def test_a_notebook_is_short_and_begins_with_its_question(name: str) -> None:
    path = FOLDER / f"{name}.py"
    first = next(cells_of(path))
    assert first.is_text
    assert first.source.startswith("# ")
    assert len(path.read_text(encoding="utf-8").splitlines()) <= 60
