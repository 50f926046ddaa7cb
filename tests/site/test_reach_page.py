"""What `docs/reach.md` says of the grid with three solvers is the record of that run, and its grid is that of the sweep."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from typer.testing import CliRunner

from orbsoc.commands.app import app
from tests.printed import near
from tests.site.stated import text_of

ROOT = Path(__file__).resolve().parents[2]
TEXT = text_of("reach.md")
RECORD = json.loads((ROOT / "docs" / "reach-benchmark.json").read_text(encoding="utf-8"))
ORBSOC, INTERIOR, CLARABEL = (
    RECORD["cpu_s"][name][0] for name in ("orbsoc", "orbsoc_interior_point", "clarabel")
)
NUMBER = r"(\d+(?:\.\d+)?(?:e-?\d+)?)"


def numbers(line: str) -> list[str]:
    """Where a line of the page has `#`."""
    [found] = re.findall(NUMBER.join(map(re.escape, line.split("#"))), TEXT)
    return [found] if isinstance(found, str) else list(found)


@pytest.mark.parametrize(
    ("line", "values"),
    [
        ("Clarabel takes # times orbsoc's processor time (# s and # s, one turn", [CLARABEL / ORBSOC, CLARABEL, ORBSOC]),
        ("interior-point method for every subproblem # times (# s); a within #e-8", [CLARABEL / INTERIOR, INTERIOR, 1e8 * RECORD["largest_difference_of_a_rel"]]),
        ("Of orbsoc's # s, # s are spent in the subproblems (# #), # of Clarabel's # s",
         [ORBSOC, RECORD["in_the_solver_cpu_s"]["orbsoc"], RECORD["subproblems"]["orbsoc"] // 1000, 300.0,
          RECORD["in_the_solver_cpu_s"]["clarabel"], CLARABEL]),
        ("all # # points | # # reached", [33, 825, RECORD["reached"] // 1000, RECORD["reached"] % 1000]),
    ],
)  # fmt: skip
def test_the_page_is_the_record(line: str, values: list[float]) -> None:
    shown = numbers(line)
    assert all(near(one, f"{value:.9g}", 1e-9) for one, value in zip(shown, values, strict=True)), shown


def test_a_sweep_of_the_papers_grid_reaches_what_the_page_says(tmp_path: Path) -> None:
    out = tmp_path / "reach"
    command = ["reach", str(ROOT / "scenarios" / "paper004_reach.toml"), "--no-report", "--out", str(out)]
    result = CliRunner().invoke(app, command)
    assert result.exit_code == 0, result.output
    counts = json.loads((out / "summary.json").read_text(encoding="utf-8"))
    assert counts["points"] == RECORD["points"]
    assert counts["status"]["reached"] == RECORD["reached"]
    assert numbers("| # of # planes;") == [
        str(counts["planes_reached_at_lowest_bound"]),
        str(counts["planes"]),
    ]
