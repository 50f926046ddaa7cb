"""Count small problems on the simulated chip, fit the price of its core: hw_model/timing/rocket.json.

    PYTHONPATH=. .venv/bin/python -m scripts.record_rocket          # what is not on record, minutes a problem
    PYTHONPATH=. .venv/bin/python -m scripts.record_rocket --fit    # fits the record anew

COUNTED problems run on the chip, the core alone, memory of LATENCY clocks, their first ITERATIONS: clocks and instructions. EXECUTED
ones, some larger, run the same program under QEMU: instructions alone, which are the chip's (tests/soc/test_rocket.py). Nothing is
fitted to `rec1`, a rendezvous, a model-predictive controller or passive safety: those are for judging (docs/whole-chip.md).
"""

from __future__ import annotations

import argparse
import json
import math
import subprocess
import sys
import tempfile
from pathlib import Path
from statistics import fmean
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import nnls

from hw_model.timing.instructions import FOLDER, SCHEMA, features, place, summed, words_of
from hw_model.timing.ps import ALONE, chained
from hw_model.timing.trace import Pattern, parse_trace
from orbsoc.conic.problem import Problem
from orbsoc.conic.settings import Settings
from orbsoc.flight.instructions import Tools
from orbsoc.flight.instructions import counted as executed_stages
from orbsoc.hw.emulation import PsScheduler
from orbsoc.hw.schedules import Engine
from orbsoc.hw.workload import Posed
from orbsoc.soc.counted import Counted, parsed
from orbsoc.soc.machine import Machine
from orbsoc.soc.program import compiled
from orbsoc.soc.runs import FORM, cache_folder, stage_names
from scripts.instruction_problems import FAMILIES

RECORD = FOLDER / "rocket.json"
RTL = Path(__file__).resolve().parent.parent / "rtl"
LATENCY, ITERATIONS = 20, 1
"""Of `portfolio-10` and `lasso-5` the record has three iterations."""
COUNTED = (
    "group_lasso-1", "huber-3", "lasso-5", "one_cone-10", "one_cone-61", "portfolio-10", "powered_descent-4", "powered_descent-8",
    "robust_kalman-5", "six_dof-3", "small_lp-100", "svm-3",
)  # fmt: skip
EXECUTED = (
    "portfolio-10", "powered_descent-15", "one_cone-61", "three_cones-60", "robust_kalman-25", "group_lasso-4", "svm-15",
    "lasso-20", "six_dof-6", "small_lp-128", "huber-10", "powered_descent-30", "portfolio-50", "one_cone-100",
)  # fmt: skip
"""Families of instruction_problems.py with sizes."""
COMPILED = ("-O3", "-march=rv64gc", "-mabi=lp64d", "-ffp-contract=off", "-fno-math-errno", "-static")
LIBRARY = Path("/usr/lib/picolibc/riscv64-unknown-elf/lib/rv64imafdc/lp64d/libc.a")
COPIES = ("memcpy-asm.S.o", "memcpy.c.o", "memmove.S.o", "memmove-stub.c.o", "memset.S.o")
"""Of the chip's library, linked before that of Linux, so that copies take the same instructions."""
CHARGED = (
    "run",
    "multiply_add",
    "mul",
    "add",
    "sub",
    "div_sqrt",
    "other",
    "words",
    "unknowns",
    "nonzeros_kkt",
    "stored_l",
)
"""What a stage's law may charge for."""
SPARED = ("solve_pair", "solve_kkt")
"""Stages that the core runs without a residual where no decision needs it: "NAME, spared"."""
WAITS = (
    "cycles_per_instruction", "multiply_add_stall_cycles", "operation_stall_cycles", "word_stall_cycles", "div_f64_cycles",
)  # fmt: skip


class Row(NamedTuple):
    """A problem that the chip ran: of each stage runs, clocks and instructions; "rest" is the solve without its stages."""

    name: str
    stages: dict[str, list[int]]


def simulated(problem: Problem) -> Counted:
    """The problem's first iterations on the core alone."""
    settings = Settings(max_iterations=ITERATIONS)
    program = compiled(
        Posed(problem, settings), RTL, cache_folder(), partition=None, engine=Engine(), form=FORM
    )
    lines: list[str] = []
    for line in Machine.built(RTL, None, FORM, 0).run(program.image, ratio=6.0, latency=LATENCY):
        lines += [] if line.startswith("@") else [line]
        if line.endswith("bits"):
            break
    counts = parsed(lines, stage_names())
    if not counts.same_bits:
        raise SystemExit(f"other bits than the host's: {lines[-1]}")
    return counts


def stages_of(counts: Counted) -> dict[str, list[int]]:
    """As the record has them."""
    found = {part.name: [part.runs, part.core_cycles, part.instructions] for part in counts.stages}
    cycles, instructions = (sum(row[k] for row in found.values()) for k in (1, 2))
    return found | {"rest": [1, counts.core_cycles - cycles, counts.instructions - instructions]}


def executed(problem: Problem) -> dict[str, float]:
    """Instructions of one run of each stage under QEMU."""
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        objects = folder / "copies"
        objects.mkdir()
        subprocess.run(["riscv64-unknown-elf-ar", "x", LIBRARY, *COPIES], cwd=objects, check=True)
        options = (*COMPILED, *(str(objects / name) for name in COPIES))
        tools = Tools("riscv64-linux-gnu-gcc", "qemu-riscv64", options)
        runs = executed_stages(folder, [problem], Settings(), 64, "spared", tools).runs
    return instructions_of(runs)


def instructions_of(runs: dict[str, list[int]]) -> dict[str, float]:
    """Means over runs, of which each second one is whole and the others are spared."""
    known = {name: row for name, row in runs.items() if name in stage_names() and len(row) > 1}
    whole = {name: round(fmean(row[1::2]), 1) for name, row in known.items()}
    return whole | {f"{name}, spared": round(fmean(known[name][0::2]), 1) for name in SPARED if name in known}


def pattern_of(name: str) -> Pattern:
    """Of a problem, as the solver records it."""
    family, _, size = name.rpartition("-")
    scheduler = PsScheduler()
    scheduler(FAMILIES[family][0](int(size)))
    return parse_trace(scheduler.trace).patterns[0]


def fitted(
    rows: list[Row], counts: dict[str, dict[str, float]], patterns: dict[str, Pattern]
) -> dict[str, Any]:
    """Per stage the costs in instructions; what an instruction of the rest costs in clocks; and what an instruction and waits cost."""
    stages = sorted({stage for found in counts.values() for stage in found})
    costs = {
        stage: _costs([(charges(stage, patterns[name]), found[stage]) for name, found in counts.items() if stage in found])
        for stage in stages
        if stage.partition(",")[0] in next(iter(patterns.values())).stages
    }  # fmt: skip
    rest = [row.stages["rest"] for row in rows]
    rest_law = _costs(
        [({"cycles_per_instruction": instructions}, cycles) for _, cycles, instructions in rest]
    )
    table, share = list[list[float]](), list[float]()
    for row in rows:
        total = sum(cycles for _, cycles, _ in row.stages.values())
        for name, (runs, cycles, instructions) in row.stages.items():
            stage = patterns[row.name].stages.get(name)
            if stage is not None:
                each = instructions / runs
                part = (
                    min(1.0, each / summed(costs[name], charges(name, patterns[row.name])))
                    if name in SPARED
                    else 1.0
                )
                waits = (
                    chained(name, stage), stage.count(*ALONE), words_of(stage, patterns[row.name]),
                    stage.count("div", "sqrt"),
                )  # fmt: skip
                table.append([charge * runs / cycles for charge in (each, *(part * wait for wait in waits))])
                share.append(math.sqrt(cycles / total))
    found = nnls(np.array(table) * np.array(share)[:, None], np.array(share))[0]
    return {
        "waits": {name: round(float(x), 2) for name, x in zip(WAITS, found, strict=True)},
        "rest": rest_law,
        "costs": costs,
    }


def charges(stage: str, pattern: Pattern) -> dict[str, float]:
    """What a stage's law may charge for."""
    found = features(pattern.stages[stage.partition(",")[0]], pattern)
    return {name: found[name] for name in CHARGED if name in found}


def _costs(known: list[tuple[dict[str, float], float]]) -> dict[str, float]:
    """None negative, with the least squares of the relative errors."""
    table = np.array([list(charge.values()) for charge, _ in known], float) / np.array(
        [[y] for _, y in known]
    )
    scale = np.maximum(table.max(axis=0), 1e-12)
    cost = nnls(table / scale, np.ones(len(known)), maxiter=20_000)[0] / scale
    return {name: float(f"{c:.4g}") for name, c in zip(known[0][0], cost, strict=True) if c > 0.0}


def read() -> tuple[list[Row], dict[str, dict[str, float]]]:
    """The record's counts on the chip, and under QEMU."""
    if not RECORD.exists():
        return [], {}
    found = json.loads(RECORD.read_text(encoding="utf-8"))
    return [Row(name, stages) for name, stages in found["counted"].items()], found["executed"]


def write(rows: list[Row], counts: dict[str, dict[str, float]]) -> dict[str, Any]:
    """Counts, and the law fitted to them, which it returns."""
    patterns = {name: pattern_of(name) for name in {*counts, *(row.name for row in rows)}}
    law = fitted(rows, counts, patterns)
    measured: list[dict[str, Any]] = []
    for name, found in counts.items():
        logarithms = {
            stage: round(math.log(found[stage] / summed(costs, charges(stage, patterns[name]))), 4)
            for stage, costs in law["costs"].items()
            if stage in found
        }
        measured.append(
            {"name": name, "place": [round(x, 4) for x in place(patterns[name])], "logarithms": logarithms}
        )
    record: dict[str, Any] = {
        "schema": SCHEMA, "core": "Rocket RV64GC", "emulator": f"qemu-riscv64, and the chip in RTL with memory of {LATENCY} clocks",
        "compiler": "gcc -O3", "commit": "of this record", "command": "python -m scripts.record_rocket", **law,
    }  # fmt: skip
    lines = [f'"{key}": {json.dumps(value)}' for key, value in record.items()]
    for key, table in (("counted", {row.name: row.stages for row in rows}), ("executed", counts)):
        lines.append(
            f'"{key}": {{\n'
            + ",\n".join(f'"{name}": {json.dumps(row)}' for name, row in table.items())
            + "\n}"
        )
    lines.append('"measured": [\n' + ",\n".join(map(json.dumps, measured)) + "\n]")
    RECORD.write_text("{" + ",\n".join(lines) + "}\n", encoding="utf-8")
    return law


def main() -> int:
    """Count what is missing, and fit."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--fit", action="store_true", help="count nothing")
    only_fit = parser.parse_args().fit
    rows, counts = read()
    for name in () if only_fit else EXECUTED:
        if name not in counts:
            family, _, size = name.rpartition("-")
            counts[name] = executed(FAMILIES[family][0](int(size)))
    for name in () if only_fit else COUNTED:
        if name not in {row.name for row in rows}:
            family, _, size = name.rpartition("-")
            rows.append(Row(name, stages_of(simulated(FAMILIES[family][0](int(size))))))
            sys.stdout.write(f"{name}: counted\n")
            write(rows, counts)
    sys.stdout.write(f"{json.dumps(write(rows, counts)['waits'])}\n")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
