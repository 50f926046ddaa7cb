"""Public sets: `python -m benchmarks.folder --problems DIR --out out/sets`, resumed where it was left.

Every solver answers every problem once, cold, in a process of its own, under a time limit; rows go to `sets.csv` as they
come. A row of another build of orbsoc, another tolerance or another release is measured again.
"""

from __future__ import annotations

import argparse
import csv
import dataclasses
import os
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from benchmarks.fingerprint import fingerprint
from benchmarks.folder_report import report
from benchmarks.grading import Graded
from benchmarks.peers import solvers
from benchmarks.processes import SolverProcess
from benchmarks.public_sets import Listed, listed

VARIABLE = "ORBSOC_PROBLEMS"
"""Environment variable that names the folder when the option does not."""
LIMIT_S = 20.0
NAMES = ("orbsoc", "clarabel", "ecos", "qoco", "piqp_sparse", "scs", "highs")
COLUMNS = [field.name for field in dataclasses.fields(Graded)]


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.folder", description=__doc__)
    parser.add_argument("--problems", type=Path, default=os.environ.get(VARIABLE), help=f"or {VARIABLE}")
    parser.add_argument("--out", type=Path, default=Path("out/sets"))
    parser.add_argument("--set", action="append", help="only these sets")
    parser.add_argument("--solvers", default=",".join(NAMES), help="comma-separated")
    parser.add_argument("--tol", type=float, default=1e-8)
    parser.add_argument("--limit", type=float, default=LIMIT_S, help="seconds for one problem")
    chosen = parser.parse_args(arguments)
    if chosen.problems is None:
        parser.error(f"no folder of problems: give --problems or set {VARIABLE}")
    problems = [one for one in listed(Path(chosen.problems)) if not chosen.set or one.set in chosen.set]
    rows = measure_sets(
        problems,
        tuple(chosen.solvers.split(",")),
        out=chosen.out,
        tol=chosen.tol,
        limit_s=chosen.limit,
        progress=_say,
    )
    sys.stdout.write(report(rows) + "\n")
    return 0


def _say(line: str) -> None:
    sys.stderr.write(line + "\n")


def measure_sets(
    problems: Sequence[Listed],
    names: tuple[str, ...],
    *,
    out: Path,
    tol: float,
    limit_s: float = LIMIT_S,
    progress: Callable[[str], None] = lambda line: None,
) -> list[Graded]:
    """All rows, those already in `out`/sets.csv included; raises ValueError for a solver that is none."""
    out.mkdir(parents=True, exist_ok=True)
    path = out / "sets.csv"
    found, missing = solvers(names)
    for line in missing:
        progress(line)
    processes = [
        SolverProcess(name, solver)
        for name, solver in zip((n for n in names if _there(n)), found, strict=True)
    ]
    known: dict[tuple[str, ...], list[Graded]] = {}
    for row in read_rows(path):
        if row.tol == tol:
            known.setdefault((row.set, row.problem, row.solver, row.release), []).append(row)
    rows: list[Graded] = []
    try:
        for k, problem in enumerate(problems):
            for process in processes:
                key = (problem.set, problem.name, process.solver.name, release(process))
                if key not in known:
                    asked = process.ask(problem, tol, limit_s)
                    known[key] = [dataclasses.replace(row, release=release(process)) for row in asked]
                    _append(path, known[key])
                rows += known[key]
            progress(f"{k + 1} of {len(problems)}: {problem.key}")
    finally:
        for process in processes:
            process.close()
    return rows


def release(process: SolverProcess) -> str:
    """The version; for orbsoc with the build, so that rows of another build are not taken for this one's."""
    version = process.solver.version
    return f"{version}+{fingerprint()}" if process.name == "orbsoc" else version


def read_rows(path: Path) -> list[Graded]:
    """The rows of a sets.csv; none when there is no file. Lines cut short are left out."""
    if not path.is_file():
        return []
    with path.open(newline="", encoding="utf-8") as file:
        complete = [row for row in csv.DictReader(file) if None not in row.values()]
    return [_row(row) for row in complete]


def _row(texts: Mapping[str, str]) -> Graded:
    convert: dict[str, Callable[[str], Any]] = {"float": float, "int": int, "str": str}
    fields = dataclasses.fields(Graded)
    return Graded(**{field.name: convert[str(field.type)](texts[field.name]) for field in fields})


def _append(path: Path, rows: Sequence[Graded]) -> None:
    """One more line each, after the end of one that an interruption cut short."""
    before = path.read_bytes() if path.exists() else b""
    with path.open("a", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        if not before:
            writer.writerow(COLUMNS)
        elif not before.endswith(b"\n"):
            file.write("\n")
        writer.writerows([getattr(row, name) for name in COLUMNS] for row in rows)


def _there(name: str) -> bool:
    return bool(solvers((name,))[0])


if __name__ == "__main__":
    raise SystemExit(main())
