"""The paper's tables and statements, beside ours."""

from __future__ import annotations

from pathlib import Path

from typer.testing import CliRunner

from orbsoc.commands.app import app
from orbsoc.guidance.mission import PaperRow
from orbsoc.missions.passive_safety import reproduce

SCENARIOS = Path(__file__).resolve().parents[3] / "scenarios"


def test_the_tables_and_statements_have_their_known_verdicts() -> None:
    rows = {row.quantity: row for row in reproduce(SCENARIOS)}

    def verdicts(kind: str) -> set[str]:
        return {name for name, row in rows.items() if row.verdict == kind}

    assert verdicts("other data") == set()
    assert {name for name in rows if "paper000_" in name and "printed" not in name} - verdicts("reproduced") == {
        "paper000_2: pulse 1", "paper000_2: pulse 4", "paper000_2: total", "paper000_4: pulse 1", "paper000_4: total",
    }  # fmt: skip
    assert {"paper000_4: pulse 1", "paper000_4: total"} <= verdicts("misprint")
    assert all(f"paper000_{k}_printed: total" in verdicts("not reproduced") for k in range(1, 9))
    assert verdicts("inferred") == {"constants"}
    assert rows["paper000_5: total"].ours == "1.410806 m/s"
    assert rows["three impulses"].ours == "feasible in 8 of 8 rows, cheaper in 8"
    assert rows["five impulses"].verdict == "reproduced"
    clear = rows["first drift from the safety boundary, T = 4200 s"]
    assert (clear.paper, clear.ours, clear.verdict) == (
        "tangent",
        "231.3 m (271.3 m from the target)",
        "misprint",
    )
    assert rows["passively safe"].ours == "z ≥ 38.79 m for all time, of 40 m"
    assert all(
        isinstance(row, PaperRow) and row.reason for row in rows.values() if row.verdict != "reproduced"
    )


def test_a_stated_row_that_does_not_hold_ends_with_1(tmp_path: Path) -> None:
    text = (SCENARIOS / "paper000_1.toml").read_text(encoding="utf-8")
    (tmp_path / "changed.toml").write_text(text.replace("keep_out_m = 40.0", "keep_out_m = 41.0"))
    result = CliRunner().invoke(
        app, ["reproduce", "000", "--scenarios", str(tmp_path), "--out", str(tmp_path / "out")]
    )
    assert result.exit_code == 1
    assert "does not hold as stated: paper000_1: pulse 3" in result.output
