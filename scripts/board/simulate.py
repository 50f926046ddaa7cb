"""The routed netlist beside the RTL in one simulation, clock by clock, with the program that the bitstream holds.

    python -m scripts.board.simulate      after `make bitstream`; what it prints is in docs/board.md

Compared are all pins, and each access of the core: address, bytes, the word written, or the word read. The netlist is nextpnr's JSON,
its memories as ecpunpack reads them from the bitstream; delays are not simulated.
"""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from pathlib import Path

from scripts.board.cells import nets_of, write_cells
from scripts.board.flow import TOP, WORK
from scripts.record_synthesis import ROOT
from scripts.routing.flow import run
from scripts.routing.modules import TILES

TAPS = ("valid", "ready", "address", "value", "answer", "strobes")
"""Of rtl/board/board.sv."""
MODELS = [ROOT / "rtl" / "harness" / f"ecp5_{name}.sv" for name in ("memory", "multiplier")]
LIMIT = 40_000_000
"""Clocks."""
BENCH = """
module bench;
  logic clk_25mhz = 0, ftdi_txd = 1, btn_pwr_n = 1;
  logic rxd, rxd_made, radio, radio_made, valid, ready;
  logic [7:0] led, led_made;
  logic [31:0] address, value, answer;
  logic [3:0] strobes;
  longint words = 0, engine = 0, left = -1;
  ulx3s given (.clk_25mhz, .ftdi_txd, .btn_pwr_n, .ftdi_rxd(rxd), .wifi_gpio0(radio), .led(led));
  cells made (.clk_25mhz, .ftdi_txd, .btn_pwr_n, .ftdi_rxd(rxd_made), .wifi_gpio0(radio_made), .led(led_made),
      .valid, .ready, .address, .value, .answer, .strobes);
  task automatic same(input string what, input logic [63:0] rtl, input logic [63:0] netlist, input longint clock);
    if (rtl !== netlist) $fatal(1, "clock %0d, after %0d words: %s is %h, in the RTL %h", clock, words, what, netlist, rtl);
  endtask
  always #1 clk_25mhz = !clk_25mhz;
  initial for (longint clock = 0; ; clock++) begin
    @(negedge clk_25mhz);
    if (clock >= 32) begin
      same("ftdi_rxd", 64'(rxd), 64'(rxd_made), clock);
      same("led", 64'(led), 64'(led_made), clock);
      same("wifi_gpio0", 64'(radio), 64'(radio_made), clock);
      same("valid", 64'(given.computer.valid), 64'(valid), clock);
      if (valid) begin
        same("address", 64'(given.computer.address), 64'(address), clock);
        same("strobes", 64'(given.computer.strobes), 64'(strobes), clock);
        if (strobes != 0) same("value", 64'(given.computer.value), 64'(value), clock);
        same("ready", 64'(given.computer.ready), 64'(ready), clock);
        if (ready) begin
          if (strobes == 0) same("answer", 64'(given.computer.answer), 64'(answer), clock);
          words++;
          engine += longint'(address[31:28] == 2 || address[31:28] == 3);
        end
      end
    end
    if (left < 0 && (led[1] || led[2] || led[7])) left = 20_000;
    if (left == 0 || clock == LIMIT) begin
      $display("%s: %0d clocks, %0d words of the core equal, %0d of them of the engine", led == 2 ? "PASS" : "FAIL", clock, words, engine);
      $finish;
    end
    if (left > 0) left--;
  end
endmodule
"""


def simulate() -> str:
    """The last line of the simulation. Raises SystemExit with the first difference, or where a tool fails."""
    if shutil.which("verilator") is None:
        raise SystemExit("make netlist: Verilator is not installed (Debian: apt install verilator)")
    folder = WORK / "simulation"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    routed = json.loads((WORK / "routed.json").read_text())
    before = json.loads((WORK / "netlist.json").read_text())
    taps = {name: nets_of(f"computer.{name}", before, routed) for name in TAPS}
    run("yowasp-ecpunpack", "--input", "board.bit", "--textcfg", "unpacked.config", folder=WORK)
    write_cells(folder, routed, (WORK / "unpacked.config").read_text(), taps)
    (folder / "bench.sv").write_text(BENCH.replace("LIMIT", str(LIMIT)))
    shutil.copy(WORK / "whole.hex", folder / "memory.hex")
    ours = sorted(path for name in ("fpu", "engine", "axi", "board") for path in (WORK / name).glob("*.sv"))
    sources = [*MODELS, WORK / "contract.sv", *ours, WORK / "picorv32.v"]
    command = [
        "verilator", "--binary", "-O3", "-MAKEFLAGS", "OPT_FAST=-O1 OPT_SLOW=-O0", "-Wno-fatal", "-Wno-lint", f"-I{WORK}", "--top", "bench", "-Mdir", "model", *TILES, "bench.sv", "cells.v",
        *map(str, sources),
    ]  # fmt: skip
    _run(command, folder)
    return _run([str(folder / "model" / "Vbench")], folder).splitlines()[0]


def _run(command: list[str], folder: Path) -> str:
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode:
        raise SystemExit(f"{' '.join(command[:1])}\n{done.stdout[-2000:]}{done.stderr[-2000:]}")
    return done.stdout


if __name__ == "__main__":
    sys.stdout.write(simulate() + f" (top {TOP})\n")
