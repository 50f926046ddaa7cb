"""Count executed instructions on Arm cores and fit their law: hw_model/timing/instructions.json.

    PYTHONPATH=. .venv/bin/python -m scripts.record_instructions

Cross-compiles `orbsoc-bench` for each core, solves the problems of instruction_problems.py under QEMU with the plugin
count_instructions.c, and prints how far the law of the first core is from patterns that it has not seen. Of the other
cores it records the instructions relative to the first. Needs gcc-aarch64-linux-gnu, gcc-arm-linux-gnueabihf, qemu-user,
llvm-19 and `rustup target add aarch64-unknown-linux-gnu armv7-unknown-linux-gnueabihf`. Each build takes minutes, the
rest one. `--keep-law` rewrites the comparison of the cores alone.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import re
import subprocess
import sys
import tempfile
from collections import defaultdict
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import nnls

from hw_model.timing.instructions import RECORD, SCHEMA, InstructionLaw, features, law_of, place, summed
from hw_model.timing.trace import Pattern, parse_trace
from orbsoc.conic.problem import Problem
from orbsoc.hw.emulation import PsScheduler
from scripts.instruction_problems import problems

ROOT = Path(__file__).resolve().parent.parent


class Core(NamedTuple):
    """A core, how the program is compiled for it, and what runs it."""

    name: str
    target: str
    tools: str
    """Prefix of the disassembler."""
    flags: str
    emulator: tuple[str, ...]
    pipelines: tuple[str, ...]
    """Cores whose pipelines LLVM models instruction by instruction."""
    left_out: str = ""
    """Instructions that the pipeline's model fails on, as a regular expression."""


STATIC = "-C relocation-model=static -C target-feature=+crt-static"
"""At fixed addresses: what QEMU counts is where the disassembly says."""
ARMV7, ARM_TOOLS = "armv7-unknown-linux-gnueabihf", "arm-linux-gnueabihf"
CORES = (
    Core(
        "Cortex-A53", "aarch64-unknown-linux-gnu", "aarch64-linux-gnu", STATIC,
        ("qemu-aarch64",), ("cortex-a53", "cortex-a72"),
    ),
    Core(
        "Cortex-A9", ARMV7, ARM_TOOLS, f"{STATIC},+neon -C target-cpu=cortex-a9",
        ("qemu-arm", "-cpu", "cortex-a9"), ("cortex-a9",), r"mul ",
    ),
    Core(
        "Cortex-A7", ARMV7, ARM_TOOLS, f"{STATIC},+neon -C target-cpu=cortex-a7",
        ("qemu-arm", "-cpu", "cortex-a7"), (),
    ),
    Core(
        "Cortex-R52", ARMV7, ARM_TOOLS, f"{STATIC},+neon -C target-cpu=cortex-r52 -C link-arg=-Wl,--no-warn-mismatch",
        ("qemu-arm", "-cpu", "max"), ("cortex-r52",), r"vmrs|vmov\w*\.(i32|f64) \w+, #",
    ),
)  # fmt: skip
"""The law is the first one's. Those of 32 bits run Arm instructions of four bytes, not Thumb; the flags are those of the
solver, the compiled standard library keeps its own. The R52's program is one of Linux, which that core does not run, so
that the linker objects to what of it is for which profile; the solver's instructions are those of the core."""
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


class Run(NamedTuple):
    """What one core executed."""

    stages: list[dict[str, Count]]
    """Of each problem."""
    answers: list[str]
    """Of each problem the iterations, the status and a hash of the answer's bits."""
    blocks: list[list[int]]
    """Blocks of code that ran, as (address, instructions, executions)."""


def build(core: Core) -> Path:
    """The program that is counted."""
    subprocess.run(
        [
            "cargo", "build", "--release", "--locked", "-p", "orbsoc-bench", "--target", core.target,
            "--config", f"target.{core.target}.rustflags='{core.flags}'",
        ],
        cwd=ROOT,
        check=True,
    )  # fmt: skip
    folder = ROOT / os.environ.get("CARGO_TARGET_DIR", "target")
    return folder / core.target / "release" / "orbsoc-bench"


def count(core: Core, bench: Path, files: list[Path], folder: Path) -> Run:
    """Solve every file once, and count its stages."""
    plugin, marks = folder / "count.so", folder / "marks.txt"
    source = ROOT / "python" / "orbsoc" / "flight" / "count_instructions.c"
    subprocess.run(["gcc", "-shared", "-fPIC", "-O2", source, "-o", plugin], check=True)
    done = subprocess.run(
        [*core.emulator, "-plugin", f"{plugin},out={marks}", bench, "--marks", *files],
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    first, *answers = done.stdout.splitlines()
    names = first.split()[1:]
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
    stages = [{name: Count(*pair) for name, pair in solve.items()} for solve in solves]
    return Run(stages, [answer.partition(" ")[2] for answer in answers], blocks)


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


def pipeline(core: Core, bench: Path, blocks: list[list[int]]) -> dict[str, dict[str, float]]:
    """Cycles per instruction of the kernels' hottest blocks: by issue alone, repeated, and run once by themselves."""
    assembly = _kernels(core, bench)
    inside = [block for block in blocks if all(block[0] + 4 * k in assembly for k in range(block[1]))]
    inside.sort(key=lambda block: -block[1] * block[2])
    total, covered, hot = sum(block[1] * block[2] for block in inside), 0, list[list[int]]()
    for block in inside[:MOST_BLOCKS]:
        if covered > HOT * total:
            break
        hot.append(block)
        covered += block[1] * block[2]
    text, weights, executed = "", list[int](), 0
    for k, (at, length, executions) in enumerate(hot):
        block = [assembly[at + 4 * i] for i in range(length)]
        if core.left_out:
            block = [each for each in block if not re.match(core.left_out, each)]
        if not block:
            continue
        text += "\n".join([f"# LLVM-MCA-BEGIN {k}", *map(_modelled, block), "# LLVM-MCA-END\n"])
        weights.append(executions)
        executed += len(block) * executions

    def per_instruction(cycles: list[float]) -> float:
        return round(sum(c * w for c, w in zip(cycles, weights, strict=True)) / executed, 3)

    found: dict[str, dict[str, float]] = {"covered": {"share": round(covered / total, 3)}}
    for name in core.pipelines:
        many, once = (_analysed(text, core, name, repeats) for repeats in (100, 1))
        found[name] = {
            "issue": per_instruction(_numbers(r"Block RThroughput:\s+([\d.]+)", many)),
            "repeated": per_instruction([c / 100 for c in _numbers(r"Total Cycles:\s+(\d+)", many)]),
            "once": per_instruction(_numbers(r"Total Cycles:\s+(\d+)", once)),
        }
    return found


def _kernels(core: Core, bench: Path) -> dict[int, str]:
    """Instructions of the stages' code by address."""
    listing = subprocess.run(
        [f"{core.tools}-objdump", "-d", "--no-show-raw-insn", bench],
        capture_output=True, text=True, check=True,
    ).stdout  # fmt: skip
    inside, found = False, dict[int, str]()
    for line in listing.splitlines():
        if heading := re.match(r"[0-9a-f]+ <(.*)>:", line):
            inside = re.search("by_itself|dispatch|kernels", heading[1]) is not None
        elif inside and (here := re.match(r"\s*([0-9a-f]+):\s+(\S+)\s*([^/;]*)", line)):
            operands = re.sub(r"\b[0-9a-f]+ <[^>]*>", ".Lelsewhere", here[3]).strip()
            # Of a constant, the assembler takes the value that stands beside its encoding.
            operands = re.sub(r"#\d+\s+@ 0x[0-9a-f]+\s+(-?[\d.]+)$", r"#\1", operands)
            found[int(here[1], 16)] = f"{here[2]} {operands}"
    return found


def _modelled(instruction: str) -> str:
    """What LLVM's models know instead of an instruction of 32-bit Arm that they do not know.

    For several registers at once, a load or a store of each, and the addition that moves the address.
    """
    if several := re.match(r"v(ld|st)mia(\w*) (\w+)(!?), \{(.*)\}", instruction):
        which, condition, base, moves, registers = several.groups()
        ends = [[int(end[1:]) for end in part.strip().split("-")] for part in registers.split(",")]
        each = [number for end in ends for number in range(end[0], end[-1] + 1)]
        found = [f"v{which}r{condition} d{d}, [{base}, #{8 * k}]" for k, d in enumerate(each)]
        return "\n".join([*found, *([f"add{condition} {base}, {base}, #{8 * len(each)}"] if moves else [])])
    instruction = re.sub(r"^vmov\.f64 (d\d+), (d\d+)$", r"vorr \1, \2, \2", instruction)
    return re.sub(r"^vmov(\w\w)\.f64 (d\d+), (d\d+)$", r"vneg\1.f64 \2, \3", instruction)


def _analysed(text: str, core: Core, name: str, repeats: int) -> str:
    command = [
        "llvm-mca-19",
        f"--mtriple={core.target}",
        f"-mcpu={name}",
        f"-iterations={repeats}",
        "-mattr=+neon",
    ]
    return subprocess.run(command, input=text, capture_output=True, text=True, check=True).stdout


def _numbers(pattern: str, text: str) -> list[float]:
    return [float(number) for number in re.findall(pattern, text)]


def _first_line(*command: str) -> str:
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    return done.stdout.splitlines()[0]


def _described(core: Core, run: Run, bench: Path) -> dict[str, Any]:
    """What the record says of a core by itself."""
    return {
        "target": core.target,
        "flags": core.flags,
        "emulator": f"{_first_line(core.emulator[0], '--version')} {' '.join(core.emulator[1:])}".rstrip(),
        "pipeline": pipeline(core, bench, run.blocks) if core.pipelines else {},
    }


def compared(core: Run, first: Run, names: list[str]) -> dict[str, Any]:
    """Instructions of a core relative to the first one's: of each problem and stage; and the answers' bits."""
    totals = [sum(found.instructions for found in stages.values()) for stages in core.stages]
    of_first = [sum(found.instructions for found in stages.values()) for stages in first.stages]
    by_stage = defaultdict[str, list[float]](list)
    for mine, theirs in zip(core.stages, first.stages, strict=True):
        for stage in mine.keys() & theirs.keys():
            by_stage[stage].append(mine[stage].each / theirs[stage].each)
    same = zip(names, core.answers, first.answers, strict=True)
    return {
        "other_answers": [name for name, mine, theirs in same if mine != theirs],
        "ratio": _spread([mine / theirs for mine, theirs in zip(totals, of_first, strict=True)]),
        "stages": {stage: _spread(ratios) for stage, ratios in sorted(by_stage.items())},
        "totals": dict(zip(names, totals, strict=True)),
    }


def _spread(ratios: list[float]) -> dict[str, float]:
    """Geometric mean, least and largest."""
    found = {
        "mean": math.exp(math.fsum(map(math.log, ratios)) / len(ratios)),
        "low": min(ratios),
        "high": max(ratios),
    }
    return {name: round(value, 3) for name, value in found.items()}


def main() -> int:
    """Count, fit, write, and print the errors."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--keep-law", action="store_true", help="rewrite the comparison of the cores alone")
    parser.add_argument(
        "--built", type=Path, help="a folder with a program per core, NAME/orbsoc-bench, built before"
    )
    arguments = parser.parse_args()
    named = list(problems())
    names = [name for name, _, _ in named]
    runs: dict[str, Run] = {}
    described: dict[str, dict[str, Any]] = {}
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        files = [folder / f"{name}.json" for name in names]
        for file, (_, _, problem) in zip(files, named, strict=True):
            problem.save(file)
        for core in CORES:
            bench = arguments.built / core.name / "orbsoc-bench" if arguments.built else build(core)
            runs[core.name] = count(core, bench, files, folder)
            described[core.name] = _described(core, runs[core.name], bench)
    first = runs[CORES[0].name]
    made = {
        "compiler": _first_line("rustc", "--version"),
        "commit": _first_line("git", "rev-parse", "--short=12", "HEAD"),
    }
    cores = {name: made | described[name] | compared(run, first, names) for name, run in runs.items()}
    if arguments.keep_law:
        write(json.loads(RECORD.read_text(encoding="utf-8")) | {"cores": cores})
    else:
        write(_law(named, first, described[CORES[0].name], made) | {"cores": cores})
    for name in runs:
        sys.stdout.write(f"{name}: {json.dumps(cores[name] | {'totals': None})}\n")
    return 0


def _law(
    named: list[tuple[str, bool, Problem]], run: Run, described: dict[str, Any], made: dict[str, str]
) -> dict[str, Any]:
    """The first core's law; prints how far it is off."""
    rows: list[Counted] = []
    for (name, held_out, problem), stages in zip(named, run.stages, strict=True):
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
        "core": f"{CORES[0].name}, NEON",
        "emulator": described["emulator"],
        **made,
        "command": "python -m scripts.record_instructions",
        "pipeline": described["pipeline"],
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
    law = law_of(record)
    for row in rows:
        total, worst, stage = errors(law, row)
        kind = "held out" if row.held_out else "fitted"
        sys.stdout.write(f"{row.name:28s} {kind:8s} total {total:+6.1%}  worst stage {worst:5.1%} {stage}\n")
    return record


def write(record: dict[str, Any]) -> None:
    """One line per key, and per measured pattern and core."""
    lines = [
        f'"{key}": {json.dumps(value)}' for key, value in record.items() if key not in ("measured", "cores")
    ]
    measured = ",\n".join(json.dumps(row) for row in record["measured"])
    cores = ",\n".join(f'"{name}": {json.dumps(found)}' for name, found in record["cores"].items())
    lines += [f'"measured": [\n{measured}\n]', f'"cores": {{\n{cores}\n}}']
    RECORD.write_text("{" + ",\n".join(lines) + "}\n", encoding="utf-8")


if __name__ == "__main__":
    raise SystemExit(main())
