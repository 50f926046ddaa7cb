"""What the pages say of approaches beside a nonlinear solver is what the table of them says."""

from __future__ import annotations

import csv
import re
from pathlib import Path
from statistics import median

DOCS = Path(__file__).resolve().parents[2] / "docs"


def test_counts_and_the_worst_are_of_the_table() -> None:
    with (DOCS / "measurements" / "approach-nonlinear.csv").open(encoding="utf-8") as file:
        rows = {int(row["approach"]): row for row in csv.DictReader(file)}
    above = {
        k: 100.0 * (float(row["plan_m_s"]) / float(row["best_m_s"]) - 1.0)
        for k, row in rows.items()
        if row["best_m_s"] != "inf"
    }
    far = {k: value for k, value in above.items() if value > 0.5}
    page = (DOCS / "measurements" / "approach.md").read_text(encoding="utf-8")
    section = page[page.index("## Beside a nonlinear solver") : page.index("## Time of the command")]
    counts = (len(rows), len(above), sum(v <= 0.05 for v in above.values()), sum(v <= 0.5 for v in above.values()), len(far))  # fmt: skip
    assert tuple(map(int, re.findall(r"\| (\d+) \|$", section, flags=re.MULTILINE))) == counts
    assert f"The median is {median(above.values()):.3f} %" in section
    told = re.findall(r"(\d+) \((\d+\.\d\d) %\)", section)
    assert {int(k): value for k, value in told} == {k: f"{value:.2f}" for k, value in far.items()}
    left = [int(k) for k in re.findall(r"\d+", section[section.index("left out (") :].partition(")")[0])]
    assert left == sorted(rows.keys() - above.keys())
    guide = (DOCS / "approach.md").read_text(encoding="utf-8")
    sentence = guide[guide.index("Beside SLSQP from ten starts") : guide.index("## Limits")]
    assert [int(n) for n in re.findall(r"\b\d{3}\b", sentence)] == [*counts[:4]]
