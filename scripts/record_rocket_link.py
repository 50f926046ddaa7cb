"""Count transfers between the two halves of the simulated chip, fit its link: hw_model/timing/rocket_link.json.

    PYTHONPATH=. .venv/bin/python -m scripts.record_rocket_link          # what is not on record, a minute a run
    PYTHONPATH=. .venv/bin/python -m scripts.record_rocket_link --fit    # fits the record anew

RUNS are on the chip: problems, each under a partition and at a ratio of the clocks. `resident` moves buffers once a solve, with caches that
do not have them; `paper` moves them again and again. Each is counted in ORDERS, which link the program's files one after another in different
ways: where code and data lie moves a run's link by some hundredths, a launch that comes once a solve by a quarter, and no law from a
pattern has that. The law is that of hw_model/timing/link.py. None of the problems is an insertion, a rendezvous, a phasing, a
model-predictive controller or passive safety: those are for judging (record_rocket_judged.py).
"""

from __future__ import annotations

import argparse
import json
import sys
from collections import Counter
from typing import NamedTuple

import numpy as np
from scipy.optimize import nnls

from hw_model import load_partition, load_platform
from hw_model.timing.actions import actions_of
from hw_model.timing.durations import Durations
from hw_model.timing.instructions import FOLDER
from hw_model.timing.link import BURST_BYTES, CACHED_BYTES
from hw_model.timing.trace import parse_trace
from orbsoc.conic.settings import Settings
from orbsoc.hw.emulation import PsScheduler
from orbsoc.hw.schedules import Engine
from orbsoc.hw.workload import Posed
from orbsoc.soc.compare import DEVICE
from orbsoc.soc.counted import Counted
from orbsoc.soc.machine import Machine
from orbsoc.soc.runs import FORM, counted
from scripts.instruction_problems import FAMILIES
from scripts.record_rocket import LATENCY, RTL

RECORD = FOLDER / "rocket_link.json"
RUNS = (
    ("lasso-5", "resident", 6), ("lasso-5", "resident", 3), ("svm-3", "resident", 6), ("small_lp-100", "resident", 6),
    ("powered_descent-8", "resident", 6), ("lasso-5", "paper", 6), ("lasso-5", "paper", 3), ("svm-3", "paper", 6),
    ("small_lp-100", "paper", 6), ("powered_descent-8", "paper", 6), ("svm-10", "resident", 6), ("lasso-20", "resident", 6),
    ("powered_descent-20", "resident", 6), ("robust_kalman-15", "resident", 6), ("six_dof-6", "resident", 6), ("lasso-20", "paper", 6),
)  # fmt: skip
ORDERS = range(3)
"""0: as programs are linked; others are seeds."""
ENGINE = Engine(lanes=4, banks=16, address_bits=16)
"""As of the table in docs/whole-chip.md, so that they share a model."""
REGISTERS = {"launch": (4, 0), "interrupt": (1, 3)}
"""Writes and reads: a frame; an acknowledgement, the status and two words of flags."""
PUBLISH = {"publish": (4, 3)}
"""A frame and three reads. It has a price beside them: under `paper` it comes after stages of the core, whose data take its place in the
caches."""
LINK_PARTS = ("put", "get", "publish")
PARTS = (*LINK_PARTS, "launch", "interrupt")

Sizes = dict[str, dict[str, int]]
"""By direction: how many transfers there are by their bytes."""
Parts = dict[str, list[int]]
"""Runs and clocks of the core by part."""


class Row(NamedTuple):
    """A run: its transfers, and what its parts take, by order."""

    name: str
    partition: str
    ratio: int
    transfers: Sizes
    orders: list[Parts]


def posed(name: str) -> Posed:
    """A problem of instruction_problems.py."""
    family, _, size = name.rpartition("-")
    return Posed(FAMILIES[family][0](int(size)), Settings())


def simulated(problem: Posed, partition: str | None, ratio: float, order: int) -> Counted:
    """A solve from cold, its program linked in an order."""
    found = counted(
        problem, RTL, partition=partition, engine=ENGINE, ratio=ratio, latency=LATENCY, order=order,
        machine_of=lambda _: Machine.built(RTL, ENGINE, FORM, 0),
    )  # fmt: skip
    if not found.same_bits:
        raise SystemExit(f"order {order}: other bits than the host's")
    return found


def parts_of(run: Counted) -> Parts:
    """Those of PARTS."""
    return {
        part.name: [part.runs, part.core_cycles] for part in (*run.stages, *run.within) if part.name in PARTS
    }


def transfers(problem: Posed, partition: str) -> Sizes:
    """Of a solve, as the model has them: an empty buffer is none."""
    scheduler = PsScheduler()
    scheduler(*problem)
    trace, split = parse_trace(scheduler.trace), load_partition(partition)
    durations = Durations(trace, load_platform(DEVICE), split)
    found = {"put": Counter[str](), "get": Counter[str]()}
    for action in actions_of(trace, split):
        if action.work.kind == "copy":
            direction = "put" if action.work.side == "pl" else "get"
            found[direction][str(durations.size_bytes(action.work))] += 1
    return {direction: dict(sizes) for direction, sizes in found.items()}


def fitted(rows: list[Row]) -> dict[str, float]:
    """Parameters of `[link]` and the interrupt's, by their names in rocket_soc.toml, with the least squares of relative errors.

    Of transfers, of a run's clocks in one direction; of REGISTERS, of the clocks of each. Both are means of a run's orders.
    """
    moves = _relative(*_transfers(rows))
    registers = _relative(*_registers(rows, REGISTERS))
    terms, clocks = _registers(rows, PUBLISH)
    published = np.average(clocks - terms @ registers, weights=clocks**-2.0)
    return {
        "register_write_ns": round(float(registers[0]), 1),
        "register_write_pl_cycles": round(float(registers[1]), 2),
        "register_read_fixed_ns": round(float(registers[2]), 1),
        "register_read_pl_cycles": round(float(registers[3]), 2),
        "publish_ns": round(float(published), 1),
        "first_ns": round(float(registers[4]), 0),
        "interrupt_entry_us": round(float(registers[5]) / 1000.0, 3),
        "dma_fixed_us": round(float(moves[0]) / 1000.0, 3),
        "dma_fixed_pl_cycles": round(float(moves[1]), 1),
        "dma_first_ns_per_byte": round(float(moves[2]), 2),
        "dma_cached_ns_per_byte": round(float(moves[3]), 3),
        "dma_to_pl_bytes_per_pl_cycle": round(1.0 / float(moves[4]), 2),
        "dma_to_ps_bytes_per_pl_cycle": round(1.0 / float(moves[5]), 2),
    }


def errors(rows: list[Row]) -> np.ndarray:
    """Of the fitted law, relative, of each run's transfers both ways."""
    terms, clocks = _transfers(rows)
    modelled = terms @ _relative(terms, clocks)
    return np.asarray(modelled.reshape(-1, 2).sum(axis=1) / clocks.reshape(-1, 2).sum(axis=1) - 1.0)


def _relative(terms: np.ndarray, clocks: np.ndarray) -> np.ndarray:
    """Parameters, none below zero, with the least squares of relative errors."""
    return np.asarray(nnls(terms / clocks[:, None], np.ones_like(clocks))[0])


def _transfers(rows: list[Row]) -> tuple[np.ndarray, np.ndarray]:
    """What the law of hw_model/timing/link.py says of each run and direction, as a matrix of its parameters (clocks of the core a
    transfer, of the engine, of the core a byte of the first burst and of what a cache may hold, of the engine a byte to the PL and to the
    core), and the clocks. Memory is faster than either at these ratios."""
    terms, clocks = [], []
    for row in rows:
        for direction, sizes in row.transfers.items():
            put, found = direction == "put", np.zeros(6)
            for size, count in ((int(size), count) for size, count in sizes.items()):
                beginning = (min(size, BURST_BYTES), put * min(size, CACHED_BYTES))
                rest = (row.ratio * size * put, row.ratio * size * (not put))
                found += count * np.array([1.0, row.ratio, *beginning, *rest])
            terms.append(found)
            clocks.append(np.mean([order[direction][1] for order in row.orders]))
    return np.array(terms), np.array(clocks)


def _registers(rows: list[Row], parts: dict[str, tuple[int, int]]) -> tuple[np.ndarray, np.ndarray]:
    """The same of parts with these writes and reads, of each run and part: clocks of the core and of the engine a write, a read,
    what an attempt's first takes more, and the entry of an interrupt, whose handler is rehearsed (rtl/soc/program/interrupts.c)."""
    terms, clocks = [], []
    for row in rows:
        for part, (writes, reads) in parts.items():
            each = [order[part] for order in row.orders]
            first = (part != "interrupt") / each[0][0]
            accesses = (writes, row.ratio * writes, reads, row.ratio * reads)
            terms.append([*accesses, first, float(part == "interrupt")])
            clocks.append(np.mean([spent / runs for runs, spent in each]))
    return np.array(terms), np.array(clocks)


def read() -> list[Row]:
    """The record."""
    if not RECORD.exists():
        return []
    document = json.loads(RECORD.read_text(encoding="utf-8"))
    return [Row(*row) for row in document["rows"]]


def write(rows: list[Row]) -> dict[str, float]:
    """The record of these rows, and their law."""
    law = fitted(rows)
    lines = ",\n".join(json.dumps(row) for row in rows)
    RECORD.write_text(f'{{"law": {json.dumps(law)},\n"rows": [\n{lines}\n]}}\n', encoding="utf-8")
    return law


def count() -> None:
    """The runs that are not on record."""
    rows = {row[:3]: row for row in read()}
    for name, partition, ratio in RUNS:
        problem = posed(name)
        row = rows.setdefault(
            (name, partition, ratio), Row(name, partition, ratio, transfers(problem, partition), [])
        )
        for order in ORDERS[len(row.orders) :]:
            row.orders.append(parts_of(simulated(problem, partition, ratio, order)))
            write([*rows.values()])
            sys.stdout.write(f"{name}, {partition}, {ratio}, order {order}: counted\n")


def main() -> int:
    """Count what is missing, and fit."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--fit", action="store_true", help="count nothing")
    if not parser.parse_args().fit:
        count()
    sys.stdout.write(f"{json.dumps(write(read()))}\n")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
