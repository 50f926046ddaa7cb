"""What nextpnr has placed and routed, as Verilog that simulates: the netlist of its JSON, with block memories as the bitstream fills them.

Cells of logic are written as what they do. DP16KD and MULT18X18D become instances of our models in rtl/harness/ecp5_*.sv. A pin that no
net reaches has the level to which nextpnr ties it (its ecp5/bitstream.cc). A cell or mode that is not known here is an error.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

Cell = dict[str, Any]
Bit = int | str
"""A net of a netlist in JSON, or "0" or "1"."""
_CONTROL = ("CLK", "WE", "RST", "CS", "CE", "OCE")
"""Pins of a block that are tied high and inverted by their multiplexer where they are to be low."""
_PAIRS = {
    "WDO0": "C1",
    "WDO1": "A1",
    "WDO2": "D1",
    "WDO3": "B1",
    "WADO0": "D0",
    "WADO1": "B0",
    "WADO2": "C0",
    "WADO3": "A0",
}
"""Outputs of the write port of a memory in logic, by its inputs."""


class CellError(ValueError):
    """A cell or a mode of one that has no model here."""


def contents_of(config: str) -> dict[int, list[int]]:
    """Of each block memory by its number: 2048 words of 9 bits, from nextpnr's text or ecpbram's."""
    blocks = re.findall(r"^\.bram_init (\d+)\n((?:[0-9a-f ]+\n)+)", config, re.MULTILINE)
    return {int(number): [int(word, 16) for word in words.split()] for number, words in blocks}


def block_file(number: int) -> str:
    """Name of the file that a block memory begins with."""
    return f"block{number}.hex"


def write_cells(folder: Path, netlist: Cell, config: str, taps: dict[str, list[Bit]] | None = None) -> None:
    """cells.v, with the module `cells`, and a file for each block memory that is not all zeros, into a folder where the simulation runs."""
    (folder / "cells.v").write_text(verilog(netlist, config, "cells", taps))
    for number, words in contents_of(config).items():
        (folder / block_file(number)).write_text("".join(f"{word:03x}\n" for word in words))


def verilog(netlist: Cell, config: str, name: str, taps: dict[str, list[Bit]] | None = None) -> str:
    """The module `name` with the ports of the netlist's top, and an output for each of `taps`, nets from the lowest bit on."""
    (top,) = netlist["modules"].values()
    filled = {number for number, words in contents_of(config).items() if any(words)}
    tapped = taps or {}
    ports, body = [], []
    for port, given in top["ports"].items():
        bits = given["bits"]
        ports.append(f"{given['direction']} logic [{len(bits) - 1}:0] {port}")
        whole = f"{{{', '.join(f'n{bit}' for bit in reversed(bits))}}}"
        body.append(
            f"assign {f'{whole} = {port}' if given['direction'] == 'input' else f'{port} = {whole}'};"
        )
    for tap, nets in tapped.items():
        ports.append(f"output logic [{len(nets) - 1}:0] {tap}")
        row = (f"n{bit}" if isinstance(bit, int) else f"1'b{bit}" for bit in reversed(nets))
        body.append(f"assign {tap} = {{{', '.join(row)}}};")
    used = {bit for cell in top["cells"].values() for bits in cell["connections"].values() for bit in bits}
    used |= {bit for port in top["ports"].values() for bit in port["bits"]} | {
        bit for nets in tapped.values() for bit in nets if isinstance(bit, int)
    }
    set_first = {}
    for cell in top["cells"].values():
        if cell["type"] == "TRELLIS_FF":
            set_first[cell["connections"]["Q"][0]] = _text(cell, "REGSET", "RESET") == "SET"
    for bit in sorted(used):
        body.append(f"logic n{bit}{f' = {int(set_first[bit])}' if bit in set_first else ''};")
    for index, cell in enumerate(top["cells"].values()):
        body += _statements(cell, index, filled)
    lines = "\n  ".join(body)
    return f"module {name} ({', '.join(ports)});\n  {lines}\nendmodule\n"


def nets_of(name: str, before: Cell, routed: Cell) -> list[Bit]:
    """The nets of a name of the RTL in the routed netlist, from the lowest bit on, by their names `before` it was routed: nextpnr keeps
    one name of a net that had several. Raises CellError where a bit is lost."""
    (new,) = routed["modules"].values()
    (old,) = (module for module in before["modules"].values() if int(module["attributes"].get("top", "0"), 2))
    by_bit: dict[Bit, list[str]] = {}
    for each, net in old["netnames"].items():
        for k, bit in enumerate(net["bits"]):
            by_bit.setdefault(bit, []).append(each if len(net["bits"]) == 1 else f"{each}[{k}]")
    found = {each: net["bits"][0] for each, net in new["netnames"].items()}
    nets: list[Bit] = []
    for k, bit in enumerate(old["netnames"][name]["bits"]):
        kept = [bit] if isinstance(bit, str) else [found[each] for each in by_bit[bit] if each in found]
        if not kept:
            raise CellError(f"{name}[{k}] has no net in the routed netlist")
        nets.append(kept[0])
    return nets


def _text(cell: Cell, name: str, default: str) -> str:
    """A parameter that is a word; yosys ends words of digits with a blank."""
    return str(cell["parameters"].get(name, default)).strip()


def _number(cell: Cell, name: str) -> int:
    return int(cell["parameters"].get(name, "0"), 2)


def _pin(cell: Cell, pin: str, tied: int = 1) -> str:
    """The net at a pin, or the level that it has without one."""
    bits = cell["connections"].get(pin, [])
    return f"n{bits[0]}" if bits else f"1'b{tied}"


def _out(cell: Cell, pin: str) -> str | None:
    bits = cell["connections"].get(pin, [])
    return f"n{bits[0]}" if bits else None


def _statements(cell: Cell, index: int, filled: set[int]) -> Iterator[str]:
    kind = cell["type"]
    if kind == "TRELLIS_COMB":
        yield from _logic(cell, index)
    elif kind == "TRELLIS_FF":
        yield _register(cell)
    elif kind == "TRELLIS_RAMW":
        for out, given in _PAIRS.items():
            if found := _out(cell, out):
                yield f"assign {found} = {_pin(cell, given)};"
    elif kind == "TRELLIS_IO":
        if _text(cell, "DIR", "INPUT") == "INPUT":
            yield f"assign {_out(cell, 'O')} = {_pin(cell, 'B')};"
        else:
            yield f"assign {_pin(cell, 'B')} = {_pin(cell, 'I')};"
    elif kind == "DCCA":
        yield f"assign {_out(cell, 'CLKO')} = {_pin(cell, 'CLKI')};"
    elif kind in ("DP16KD", "MULT18X18D"):
        yield _block(cell, index)
        number = int(cell["attributes"].get("WID", "0"), 2)
        if kind == "DP16KD" and number in filled:
            yield f'initial $readmemh("{block_file(number)}", block{index}.words);'
    else:
        raise CellError(f"no model of the cell {kind}")


def _logic(cell: Cell, index: int) -> Iterator[str]:
    """A table of four inputs, a bit of an adder, or 16 bits of memory; and the multiplexer behind it."""
    mode, table = _text(cell, "MODE", "LOGIC"), f"16'h{_number(cell, 'INITVAL'):04x}"
    a, b, c, d = (_pin(cell, pin) for pin in "ABCD")
    value = f"1'({table} >> {{{d}, {c}, {b}, {a}}})"
    if mode == "RAMW_BLOCK":
        return
    if mode == "DPRAM":
        at = ", ".join(_pin(cell, f"WAD{k}") for k in (3, 2, 1, 0))
        yield f"logic [15:0] memory{index} = {table};"
        yield f"always_ff @(posedge {_pin(cell, 'WCK')}) if ({_pin(cell, 'WRE')}) memory{index}[{{{at}}}] <= {_pin(cell, 'WD')};"
        value = f"memory{index}[{{{a}, {c}, {b}, {d}}}]"
    elif mode == "CCU2":
        carry = _pin(cell, "FCI", 0)
        taken = _text(cell, "CCU2_INJECT1", "NO") != "YES"
        made = f"1'({table} >> {{{b}, {a}}})" if taken else "1'b0"
        if out := _out(cell, "FCO"):
            yield f"assign {out} = {value} ? {carry} : {made};"
        value = f"{value} ^ {carry}" if taken else value
    elif mode != "LOGIC":
        raise CellError(f"no model of TRELLIS_COMB, MODE = {mode}")
    if out := _out(cell, "F"):
        yield f"assign {out} = {value};"
    if out := _out(cell, "OFX"):
        behind = cell["attributes"]["NEXTPNR_BEL"].endswith("K1")
        high, low = (_pin(cell, "FXB"), _pin(cell, "FXA")) if behind else (_pin(cell, "F1"), value)
        yield f"assign {out} = {_pin(cell, 'M')} ? {high} : {low};"


def _register(cell: Cell) -> str:
    for name, known in (("CLKMUX", "CLK"), ("LSRMUX", "LSR"), ("LSRMODE", "LSR")):
        if _text(cell, name, known) != known:
            raise CellError(f"no model of TRELLIS_FF, {name} = {_text(cell, name, known)}")
    out, clock, reset = _out(cell, "Q"), _pin(cell, "CLK"), _pin(cell, "LSR", 0)
    data = _pin(cell, "DI" if _text(cell, "SD", "0") == "1" else "M")
    enable = {"1": "1'b1", "0": "1'b0", "CE": _pin(cell, "CE"), "INV": f"!{_pin(cell, 'CE')}"}[
        _text(cell, "CEMUX", "1")
    ]
    at_reset = int(_text(cell, "REGSET", "RESET") == "SET")
    now = (
        f" or posedge {reset}" if _text(cell, "SRMODE", "LSR_OVER_CE") == "ASYNC" and reset[0] == "n" else ""
    )
    return f"always_ff @(posedge {clock}{now}) if ({reset}) {out} <= 1'b{at_reset}; else if ({enable}) {out} <= {data};"


def _block(cell: Cell, index: int) -> str:
    kind, directions = cell["type"], cell["port_directions"]
    pins = []
    for pin, bits in cell["connections"].items():
        if directions[pin] == "output":
            if bits:
                pins.append(f".{pin}(n{bits[0]})")
            continue
        through = _text(cell, f"{pin}MUX", "")
        if bits:
            pins.append(f".{pin}({'!' * (through == 'INV')}n{bits[0]})")
        elif pin.startswith(_CONTROL):
            pins.append(f".{pin}(1'b{int(through == pin)})")
        else:
            pins.append(f".{pin}(1'b{int(through == '1')})")
    given = []
    if kind == "DP16KD":
        given += [f".{name}({_number(cell, name)})" for name in ("DATA_WIDTH_A", "DATA_WIDTH_B")]
        given += [f'.{name}("{_text(cell, name, "NORMAL")}")' for name in ("WRITEMODE_A", "WRITEMODE_B")]
        given += [f'.{name}("{_text(cell, name, "NOREG")}")' for name in ("REGMODE_A", "REGMODE_B")]
    else:
        registers = [name for name in cell["parameters"] if name.startswith("REG_") and name.endswith("_CLK")]
        given += [f'.{name}("{_text(cell, name, "NONE")}")' for name in registers]
    return f"{kind} #({', '.join(given)}) block{index} ({', '.join(pins)});"
