"""Count transfers between the two halves of the simulated chip, fit its link: hw_model/timing/rocket_link.json.

    PYTHONPATH=. .venv/bin/python -m scripts.record_rocket_link          # what is not on record, minutes a problem
    PYTHONPATH=. .venv/bin/python -m scripts.record_rocket_link --fit    # fits the record anew

RUNS are on the chip: problems, each under a partition and at a ratio of the clocks. `resident` moves buffers once a solve, with caches that do
not have them; `paper` moves them again and again. The law is that of hw_model/timing/link.py. None
of them is an insertion, a rendezvous, a phasing, a model-predictive controller or passive safety: those are for judging.
"""

from __future__ import annotations

import argparse
import json
import sys
from typing import NamedTuple

import numpy as np
from scipy.optimize import least_squares

from hw_model import load_partition, load_platform
from hw_model.timing.actions import actions_of
from hw_model.timing.durations import Durations
from hw_model.timing.instructions import FOLDER
from hw_model.timing.trace import parse_trace
from orbsoc.conic.settings import Settings
from orbsoc.hw.emulation import PsScheduler
from orbsoc.hw.exact_cycles import exact_cycles
from orbsoc.hw.schedules import Engine
from orbsoc.hw.workload import Posed
from orbsoc.soc.machine import Machine
from orbsoc.soc.runs import FORM, counted
from scripts.instruction_problems import FAMILIES
from scripts.record_rocket import LATENCY, RTL

RECORD = FOLDER / "rocket_link.json"
RUNS = (
    ("lasso-5", "resident", 6), ("lasso-5", "resident", 3), ("svm-3", "resident", 6), ("small_lp-100", "resident", 6),
    ("powered_descent-8", "resident", 6), ("lasso-5", "paper", 6), ("lasso-5", "paper", 3), ("svm-3", "paper", 6),
    ("small_lp-100", "paper", 6), ("powered_descent-8", "paper", 6),
)  # fmt: skip
ENGINE = Engine(lanes=4, banks=16, address_bits=16)
"""As of the table in docs/whole-chip.md, so that they share a model."""
WIDTH = 8.0
"""Bytes that the DMA's port of the engine takes in a clock at most."""
REGISTER_ACCESSES = 7
"""Of a PUBLISH: four of its frame, STATUS, two words of flags."""
PARTS = ("put", "get", "publish", "launch", "interrupt")


class Row(NamedTuple):
    """Clocks of the core by part, each with its runs; and bytes that cross, by direction, buffer by buffer."""

    name: str
    partition: str
    ratio: int
    parts: dict[str, list[int]]
    bytes_to: dict[str, list[int]]


def posed(name: str) -> Posed:
    """A problem of instruction_problems.py."""
    family, _, size = name.rpartition("-")
    return Posed(FAMILIES[family][0](int(size)), Settings())


def simulated(name: str, partition: str, ratio: int) -> dict[str, list[int]]:
    """Runs and clocks of the parts of PARTS."""
    found = counted(
        posed(name), RTL, partition=partition, engine=ENGINE, ratio=ratio, latency=LATENCY,
        machine_of=lambda _: Machine.built(RTL, ENGINE, FORM, 0),
    )  # fmt: skip
    if not found.same_bits:
        raise SystemExit(f"{name}: other bits than the host's")
    return {
        part.name: [part.runs, part.core_cycles]
        for part in (*found.stages, *found.within)
        if part.name in PARTS
    }


def crossing(name: str, partition: str) -> dict[str, list[int]]:
    """Bytes of the buffers that cross, "pl": to the PL, "ps": to the core."""
    scheduler, split = PsScheduler(), load_partition(partition)
    scheduler(*posed(name))
    trace = parse_trace(scheduler.trace)
    durations = Durations(trace, load_platform("rocket_soc"), split, exact_cycles([posed(name).problem]))
    found: dict[str, list[int]] = {"pl": [], "ps": []}
    for action in actions_of(trace, split):
        if action.work.kind == "copy":
            found[action.work.side].append(durations.size_bytes(action.work))
    return found


def fitted(rows: list[Row]) -> dict[str, float]:
    """Parameters of `[link]` and the interrupt's, by their names in rocket_soc.toml, with the least squares of relative errors.

    Transfers are those of `resident`; registers and interrupts those of `paper`, where they come again, warm: once a solve they take a
    third more, and little of the whole.
    """
    once, again = ([row for row in rows if row.partition == name] for name in ("resident", "paper"))
    each = np.array([row.parts["publish"][1] / row.parts["publish"][0] / REGISTER_ACCESSES for row in again])
    ratios = np.array([row.ratio for row in again], float)
    fixed, cycles = np.linalg.lstsq(
        np.column_stack([np.ones_like(ratios), ratios]) / each[:, None], np.ones_like(each), rcond=None
    )[0]

    def errors(law: np.ndarray) -> list[float]:
        return [modelled(row, side, law) / row.parts[part][1] - 1.0 for row in once for part, side in (("put", "pl"), ("get", "ps"))]  # fmt: skip

    law = least_squares(
        errors,
        [400.0, 15.0, 6.0, 5.0],
        bounds=(0.0, [np.inf, np.inf, WIDTH, WIDTH]),
        x_scale=[100.0, 10.0, 1.0, 1.0],
    ).x
    accesses = 4  # STATUS, two words of flags, IRQ_ACK
    entry = [
        row.parts["interrupt"][1] / row.parts["interrupt"][0] - accesses * (fixed + cycles * row.ratio)
        for row in again
    ]
    return {
        "register_ns": round(float(fixed), 1),
        "register_pl_cycles": round(float(cycles), 2),
        "dma_fixed_us": round(float(law[0]) / 1000.0, 3),
        "dma_fixed_pl_cycles": round(float(law[1]), 1),
        "dma_to_pl_bytes_per_pl_cycle": round(float(law[2]), 2),
        "dma_to_ps_bytes_per_pl_cycle": round(float(law[3]), 2),
        "interrupt_entry_us": round(max(0.0, float(np.mean(entry))) / 1000.0, 3),
    }


def modelled(row: Row, side: str, law: np.ndarray) -> float:
    """Clocks of the transfers to one side, by the law of hw_model/timing/link.py: fixed clocks of the core and of the engine, bytes
    a clock of the engine to the PL and to the core. Memory is faster than either at these ratios."""
    rate = law[2 if side == "pl" else 3] / row.ratio
    return float(sum(law[0] + law[1] * row.ratio + size / rate for size in row.bytes_to[side]))


def read() -> list[Row]:
    """The record."""
    if not RECORD.exists():
        return []
    document = json.loads(RECORD.read_text(encoding="utf-8"))
    return [Row(*row) for row in document["rows"]]


def main() -> int:
    """Count what is missing, and fit."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--fit", action="store_true", help="count nothing")
    only_fit = parser.parse_args().fit
    rows = read()
    for run in () if only_fit else RUNS:
        if run not in {row[:3] for row in rows}:
            name, partition, ratio = run
            rows.append(Row(*run, simulated(*run), crossing(name, partition)))
            write(rows)
            sys.stdout.write(f"{name}, {partition}, ratio {ratio}: counted\n")
    sys.stdout.write(f"{json.dumps(write(rows))}\n")
    return 0


def write(rows: list[Row]) -> dict[str, float]:
    """The record of these rows, and their law."""
    law = fitted(rows)
    lines = ",\n".join(json.dumps(row) for row in rows)
    RECORD.write_text(f'{{"law": {json.dumps(law)},\n"rows": [\n{lines}\n]}}\n', encoding="utf-8")
    return law


if __name__ == "__main__":
    raise SystemExit(main())
