"""Count small problems on the simulated chip and fit the price of its core: hw_model/timing/rocket.json.

    PYTHONPATH=. .venv/bin/python -m scripts.record_rocket          # simulates what is not on record, minutes a problem
    PYTHONPATH=. .venv/bin/python -m scripts.record_rocket --fit    # fits the record anew

The core runs alone, with memory of LATENCY clocks, the first ITERATIONS of each problem. Nothing is fitted to `rec1`, a rendezvous
or a model-predictive controller: those are for judging (docs/whole-chip.md).
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import nnls

from hw_model.timing.instructions import FOLDER, SCHEMA, features, place, summed, words_of
from hw_model.timing.ps import ALONE
from hw_model.timing.trace import Pattern, parse_trace
from orbsoc.conic.problem import Problem
from orbsoc.conic.settings import Settings
from orbsoc.hw.emulation import PsScheduler
from orbsoc.hw.schedules import Engine
from orbsoc.soc.counted import Counted, parsed
from orbsoc.soc.machine import Machine
from orbsoc.soc.program import compiled
from orbsoc.soc.runs import FORM, cache_folder, stage_names
from scripts.instruction_problems import FAMILIES

RECORD = FOLDER / "rocket.json"
RTL = Path(__file__).resolve().parent.parent / "rtl"
LATENCY, ITERATIONS = 20, 1
PROBLEMS = (
    "portfolio-10", "lasso-5", "svm-3", "group_lasso-1", "one_cone-10", "huber-3", "robust_kalman-5", "powered_descent-4",
    "powered_descent-8", "small_lp-100", "six_dof-3", "one_cone-61",
)  # fmt: skip
"""Families of instruction_problems.py with the sizes that are counted."""
CHARGED = ("run", "multiply_add", "mul", "add", "sub", "div_sqrt", "other", "words", "unknowns", "nonzeros_kkt", "stored_l")
"""What a stage's law may charge for: less than hw_model.timing.instructions.features, for fewer problems are counted."""
WAITS = ("cycles_per_instruction", "multiply_add_stall_cycles", "operation_stall_cycles", "word_stall_cycles", "div_f64_cycles",
         "sqrt_f64_cycles")  # fmt: skip


class Row(NamedTuple):
    """A problem's pattern, and of each stage runs, clocks and instructions; "rest" is the solve without its stages."""

    name: str
    pattern: Pattern
    stages: dict[str, list[int]]


def simulated(problem: Problem) -> Counted:
    """The problem's first iterations on the core alone."""
    settings = Settings(max_iterations=ITERATIONS)
    program = compiled(problem, settings, RTL, cache_folder(), partition=None, engine=Engine(), form=FORM)
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


def pattern_of(name: str) -> Pattern:
    """Of a problem, as the solver records it."""
    family, _, size = name.rpartition("-")
    scheduler = PsScheduler()
    scheduler(FAMILIES[family][0](int(size)))
    return parse_trace(scheduler.trace).patterns[0]


def fitted(rows: list[Row]) -> dict[str, Any]:
    """Per stage the costs in instructions; of the rest the costs in clocks; and what an instruction and waits cost."""
    costs = {
        stage: _costs([(_charges(stage, row.pattern), row.stages[stage][2] / row.stages[stage][0]) for row in rows])
        for stage in sorted({name for row in rows for name in row.stages if name in row.pattern.stages})
    }  # fmt: skip
    rest = _costs([(_of_rest(row.pattern), row.stages["rest"][1]) for row in rows])
    charges, share = list[list[float]](), list[float]()
    for row in rows:
        total = sum(cycles for _, cycles, _ in row.stages.values())
        for name, (runs, cycles, instructions) in row.stages.items():
            if name in row.pattern.stages:
                stage = row.pattern.stages[name]
                of_a_run = (
                    instructions / runs, stage.count("mul_add", "mul_sub"), stage.count(*ALONE), words_of(stage, row.pattern),
                    stage.count("div"), stage.count("sqrt"),
                )  # fmt: skip
                charges.append([charge * runs / cycles for charge in of_a_run])
                share.append((cycles / total) ** 0.5)
    waits = nnls(np.array(charges) * np.array(share)[:, None], np.array(share))[0]
    return {
        "waits": {name: round(float(x), 2) for name, x in zip(WAITS, waits, strict=True)},
        "rest": rest,
        "costs": costs,
    }


def _charges(stage: str, pattern: Pattern) -> dict[str, float]:
    found = features(pattern.stages[stage], pattern)
    return {name: found[name] for name in CHARGED if name in found}


def _of_rest(pattern: Pattern) -> dict[str, float]:
    return {"run": 1, "unknowns": pattern.n + pattern.p + pattern.m, "nonzeros_kkt": pattern.nnz_kkt}


def _costs(known: list[tuple[dict[str, float], float]]) -> dict[str, float]:
    """None negative, with the least squares of the relative errors."""
    charges = np.array([list(charge.values()) for charge, _ in known], float) / np.array([[y] for _, y in known])
    scale = np.maximum(charges.max(axis=0), 1e-12)
    cost = nnls(charges / scale, np.ones(len(known)), maxiter=20_000)[0] / scale
    return {name: float(f"{c:.4g}") for name, c in zip(known[0][0], cost, strict=True) if c > 0.0}


def read() -> list[Row]:
    """The record's counts with their patterns."""
    if not RECORD.exists():
        return []
    found = json.loads(RECORD.read_text(encoding="utf-8"))["counts"]
    return [Row(name, pattern_of(name), stages) for name, stages in found.items()]


def write(rows: list[Row]) -> None:
    """Counts, and the law fitted to them."""
    law = fitted(rows)
    measured: list[dict[str, Any]] = []
    for row in rows:
        logarithms = {
            stage: round(float(np.log(row.stages[stage][2] / row.stages[stage][0] / summed(costs, _charges(stage, row.pattern)))), 4)
            for stage, costs in law["costs"].items()
            if stage in row.stages
        }  # fmt: skip
        measured.append({"name": row.name, "place": [round(x, 4) for x in place(row.pattern)], "logarithms": logarithms})
    record: dict[str, Any] = {
        "schema": SCHEMA, "core": "Rocket RV64GC", "emulator": f"the chip in RTL, memory of {LATENCY} clocks",
        "compiler": "riscv64-unknown-elf-gcc -O3", "commit": "of this record", "command": "python -m scripts.record_rocket",
        **law,
    }  # fmt: skip
    lines = [f'"{key}": {json.dumps(value)}' for key, value in record.items()]
    counts = ",\n".join(f'"{row.name}": {json.dumps(row.stages)}' for row in rows)
    lines += [f'"counts": {{\n{counts}\n}}', '"measured": [\n' + ",\n".join(map(json.dumps, measured)) + "\n]"]
    RECORD.write_text("{" + ",\n".join(lines) + "}\n", encoding="utf-8")


def main() -> int:
    """Simulate what is missing, and fit."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--fit", action="store_true", help="simulate nothing")
    only_fit = parser.parse_args().fit
    rows = read()
    for name in [] if only_fit else PROBLEMS:
        if name not in {row.name for row in rows}:
            family, _, size = name.rpartition("-")
            counts = simulated(FAMILIES[family][0](int(size)))
            rows.append(Row(name, pattern_of(name), stages_of(counts)))
            write(rows)
            sys.stdout.write(f"{name}: {counts.core_cycles} clocks\n")
    write(rows)
    sys.stdout.write(f"{json.dumps(fitted(rows)['waits'])}\n")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
