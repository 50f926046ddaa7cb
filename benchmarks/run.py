"""Time orbsoc beside its peers: `python -m benchmarks.run --family mission004 --repeats 30 --out out/bench`.

Writes FAMILY.csv, FAMILY.json, FAMILY.md and FAMILY.png for each family. `--readme docs/mission004-benchmark.md` puts the first family's
result between the markers of that file.
"""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

from benchmarks.answer import Solver
from benchmarks.environment import environment
from benchmarks.families import FAMILIES, instances
from benchmarks.measure import Measurement, measure
from benchmarks.peers import DEFAULT, solvers
from benchmarks.profile_figure import profile_figure
from benchmarks.records import to_csv, to_json
from benchmarks.tables import (
    comparison_table,
    environment_line,
    group_table,
    residual_table,
)
from benchmarks.verdict import verdict

MORE = (
    "Other families, batches, warm starts and public sets: [results.md](results.md). Rules of measurement and "
    "settings of the peers: [benchmarks.md](benchmarks.md)."
)
NOISY = 0.25
"""Interquartile range over median above which a run should be repeated on a quieter machine."""


def main(arguments: Sequence[str] | None = None) -> int:
    chosen = _arguments(arguments)
    found, missing = solvers(tuple(chosen.solvers.split(",")))
    for line in missing:
        _say(line)
    names = list(FAMILIES) if chosen.family == ["all"] else chosen.family
    chosen.out.mkdir(parents=True, exist_ok=True)
    sections: dict[str, str] = {}
    for name in names:
        sections[name] = _run_family(name, found, chosen)
    if chosen.readme:
        insert(chosen.readme, f"{sections[names[0]]}\n\n{MORE}")
    return 0


def _arguments(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.run", description=__doc__)
    parser.add_argument(
        "--family",
        action="append",
        choices=[*FAMILIES, "all"],
        help="may be given several times; default mission004",
    )
    parser.add_argument("--repeats", type=int, default=30)
    parser.add_argument("--tol", type=float, default=1e-8)
    parser.add_argument("--solvers", default=",".join(DEFAULT), help="comma-separated")
    parser.add_argument("--out", type=Path, default=Path("out/bench"))
    parser.add_argument(
        "--readme", type=Path, help="file whose benchmark block gets the first family's result"
    )
    chosen = parser.parse_args(arguments)
    chosen.family = chosen.family or ["mission004"]
    if chosen.repeats < 1:
        parser.error(f"--repeats is {chosen.repeats}; it must be 1 or more")
    if not chosen.tol > 0.0:
        parser.error(f"--tol is {chosen.tol}; it must be positive")
    return chosen


def _run_family(name: str, found: Sequence[Solver], chosen: argparse.Namespace) -> str:
    """Measure one family, write its files, and return its section in Markdown."""
    _say(f"{name}: generating")
    problems = instances([name])
    header = environment(found, repeats=chosen.repeats, tol=chosen.tol)
    measurements = measure(
        problems,
        found,
        repeats=chosen.repeats,
        tol=chosen.tol,
        progress=lambda line: _say(f"{name}: {line}", end="\r"),
    )
    _say("")
    section = markdown(header, measurements)
    files = {"csv": to_csv(header, measurements), "json": to_json(header, measurements), "md": section + "\n"}
    for ending, text in files.items():
        (chosen.out / f"{name}.{ending}").write_text(text, encoding="utf-8")
    profile_figure(measurements, header, name, chosen.out / f"{name}.png")
    sys.stdout.write(f"# {name}\n\n{section}\n\n")
    noisy = [m for m in measurements if m.solve.relative > NOISY]
    if noisy:
        _say(
            f"{len(noisy)} of {len(measurements)} spreads exceed {NOISY:.0%} of the median: repeat when it is quieter"
        )
    return section


def markdown(header: Mapping[str, str], measurements: Sequence[Measurement]) -> str:
    """What a reader needs to judge the numbers, then the numbers."""
    return "\n\n".join(
        [
            environment_line(header),
            group_table(measurements),
            comparison_table(measurements),
            residual_table(measurements),
            "Required, and what comes out:",
            verdict(measurements),
        ]
    )


def insert(path: Path, text: str) -> None:
    """Replace what stands between the benchmark markers of a file; raises ValueError when it has none."""
    whole = path.read_text(encoding="utf-8")
    pattern = re.compile(r"(<!-- benchmarks:begin[^>]*-->\n).*?(<!-- benchmarks:end -->)", flags=re.DOTALL)
    if not pattern.search(whole):
        raise ValueError(f"{path} has no <!-- benchmarks:begin --> … <!-- benchmarks:end --> block")
    path.write_text(pattern.sub(lambda found: f"{found[1]}{text}\n{found[2]}", whole), encoding="utf-8")


def _say(line: str, end: str = "\n") -> None:
    sys.stderr.write(line + end)


if __name__ == "__main__":
    raise SystemExit(main())
