"""The record of synthesis is of this RTL: one small unit made anew by yosys."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

from hw_model.area.synthesis import recorded
from scripts.record_synthesis import PAGE, with_tables
from tests.rtl.verilator import require_yosys

SYNTHESIZE = Path(__file__).resolve().parents[2] / "rtl" / "synthesize.sh"


def test_a_unit_synthesised_anew_takes_what_the_record_says() -> None:
    require_yosys()
    (row,) = (row for row in recorded() if row.module == "fp_add" and row.parameters["MAN"] == 23)
    command = [str(SYNTHESIZE), "fp_add", "EXP=8", "MAN=23"]
    made = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
    assert (made["dsp"], made["bram36"], made["ff"]) == (row.dsp, row.bram36, row.ff)
    assert (
        abs(made["lut"] / row.lut - 1) <= 0.10
    )  # the mapper's order of work moves it, and so does another yosys


def test_the_page_shows_the_record() -> None:
    page = PAGE.read_text(encoding="utf-8")
    assert with_tables(page) == page
