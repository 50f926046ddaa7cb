"""Place and route the RTL with open tools and record its clocks: hw_model/platform/route.json, docs/rtl.md (`make route`),
and the PL clocks of the devices that follow from them.

Each module is wrapped in registers, so that every path counts and few pins are needed. A row, of one module on one part
with one seed, is made again when the RTL it is made of or the tools changed; rows are written as they are found, so
that a run that was stopped goes on. Usage: record_route.py [units] [fp_add …] [lifcl_40_9 …]: all rows, or those of the units,
modules or parts.
"""

from __future__ import annotations

import json
import sys

from scripts.routing.clocks import PAGE, RECORD, key_of, with_table, write, write_clocks
from scripts.routing.flow import made_from, routed
from scripts.routing.modules import ROWS
from scripts.routing.parts import PARTS, versions


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


if __name__ == "__main__":
    main()
