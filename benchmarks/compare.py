"""Two commits beside each other, natively: `python -m benchmarks.compare A B --family powered_descent --rounds 5`.

Each commit is checked out beside this one and its `orbsoc-bench` built once; then both run in turn, A B, B A, …, on the
same problem files, and for every problem (and stage, with `--stages`) the least of a commit's medians over the rounds
counts. `A` and `B` are any names of commits; `.` is the checkout with its changes.
"""

from __future__ import annotations

import argparse
import csv
import io
import subprocess
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path

from benchmarks import families
from benchmarks.environment import ROOT

HERE = "."
MEDIAN = "median_us"
SPEEDY = ("powered_descent", "rendezvous", "quadrotor", "orbit_insertion", "six_dof", "small_lp")
"""Families compared when none is named."""


def main(arguments: Sequence[str] | None = None) -> int:
    chosen = _arguments(arguments)
    folder: Path = chosen.out.resolve()
    names = chosen.family or list(SPEEDY)
    problems = folder / "problems"
    families.main(["--out", str(problems), *names])
    programs = [build(name, folder) for name in (chosen.before, chosen.after)]
    runs: list[list[str]] = [[], []]
    for round_number in range(chosen.rounds):
        for side in (0, 1) if round_number % 2 == 0 else (1, 0):
            sys.stderr.write(f"round {round_number + 1} of {chosen.rounds}, {'AB'[side]}\n")
            runs[side].append(_measured(programs[side], [problems / name for name in names], folder, chosen))
    merged = [folder / "a.csv", folder / "b.csv"]
    for path, texts in zip(merged, runs, strict=True):
        path.write_text(least(texts), encoding="utf-8")
    sys.stdout.write(_run([programs[1], "--compare", *merged]))
    return 0


def _arguments(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.compare",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("before", help="a commit, or . for the checkout as it stands")
    parser.add_argument("after")
    parser.add_argument("--family", action="append", choices=list(families.FAMILIES))
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--repeats", type=int, default=5, help="solves of each problem in a round")
    parser.add_argument("--stages", action="store_true", help="compare every stage, too")
    parser.add_argument("--out", type=Path, default=Path("out/compare"))
    chosen = parser.parse_args(arguments)
    if chosen.rounds < 1:
        parser.error(f"--rounds is {chosen.rounds}; it must be 1 or more")
    return chosen


def build(commit: str, folder: Path) -> Path:
    """The commit's `orbsoc-bench`, built unless it is there. Raises CalledProcessError with the tool's output."""
    if commit == HERE:
        _run(["cargo", "build", "--release", "--locked", "-p", "orbsoc-bench"], cwd=ROOT)
        return ROOT / "target" / "release" / "orbsoc-bench"
    revision = _run(["git", "rev-parse", "--verify", "--short=12", f"{commit}^{{commit}}"], cwd=ROOT).strip()
    program = folder / f"orbsoc-bench-{revision}"
    if program.is_file():
        return program
    checkout = folder / revision
    _run(["git", "worktree", "add", "--detach", "--force", checkout, revision], cwd=ROOT)
    try:
        target = folder / "target"  # both commits share what they have in common
        _run(
            ["cargo", "build", "--release", "--locked", "-p", "orbsoc-bench", "--target-dir", target],
            cwd=checkout,
        )
        program.write_bytes((target / "release" / "orbsoc-bench").read_bytes())
        program.chmod(0o755)
    finally:
        _run(["git", "worktree", "remove", "--force", checkout], cwd=ROOT)
    return program


def least(texts: Iterable[str]) -> str:
    """One CSV of `orbsoc-bench` from several of the same program: each line from the run where its median was least."""
    best: dict[tuple[str, str], dict[str, str]] = {}
    columns: list[str] = []
    for text in texts:
        reader = csv.DictReader(line for line in text.splitlines() if not line.startswith("#"))
        columns = list(reader.fieldnames or columns)
        for row in reader:
            key = (row["problem"], row["part"])
            if key not in best or float(row[MEDIAN]) < float(best[key][MEDIAN]):
                best[key] = row
    out = io.StringIO()
    writer = csv.DictWriter(out, fieldnames=columns, lineterminator="\n")
    writer.writeheader()
    writer.writerows(best.values())
    return out.getvalue()


def _measured(program: Path, problems: Sequence[Path], folder: Path, chosen: argparse.Namespace) -> str:
    """The CSV of one run."""
    path = folder / "round.csv"
    options: list[str | Path] = ["--repeats", str(chosen.repeats), "--out", path]
    _run([program, *problems, *options, *(["--stages"] if chosen.stages else [])])
    return path.read_text(encoding="utf-8")


def _run(command: Sequence[str | Path], cwd: Path | None = None) -> str:
    """Standard output; a failing command's output is shown."""
    done = subprocess.run(command, cwd=cwd, capture_output=True, text=True, check=False)
    if done.returncode:
        sys.stderr.write(done.stderr)
        raise subprocess.CalledProcessError(done.returncode, [str(word) for word in command])
    return done.stdout


if __name__ == "__main__":
    raise SystemExit(main())
