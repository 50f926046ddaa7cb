"""Every register of the RTL with its place: where a bit may be turned over, by Verilator's own list of what is clocked."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ElementTree
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from .session import RtlSession
from .validation import RtlError

Place = Literal["storage", "microcode", "sequencer", "tables", "control", "units", "networks"]
PLACES: Mapping[Place, tuple[str, ...]] = {
    "storage": ("bank",),
    "microcode": (),
    "sequencer": ("sequencer_", "compressed_"),
    "tables": ("registers",),
    "control": ("attempt",),
    "units": ("lane", "divider", "fp_"),
    "networks": ("read_network", "write_", "replica", "datapath", "engine", "window", "unpack"),
}
"""Modules of each place, by how their names begin. `tables`: the register file; `control`: what runs attempts."""
MICROCODE = ("code", "templates", "lengths")
"""Registers of the sequencer that are memories of the program."""
_WORD_BITS = 32


@dataclass(frozen=True, slots=True)
class Register:
    """A clocked variable of one instance: `elements` of `width` bits."""

    place: Place
    scope: str
    name: str
    width: int
    elements: int

    def in_memory(self, bit: int) -> int:
        """Where the simulator has a bit of it: an element takes 1, 2, 4 or 8 bytes, or words of 32 bits."""
        element, at = divmod(bit, self.width)
        return element * _element_bits(self.width) + at


def registers_of(session: RtlSession, harness: Path) -> list[Register]:
    """All registers of the engine that `session` runs, but those of the checks, which no chip has.

    Raises RtlError where the simulation has another memory for one than its description.
    """
    document = ElementTree.parse(harness.with_name(harness.name + ".xml"))  # written by our own build
    clocked = _clocked(document)
    modules: dict[str, dict[str, None]] = {}
    for cell in document.iter("cell"):  # the instances of a loop have one name
        modules.setdefault(cell.get("hier", ""), {})[cell.get("submodname", "")] = None
    found: list[Register] = []
    for scope in session.ask("scopes").split()[1:]:
        for module in modules.get(_without_generate_blocks(scope), {}):
            place = _place(module)
            sizes = {name: int(session.ask(f"bits {scope} {name}")) for name in clocked[module]}
            if place is None or not all(sizes.values()):
                continue  # another module of this name, in another branch of a generate block
            for name, (width, elements) in clocked[module].items():
                if sizes[name] != elements * _element_bits(width):
                    raise RtlError(f"{scope}.{name}: {sizes[name]} bits in memory for {elements} of {width}")
                memory = place == "sequencer" and name in MICROCODE
                found.append(Register("microcode" if memory else place, scope, name, width, elements))
    return found


def _clocked(document: ElementTree.ElementTree[ElementTree.Element]) -> dict[str, dict[str, tuple[int, int]]]:
    """Of each module the variables that a clock edge assigns: bits of an element, and elements."""
    types = {each.get("id"): each for table in document.iter("typetable") for each in table}

    def size(number: str | None) -> tuple[int, int]:
        found = types[number]
        if found.tag == "unpackarraydtype":
            ends = [int(each.get("name", "").rpartition("h")[2], 16) for each in found.iter("const")]
            width, elements = size(found.get("sub_dtype_id"))
            return width, elements * (abs(ends[0] - ends[1]) + 1)
        left, right = found.get("left"), found.get("right")
        return (1 if left is None or right is None else abs(int(left) - int(right)) + 1), 1

    clocked: dict[str, dict[str, tuple[int, int]]] = {}
    for module in document.iter("module"):
        sizes = {each.get("name", ""): size(each.get("dtype_id")) for each in module.iter("var")}
        targets = (list(each)[-1] for each in module.iter("assigndly"))
        names = {next(each for each in target.iter("varref")).get("name", "") for target in targets}
        clocked[module.get("name", "")] = {name: sizes[name] for name in sorted(names)}
    return clocked


def _without_generate_blocks(scope: str) -> str:
    """The instances of a scope: `TOP.engine.path.g_lane[0].unit` is engine.path.unit."""
    return re.sub(r"\.g_\w+(\[\d+\])?", "", scope.removeprefix("TOP."))


def _place(module: str) -> Place | None:
    return next((place for place, heads in PLACES.items() if module.startswith(heads)), None)


def _element_bits(width: int) -> int:
    return next((bits for bits in (8, 16, 32, 64) if width <= bits), -(-width // _WORD_BITS) * _WORD_BITS)
