"""`synthesis.json`: what yosys made of the RTL, module by module (scripts/record_synthesis.py writes it)."""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .engine import Shape

if TYPE_CHECKING:
    from hw_model.vocabulary import Datapath


@dataclass(frozen=True, slots=True)
class Synthesis:
    """What yosys made of one module of rtl/ with some parameters."""

    module: str
    parameters: dict[str, int]
    lut: int
    ff: int
    dsp: int
    bram36: float
    fitted: bool


RECORD = Path(__file__).parent / "synthesis.json"


@cache
def recorded(path: Path = RECORD) -> tuple[Synthesis, ...]:
    """A record of synthesis that scripts/record_synthesis.py wrote."""
    return tuple(_row(row) for row in json.loads(path.read_text())["rows"])


def shape_of(row: Synthesis) -> Shape:
    """The engine that a row of the record is about."""
    given = row.parameters
    datapath: Datapath = "f64" if given["FP"] == 64 else "f32"
    units = (given["LANES"], given["DIVIDERS"], given["BANKS"])
    return Shape(datapath, *units, given["ADDRESS_BITS"], given.get("CLUSTERS", 1))


def is_resident(row: Synthesis) -> bool:
    """Whether the engine of a row controls itself."""
    return bool(row.parameters.get("RESIDENT"))


def has_parity(row: Synthesis) -> bool:
    """Whether the engine of a row has a parity bit a word and a line."""
    return bool(row.parameters.get("PARITY"))


def _row(row: dict[str, Any]) -> Synthesis:
    return Synthesis(
        row["module"], row["parameters"], row["lut"], row["ff"], row["dsp"], row["bram36"], row["fitted"]
    )
