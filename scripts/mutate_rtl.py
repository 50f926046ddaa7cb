"""Draw mutants of the RTL, show each to the tests of tests/rtl and write down which test caught it.

Usage: python -m scripts.mutate_rtl --seed 1 --count 160 [--files fpu/] [--out out/mutants]

Every file gets three mutants or more. A run that was stopped goes on where it was. The rows are in OUT/…/mutants.csv, the last of
a mutant counts; runs of other --files can be beside each other.
"""

from __future__ import annotations

import argparse
import csv
import io
import signal
import sys
from collections import Counter
from dataclasses import asdict
from pathlib import Path

from scripts.mutation.campaign import ROOT, RTL, files, source, verdicts
from scripts.mutation.places import mutants_of
from scripts.mutation.schemata import drawn

COLUMNS = ("number", "file", "line", "kind", "was", "instead", "verdict", "test", "why")
VERDICTS = ("caught", "time limit", "survived")


def main() -> int:
    """Run, or go on with, a campaign; 1 if a mutant survived."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--count", type=int, default=160)
    parser.add_argument("--files", default="", help="only those whose path under rtl/ begins so")
    parser.add_argument("--again", action="store_true", help="show those again that survived")
    parser.add_argument("--out", type=Path, default=ROOT / "out" / "mutants")
    asked = parser.parse_args()
    if asked.count < 1:
        parser.error(
            f"--count = {asked.count}: allowed is a whole number from 1; each file gets three or more"
        )
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    mutants = dict(enumerate(drawn(mutants_of(RTL, files()), asked.seed, asked.count), start=1))
    folder = asked.out / f"{asked.seed}-{asked.count}-{source()}"
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / "mutants.csv"
    wanted = {number for number, mutant in mutants.items() if mutant.file.startswith(asked.files)}
    known = {n for n, row in rows_of(path).items() if not (asked.again and row["verdict"] == "survived")}
    left = sorted(wanted - known)
    try:
        for done, verdict in enumerate(verdicts(folder, mutants, left), start=1):
            row = asdict(mutants[verdict.number]) | asdict(verdict)
            _append(path, [str(row[name]) for name in COLUMNS])
            sys.stderr.write(f"{done} of {len(left)}: {row['file']}:{row['line']}: {row['was']} -> {row['instead'] or 'nothing'}: {row['verdict']} {row['test']}\n")  # fmt: skip
    except KeyboardInterrupt:
        sys.stderr.write(f"stopped; the same command goes on. Rows: {path}\n")
        return 130
    sys.stdout.write(table(list(rows_of(path).values())))
    return int(any(row["verdict"] == "survived" for row in rows_of(path).values()))


def table(rows: list[dict[str, str]]) -> str:
    """What became of the mutants of each file, in Markdown."""
    counts = {
        file: Counter(row["verdict"] for row in rows if row["file"] == file)
        for file in sorted({row["file"] for row in rows})
    }
    counts["all"] = Counter(row["verdict"] for row in rows)
    lines = ["| file | drawn | " + " | ".join(VERDICTS) + " |", "|---|" + "--:|" * (1 + len(VERDICTS))]
    for file, count in counts.items():
        lines.append(
            f"| {file} | {count.total()} | " + " | ".join(str(count[verdict]) for verdict in VERDICTS) + " |"
        )
    return "\n".join([*lines, ""])


def rows_of(path: Path) -> dict[int, dict[str, str]]:
    """The last row of every mutant."""
    if not path.exists():
        return {}
    with path.open(encoding="utf-8", newline="") as file:
        return {int(row["number"]): row for row in csv.DictReader(file, COLUMNS) if row["number"] != "number"}


def _append(path: Path, row: list[str]) -> None:
    """One write, so that several campaigns can share the file."""
    text = io.StringIO()
    csv.writer(text).writerows([row] if path.exists() else [COLUMNS, row])
    with path.open("a", encoding="utf-8", newline="") as file:
        file.write(text.getvalue())


if __name__ == "__main__":
    raise SystemExit(main())
