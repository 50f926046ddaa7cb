"""The table of every mission's solves on the emulated computer."""

from __future__ import annotations

from benchmarks.computer import SCENARIOS, YARDSTICK_MHZ, Ordered, priced, table
from hw_model.platform.platform import load_platform
from hw_model.timing.ps import PRICES

SMALLEST = SCENARIOS / "paper002.toml"


def test_rows_hold_the_fastest_design_against_the_ps_alone() -> None:
    base = load_platform("zu9eg")
    paper, resident = rows = list(priced("platform launch", SMALLEST, base, [YARDSTICK_MHZ]))
    work = Ordered(SMALLEST, "amd")
    slow = base.with_values({"pl.clock_mhz": YARDSTICK_MHZ, "pl.lanes": 1})
    for row in rows:
        assert (row["solves"], row["iterations"]) == (1, 1)
        for price in PRICES:
            low, nominal, high = row[price]["speedup"]
            assert low < nominal < high
            assert nominal == row[price]["ps_ms"] / row[price]["ms"]
        assert row["flop_per_cycle"]["ms"] < work.ms(slow, row["partition"])
    assert resident["flop_per_cycle"]["ms"] < paper["flop_per_cycle"]["ms"]
    assert all(paper[price]["ps_ms"] == resident[price]["ps_ms"] for price in PRICES)
    assert resident["bound"].startswith("dependency")
    lines = table(rows, YARDSTICK_MHZ)
    assert sum(line.startswith("| platform launch") for line in lines) == 2
    assert sum(line.startswith("| geometric mean of 1") for line in lines) == 2


def test_where_no_engine_fits_a_row_says_so() -> None:
    base = load_platform("zu9eg").with_value("resources.bram36", 1)
    rows = list(priced("platform launch", SMALLEST, base, [YARDSTICK_MHZ]))
    assert [row["design"] for row in rows] == [None, None]
    assert any("none fits" in line for line in table(rows, YARDSTICK_MHZ))
