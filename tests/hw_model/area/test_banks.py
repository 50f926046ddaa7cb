"""Banks with a given number of rows: block RAM and lookup tables are those that yosys takes for rtl/engine/bank."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import pytest

from hw_model.area.fabric import FABRICS
from tests.rtl.engine_sources import RTL
from tests.rtl.verilator import require_yosys

SYNTHESISED = {
    (1024, 64): (2.0, 0), (1500, 64): (3.0, 67), (1536, 64): (3.0, 67), (2560, 64): (5.0, 261), (3072, 64): (6.0, 67),
    (5000, 64): (10.0, 261), (600, 64): (2.0, 0), (700, 32): (1.0, 0), (1280, 32): (1.5, 35), (1500, 32): (1.5, 35),
    (2560, 32): (2.5, 133), (2560, 65): (5.0, 265), (4096, 64): (8.0, 0),
}  # fmt: skip
"""Rows and bits: BRAM36, and lookup tables but for the one that a bank of any size takes to enable its write; yosys 0.23, 7-series."""


@pytest.mark.parametrize(("bank", "taken"), SYNTHESISED.items(), ids=str)
def test_the_model_has_what_a_bank_takes(bank: tuple[int, int], taken: tuple[float, int]) -> None:
    fabric = FABRICS["xc7"]
    assert (fabric.bram36(*bank), fabric.chosen_luts(*bank)) == taken


def test_on_ng_ultra_a_bank_takes_what_yosys_0_70_maps() -> None:
    """6 and 9 NX_RAM, each two thirds of a BRAM36; 129 lookup tables more for the second, of which the choice is 128."""
    fabric = FABRICS["ng_ultra"]
    assert [fabric.bram36(rows, 64) for rows in (2560, 4096, 5000)] == pytest.approx([4, 4, 6])
    assert [fabric.chosen_luts(rows, 64) for rows in (2560, 4096)] == [0, 0]
    assert fabric.chosen_luts(5000, 64) == pytest.approx(129, rel=0.02)


@pytest.mark.parametrize("bank", [(1500, 32), (700, 32)], ids=str)
def test_a_bank_synthesised_anew_takes_it(bank: tuple[int, int], tmp_path: Path) -> None:
    require_yosys()
    rows, bits = bank
    command = f"hierarchy -top bank -chparam ROW 11 -chparam WIDTH {bits} -chparam ROWS {rows}; synth_xilinx -family xc7 -flatten -top bank"
    subprocess.run(
        ["yosys", "-q", "-p", f"read_verilog -sv {RTL / 'engine' / 'bank.sv'}; {command}; tee -q -o {tmp_path / 'cells'} stat -json"],
        capture_output=True, check=True,
    )  # fmt: skip
    cells = json.loads((tmp_path / "cells").read_text())["modules"]["\\bank"]["num_cells_by_type"]
    luts = sum(count for kind, count in cells.items() if kind.startswith("LUT"))
    blocks = cells.get("RAMB36E1", 0) + cells.get("RAMB18E1", 0) / 2
    one = SYNTHESISED[bank][1] == 0
    assert (blocks, luts - one) == SYNTHESISED[bank]
