"""Place and route the RTL with open tools and record its clocks: hw_model/platform/route.json, docs/rtl.md (`make route`),
and the PL clocks of the devices that follow from them.

Each module is wrapped in registers, so that every path counts and few pins are needed. A row, of one module on one part
with one seed, is made again when the circuit (scripts/circuit.py) or the tools changed; where the text of the RTL did and the circuit
did not, its digest of the text is renewed. Rows are written as they are found, so that a run that was stopped goes on. Usage:
record_route.py [--same] [units] [fp_add …] [lifcl_40_9 …]: all rows, or those of the units, modules or parts. With --same
nothing is routed; rows of another circuit are named, and the exit code is 1.
"""

from __future__ import annotations

import json
import sys
from typing import Any

from scripts.routing.clocks import PAGE, RECORD, key_of, with_table, write, write_clocks
from scripts.routing.flow import circuit_of, made_from, routed
from scripts.routing.modules import ROWS
from scripts.routing.parts import PARTS, versions

Key = tuple[str, str, str, int]
"""Part, module, parameters, seed."""


def main() -> None:
    """Bring the record and the page up to date."""
    known = json.loads(RECORD.read_text())["rows"] if RECORD.exists() else []
    kept = {key_of(row): row for row in known}
    wanted = [word for word in sys.argv[1:] if word != "--same"]
    names = {"units", *PARTS, *(module for _, module, _, _ in ROWS)}
    if not names.issuperset(wanted):
        raise SystemExit(f"ROUTE takes some of {', '.join(sorted(names))}, not {' '.join(wanted)}")
    others = []
    for key in sorted(ROWS, key=_seed):  # one seed of all, then the next
        part, module, parameters, seed = key
        named = {part, module, "units" if module.startswith("fp_") else ""}
        if wanted and named.isdisjoint(wanted):
            continue
        row = renewed(kept.get(key), key)
        if row is None and "--same" not in sys.argv:
            row = routed(*key) | state_of(key) | {"circuit": circuit_of(*key[:3])}
            sys.stderr.write(f"{part} {module} {parameters} seed {seed}: {row['mhz']} MHz\n")
        elif row is None:
            others += [key] * (key in kept)
        if row is not None and row != kept.get(key):
            kept[key] = row
            write([kept[key] for key in ROWS if key in kept])
    rows = [kept[key] for key in ROWS if key in kept]
    write(rows)
    PAGE.write_text(with_table(PAGE.read_text()))
    if any(row["module"] == "engine" for row in rows):
        write_clocks(rows)
    if others:
        raise SystemExit(
            "\n".join(f"another circuit or tool: {part} {module} {rest}" for part, module, *rest in others)
        )


def renewed(row: dict[str, Any] | None, key: Key) -> dict[str, Any] | None:
    """A row of the record under the present digests; None if it is of another circuit, of other options or tools."""
    state = state_of(key)
    if row is None or row["tools"] != state["tools"]:
        return None
    if row["source"] == state["source"]:
        return row if "circuit" in row else row | {"circuit": circuit_of(*key[:3])}
    return row | state if row.get("circuit") == circuit_of(*key[:3]) else None


def state_of(key: Key) -> dict[str, Any]:
    """What a row is made of, as text, and by what."""
    return {"source": made_from(*key[:3]), "tools": versions(PARTS[key[0]])}


def _seed(row: Key) -> int:
    return row[3]


if __name__ == "__main__":
    main()
