"""Count executed instructions on 64-bit Arm and fit their law: hw_model/timing/instructions.json.

    PYTHONPATH=. .venv/bin/python -m scripts.record_instructions

Cross-compiles `orbsoc-bench`, solves the problems of instruction_problems.py under QEMU with the plugin
count_instructions.c, and prints how far the law is from patterns that it has not seen. Needs gcc-aarch64-linux-gnu,
qemu-user, llvm-19 and `rustup target add aarch64-unknown-linux-gnu`. The build takes minutes, the rest one.
"""

from __future__ import annotations

import argparse
import json
import math
import re
import subprocess
import sys
import tempfile
from collections import defaultdict
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import nnls

from hw_model.timing.instructions import RECORD, SCHEMA, InstructionLaw, features, place, recorded, summed
from hw_model.timing.trace import Pattern, parse_trace
from orbsoc.hw.emulation import PsScheduler
from scripts.instruction_problems import problems

ROOT = Path(__file__).resolve().parent.parent
TARGET = "aarch64-unknown-linux-gnu"
FLAGS = "-C target-feature=+crt-static -C relocation-model=static"
"""Static at fixed addresses: what QEMU counts is where the disassembly says."""
CORES = ("cortex-a53", "cortex-a72")
HOT = 0.85
"""Share of the instructions whose blocks go through the pipeline model."""
MOST_BLOCKS = 400


class Count(NamedTuple):
    """Of one stage in one solve."""

    runs: int
    instructions: int

    @property
    def each(self) -> float:
        """Instructions of one run."""
        return self.instructions / self.runs


class Counted(NamedTuple):
    """A pattern, and its counts by stage."""

    name: str
    held_out: bool
    pattern: Pattern
    stages: dict[str, Count]


def build() -> Path:
    """The program that is counted."""
    subprocess.run(
        [
            "cargo", "build", "--release", "--locked", "-p", "orbsoc-bench", "--target", TARGET,
            "--config", f"target.{TARGET}.rustflags='{FLAGS}'",
        ],
        cwd=ROOT,
        check=True,
    )  # fmt: skip
    return ROOT / "target" / TARGET / "release" / "orbsoc-bench"


def count(bench: Path, files: list[Path], folder: Path) -> tuple[list[dict[str, Count]], list[list[int]]]:
    """Per file the counts of its stages; and the blocks of code that ran, as (address, instructions, executions)."""
    plugin, marks = folder / "count.so", folder / "marks.txt"
    source = ROOT / "scripts" / "count_instructions.c"
    subprocess.run(["gcc", "-shared", "-fPIC", "-O2", source, "-o", plugin], check=True)
    done = subprocess.run(
        ["qemu-aarch64", "-plugin", f"{plugin},out={marks}", bench, "--marks", *files],
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    names = done.stdout.splitlines()[0].split()[1:]
    solves: list[defaultdict[str, list[int]]] = []
    blocks: list[list[int]] = []
    last, of_a_mark = ("", 0), 0
    for line in marks.read_text().splitlines():
        kind, *fields = line.split()
        if kind == "block":
            blocks.append([int(field, 0) for field in fields])
            continue
        mark, now = names[int(fields[0])], int(fields[1])
        if mark == "problem" and last[0] == "problem":
            of_a_mark = now - last[1]
            solves.append(defaultdict(lambda: [0, 0]))
        elif mark == "outside":
            found = solves[-1][last[0]]
            found[0] += 1
            found[1] += now - last[1] - of_a_mark
        last = (mark, now)
    return [{name: Count(*pair) for name, pair in solve.items()} for solve in solves], blocks


def fit(rows: list[Counted]) -> dict[str, dict[str, float]]:
    """Per stage the costs, none negative, with the least squares of the relative errors."""
    costs: dict[str, dict[str, float]] = {}
    for stage in sorted({name for row in rows for name in row.pattern.stages}):
        known = [row for row in rows if stage in row.stages]
        if not known:
            continue
        found = [features(row.pattern.stages[stage], row.pattern) for row in known]
        charges = np.array([list(each.values()) for each in found], float)
        charges /= np.array([[row.stages[stage].each] for row in known])
        scale = np.maximum(charges.max(axis=0), 1e-12)
        cost = nnls(charges / scale, np.ones(len(known)), maxiter=20_000)[0] / scale
        costs[stage] = {name: float(f"{c:.4g}") for name, c in zip(found[0], cost, strict=True) if c > 0.0}
    return costs


def errors(law: InstructionLaw, row: Counted) -> tuple[float, float, str]:
    """Relative error of a solve's total, and the worst of a stage that takes a twentieth of it or more, with its name."""
    known = {name: found for name, found in row.stages.items() if name in law.costs}
    total = sum(found.instructions for found in known.values())
    said = {name: law.instructions(name, row.pattern) for name in known}
    worst = max(
        (abs(said[name] / found.each - 1.0), name)
        for name, found in known.items()
        if found.instructions >= 0.05 * total
    )
    modelled = sum(said[name] * found.runs for name, found in known.items())
    return modelled / total - 1.0, *worst


def pipeline(bench: Path, blocks: list[list[int]]) -> dict[str, dict[str, float]]:
    """Cycles per instruction of the kernels' hottest blocks: by issue alone, repeated, and run once by themselves."""
    assembly = _kernels(bench)
    inside = [block for block in blocks if all(block[0] + 4 * k in assembly for k in range(block[1]))]
    inside.sort(key=lambda block: -block[1] * block[2])
    total, covered, hot = sum(block[1] * block[2] for block in inside), 0, list[list[int]]()
    for block in inside[:MOST_BLOCKS]:
        if covered > HOT * total:
            break
        hot.append(block)
        covered += block[1] * block[2]
    regions = [
        "\n".join([f"# LLVM-MCA-BEGIN {k}", *(assembly[at + 4 * i] for i in range(length)), "# LLVM-MCA-END"])
        for k, (at, length, _) in enumerate(hot)
    ]
    text = "\n".join(regions) + "\n"
    weights = [block[2] for block in hot]
    executed = sum(block[1] * block[2] for block in hot)

    def per_instruction(cycles: list[float]) -> float:
        return round(sum(c * w for c, w in zip(cycles, weights, strict=True)) / executed, 3)

    found: dict[str, dict[str, float]] = {"covered": {"share": round(covered / total, 3)}}
    for core in CORES:
        many, once = (_analysed(text, core, repeats) for repeats in (100, 1))
        found[core] = {
            "issue": per_instruction(_numbers(r"Block RThroughput:\s+([\d.]+)", many)),
            "repeated": per_instruction([c / 100 for c in _numbers(r"Total Cycles:\s+(\d+)", many)]),
            "once": per_instruction(_numbers(r"Total Cycles:\s+(\d+)", once)),
        }
    return found


def _kernels(bench: Path) -> dict[int, str]:
    """Instructions of the stages' code by address."""
    listing = subprocess.run(
        ["aarch64-linux-gnu-objdump", "-d", "--no-show-raw-insn", bench],
        capture_output=True, text=True, check=True,
    ).stdout  # fmt: skip
    inside, found = False, dict[int, str]()
    for line in listing.splitlines():
        if heading := re.match(r"[0-9a-f]+ <(.*)>:", line):
            inside = re.search("by_itself|dispatch|kernels", heading[1]) is not None
        elif inside and (here := re.match(r"\s*([0-9a-f]+):\s+(\S+)\s*([^/;]*)", line)):
            operands = re.sub(r"\b[0-9a-f]+ <[^>]*>", ".Lelsewhere", here[3]).strip()
            found[int(here[1], 16)] = f"{here[2]} {operands}"
    return found


def _analysed(text: str, core: str, repeats: int) -> str:
    command = ["llvm-mca-19", "--mtriple=aarch64-linux-gnu", f"-mcpu={core}", f"-iterations={repeats}"]
    return subprocess.run(command, input=text, capture_output=True, text=True, check=True).stdout


def _numbers(pattern: str, text: str) -> list[float]:
    return [float(number) for number in re.findall(pattern, text)]


def _first_line(*command: str) -> str:
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    return done.stdout.splitlines()[0]


def main() -> int:
    """Count, fit, write, and print the errors."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--bench", type=Path, help="an orbsoc-bench for the target, built before")
    bench = parser.parse_args().bench or build()
    named = list(problems())
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        files = [folder / f"{name}.json" for name, _, _ in named]
        for file, (_, _, problem) in zip(files, named, strict=True):
            problem.save(file)
        counts, blocks = count(bench, files, folder)
    rows: list[Counted] = []
    for (name, held_out, problem), stages in zip(named, counts, strict=True):
        scheduler = PsScheduler()
        scheduler(problem)
        rows.append(Counted(name, held_out, parse_trace(scheduler.trace).patterns[0], stages))
    known = [row for row in rows if not row.held_out]
    costs = fit(known)

    def logarithms(row: Counted) -> dict[str, float]:
        found: dict[str, float] = {}
        for stage in row.pattern.stages:
            if stage in row.stages and stage in costs:
                by_law = summed(costs[stage], features(row.pattern.stages[stage], row.pattern))
                found[stage] = round(math.log(row.stages[stage].each / by_law), 4)
        return found

    record: dict[str, Any] = {
        "schema": SCHEMA,
        "core": "Cortex-A53, NEON",
        "emulator": _first_line("qemu-aarch64", "--version"),
        "compiler": _first_line("rustc", "--version"),
        "commit": _first_line("git", "rev-parse", "--short=12", "HEAD"),
        "command": "python -m scripts.record_instructions",
        "pipeline": pipeline(bench, blocks),
        "costs": costs,
        "measured": [
            {"name": row.name, "place": [round(x, 4) for x in place(row.pattern)], "logarithms": logarithms(row)}
            for row in known
        ],
        "held_out": [
            {"name": row.name, "stages": {stage: list(found) for stage, found in row.stages.items()}}
            for row in rows
            if row.held_out
        ],
        "totals": {row.name: sum(found.instructions for found in row.stages.values()) for row in rows},
    }  # fmt: skip
    lines = [f'"{key}": {json.dumps(value)}' for key, value in record.items() if key != "measured"]
    measured = ",\n".join(json.dumps(row) for row in record["measured"])
    RECORD.write_text("{" + ",\n".join([*lines, f'"measured": [\n{measured}\n]']) + "}\n", encoding="utf-8")
    recorded.cache_clear()
    law = recorded()
    for row in rows:
        total, worst, stage = errors(law, row)
        kind = "held out" if row.held_out else "fitted"
        sys.stdout.write(f"{row.name:28s} {kind:8s} total {total:+6.1%}  worst stage {worst:5.1%} {stage}\n")
    sys.stdout.write(f"{json.dumps(record['pipeline'])}\n")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
