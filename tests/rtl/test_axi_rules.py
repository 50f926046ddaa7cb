"""Properties of the AXI slaves (rtl/harness/axi_rules.sv), by yosys' own SAT solver: no master and no engine breaks one within
some clocks of reset. docs/driver.md says to what depth SymbiYosys has proved them."""

from __future__ import annotations

import subprocess
from pathlib import Path

from orbsoc.rtl.mutations import Mutation
from tests.rtl.engine_sources import RTL
from tests.rtl.verilator import require_yosys

STEPS = 8
"""A register write, or a burst of one beat, is over within them."""
SCRIPT = (
    "read_verilog -formal -sv -I. contract.sv axi/axi_[!e]*.sv harness/axi_rules.sv; prep -flatten -top axi_rules;"
    f" memory_map; async2sync; opt -full; sat -verify -prove-asserts -set-assumes -tempinduct-baseonly -maxsteps {STEPS} -seq 1"
)


def proved(rtl: Path) -> bool:
    """Whether no assertion can fail; raises AssertionError where yosys says neither."""
    done = subprocess.run(["yosys", "-p", SCRIPT], cwd=rtl, capture_output=True, text=True, check=False)
    good, bad = f"proved base case for {STEPS} steps: SUCCESS!" in done.stdout, "model found" in done.stdout
    assert good != bad, done.stdout[-2000:] + done.stderr
    assert (done.returncode == 0) is good
    return good


def test_no_traffic_breaks_a_rule_within_some_clocks_of_reset() -> None:
    require_yosys()
    assert proved(RTL)


def test_a_register_write_that_does_not_wait_for_storage_breaks_one(tmp_path: Path) -> None:
    require_yosys()
    wrong = Mutation("axi/axi_registers.sv", "idle && write_wanted && quiet &&", "idle && write_wanted &&")
    assert not proved(wrong.apply(RTL, tmp_path))
