"""The record of synthesis is of this RTL: one small unit made anew by yosys."""

from __future__ import annotations

import json
import re
import subprocess
from pathlib import Path

from hw_model.area.synthesis import recorded
from scripts.record_synthesis import PAGE, with_tables
from tests.rtl.verilator import require_yosys

RTL = Path(__file__).resolve().parents[2] / "rtl"
SYNTHESIZE = RTL / "synthesize.sh"


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


def test_yosys_rounds_up_to_infinity() -> None:
    """Its netlist of fp_round at binary32: an exponent of all ones, of which yosys 0.23 once read one (docs/rtl.md, Cells)."""
    require_yosys()
    script = (
        "read_verilog -sv -I. contract.sv fpu/fp_round.sv; hierarchy -top fp_round -chparam EXP 8 -chparam MAN 23; proc;"
        " eval -set exp 9'd255 -set man 26'h2000000 -set special 1'b0 -set sign 1'b0 -show packed_man"
    )
    said = subprocess.run(["yosys", "-p", script], cwd=RTL, check=True, capture_output=True, text=True).stdout
    assert re.findall(r"packed_man = 31'([01]+)", said) == ["1" * 8 + "0" * 23]


def test_no_parameter_of_the_rtl_is_an_unsized_one() -> None:
    sources = [path.read_text(encoding="utf-8") for path in RTL.rglob("*.sv*")]
    parameters = [
        found
        for text in sources
        for found in re.findall(r"(?:local)?param(?:eter)?\s[^;]*?=\s*([^,;)]+)", text)
    ]
    assert len(parameters) > 300
    assert "'1" not in {value.strip() for value in parameters}
