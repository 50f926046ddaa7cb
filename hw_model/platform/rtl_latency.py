"""Latencies of the RTL's units, read from the file that the RTL includes; no number of them is written here.

`latency.svh` beside this file is a link to `rtl/latency.svh`; an installed package holds a copy of it.
"""

from __future__ import annotations

import re
from pathlib import Path

from hw_model.errors import PlatformError

from .data_file import Table

_PARAMETER = re.compile(r"^localparam int (\w+) = (\d+);", re.MULTILINE)
_UNITS = {"add": "adder", "mul": "multiplier", "div": "divider", "sqrt": "square root"}
_HELD = ("div", "sqrt")
"""An operation holds its unit for more than a cycle."""


def rtl_latencies() -> Table:
    """The preset `latency.orbsoc_rtl`: of f64 and f32 the cycles of each unit, and between two operations on it."""
    text = (Path(__file__).parent / "latency.svh").read_text(encoding="utf-8")
    written = {name: int(cycles) for name, cycles in _PARAMETER.findall(text)}
    return {word: _of_word(written, word) for word in ("f64", "f32")}


def _of_word(written: dict[str, int], word: str) -> Table:
    found: Table = {}
    for unit, title in _UNITS.items():
        source = f"rtl/latency.svh, which the RTL includes: design value of the project's {title}"
        for key in (f"{unit}_cycles", f"{unit}_interval_cycles")[: 2 if unit in _HELD else 1]:
            name = f"{word}_{key}".upper()
            if name not in written:
                raise PlatformError(f"rtl/latency.svh: `{name}` is missing")
            found[key] = {"value": written[name], "tag": "sourced", "source": source}
    return found
