"""Count the solves that judge the model of the simulated chip, to which nothing is fitted: tests/soc/held_out.json and orders.json.

    PYTHONPATH=. .venv/bin/python -m scripts.record_rocket_judged    # what is not on record, minutes a run

The first solve of each plan from cold, with the plan's own settings, alone and under both partitions. Under a partition the parts of the
link are counted in ORDERS of the program's files, each with code and data in other places.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from dataclasses import astuple
from pathlib import Path
from typing import Any

from orbsoc.conic.settings import Settings
from orbsoc.hw.workload import Posed, solves_of
from scripts.instruction_problems import SCENARIOS
from scripts.record_rocket_link import ENGINE, ORDERS, Parts, parts_of, simulated
from scripts.write_mpc_problem import mpc

TESTS = Path(__file__).resolve().parent.parent / "tests" / "soc"
HELD_OUT, ORDERED = TESTS / "held_out.json", TESTS / "orders.json"
MPC = "mpc"
"""The problem of write_mpc_problem.py; the others are files of scenarios/."""
SOLVES = ("rec1.toml", "paper000_1.toml", "phasing_drift.toml", "rendezvous_40.json", MPC)
PARTITIONS = (None, "resident", "paper")
RATIO = 6.0


def posed(name: str) -> Posed:
    """A solve of SOLVES."""
    return Posed(mpc(), Settings()) if name == MPC else solves_of(SCENARIOS / name)[0]


def judging() -> Iterator[tuple[str, str | None]]:
    """Solves with their partitions, None for the core alone."""
    return ((name, partition) for name in SOLVES for partition in PARTITIONS)


def name_of(name: str, partition: str | None) -> str:
    """Of a run, in orders.json."""
    return f"{name}-{partition}"


def held_out() -> list[dict[str, Any]]:
    """The record of whole runs."""
    found: list[dict[str, Any]] = json.loads(HELD_OUT.read_text(encoding="utf-8"))
    return found


def ordered() -> dict[str, list[Parts]]:
    """The record of the link, by run and order."""
    found: dict[str, list[Parts]] = (
        json.loads(ORDERED.read_text(encoding="utf-8")) if ORDERED.exists() else {}
    )
    return found


def main() -> int:
    """Count what is missing."""
    rows, clocks = held_out(), ordered()
    for name, partition in judging():
        if (name, partition) not in {(row["scenario"], row["partition"]) for row in rows}:
            run = simulated(posed(name), partition, RATIO, 0)
            row = {"scenario": name, "partition": partition, "ratio": RATIO}
            row |= {"address_bits": ENGINE.address_bits} if partition else {}
            stages = [astuple(stage) for stage in run.stages]
            rows.append(
                row | {"core_cycles": run.core_cycles, "instructions": run.instructions, "stages": stages}
            )
            HELD_OUT.write_text(f"[\n{_lines(rows)}\n]\n", encoding="utf-8")
            sys.stdout.write(f"{name_of(name, partition)}: {run.core_cycles}\n")
        if partition is None:
            continue
        found = clocks.setdefault(name_of(name, partition), [])
        for order in ORDERS[len(found) :]:
            found.append(parts_of(simulated(posed(name), partition, RATIO, order)))
            pairs = ",\n".join(f"{json.dumps(run)}: {json.dumps(each)}" for run, each in clocks.items())
            ORDERED.write_text(f"{{\n{pairs}\n}}\n", encoding="utf-8")
            sys.stdout.write(f"{name_of(name, partition)}, order {order}: {found[-1]}\n")
    return 0


def _lines(rows: list[dict[str, Any]]) -> str:
    return ",\n".join(json.dumps(row) for row in rows)


if __name__ == "__main__":
    raise SystemExit(main())
