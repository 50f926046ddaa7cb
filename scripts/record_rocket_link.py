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
from scipy.optimize import nnls

from hw_model.timing.instructions import FOLDER
from orbsoc.conic.settings import Settings
from orbsoc.hw.schedules import Engine
from orbsoc.hw.workload import Posed
from orbsoc.soc.machine import Machine
from orbsoc.soc.program import compiled
from orbsoc.soc.runs import FORM, cache_folder, counted, lines_of
from orbsoc.soc.timeline import buffer_words
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
REGISTER_ACCESSES = 7
"""Of a PUBLISH: four of its frame, STATUS, two words of flags."""
PARTS = ("put", "get", "publish", "launch", "interrupt")


class Row(NamedTuple):
    """Clocks of the core by part, each with its runs; and each transfer, bytes and clocks, by direction, of a run that noted them."""

    name: str
    partition: str
    ratio: int
    parts: dict[str, list[int]]
    transfers: dict[str, list[list[int]]]


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


def noted(name: str, partition: str, ratio: int) -> dict[str, list[list[int]]]:
    """Bytes and clocks of each transfer, by direction; noting them takes clocks as well."""
    problem = posed(name)
    program = compiled(
        problem, RTL, cache_folder(), partition=partition, engine=ENGINE, form=FORM, warm=False, events=True
    )
    machine = Machine.built(RTL, ENGINE, FORM, 0)
    size_bytes = [8 * words for words in buffer_words(problem).values()]
    found: dict[str, list[list[int]]] = {"put": [], "get": []}
    for line in lines_of(machine.run(program.image, ratio=ratio, latency=LATENCY), lambda _: None):
        kind, *fields = line.split()
        if kind == "event" and fields[0] in ("p", "g"):
            buffer, begin, end = map(int, fields[1:])
            found["put" if fields[0] == "p" else "get"].append([size_bytes[buffer], end - begin])
    return found


def fitted(rows: list[Row]) -> dict[str, float]:
    """Parameters of `[link]` and the interrupt's, by their names in rocket_soc.toml, with the least squares.

    Of transfers, of their clocks, for it is sums of them that the model gives; what noting takes is left out, its mean by run and direction.
    Of registers and interrupts, of relative errors, under `paper`, where they come again, warm: once a solve they take a third more, and little of
    the whole.
    """
    again = [row for row in rows if row.partition == "paper"]
    each = np.array([row.parts["publish"][1] / row.parts["publish"][0] / REGISTER_ACCESSES for row in again])
    ratios = np.array([row.ratio for row in again], float)
    fixed, cycles = np.linalg.lstsq(
        np.column_stack([np.ones_like(ratios), ratios]) / each[:, None], np.ones_like(each), rcond=None
    )[0]
    law = nnls(*_transfers(rows))[0]
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
        "dma_to_pl_bytes_per_pl_cycle": round(1.0 / float(law[2]), 2),
        "dma_to_ps_bytes_per_pl_cycle": round(1.0 / float(law[3]), 2),
        "interrupt_entry_us": round(max(0.0, float(np.mean(entry))) / 1000.0, 3),
    }


def _transfers(rows: list[Row]) -> tuple[np.ndarray, np.ndarray]:
    """What the law of hw_model/timing/link.py says of each transfer of a byte or more, as a matrix of its parameters (fixed clocks of the
    core, of the engine, clocks of the engine a byte to the PL and to the core), and its clocks. Memory is faster than either at these ratios."""
    terms, clocks = [], []
    for row in rows:
        for direction, moved in row.transfers.items():
            noting = (sum(took for _, took in moved) - row.parts[direction][1]) / len(moved)
            for size, took in moved:
                if size:
                    sides = (size * (direction == "put"), size * (direction == "get"))
                    terms.append([1.0, row.ratio, *(row.ratio * each for each in sides)])
                    clocks.append(took - noting)
    return np.array(terms, float), np.array(clocks)


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
            rows.append(Row(*run, simulated(*run), noted(*run)))
            write(rows)
            sys.stdout.write(f"{', '.join(map(str, run))}: counted\n")
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
