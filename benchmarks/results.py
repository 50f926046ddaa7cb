"""Everything that is required of the solver beside its peers, by one command:

    python -m benchmarks.results --problems DIR --out out/results --page docs/results.md

About twenty minutes on a quiet machine of two cores; `--quick` takes about three and measures less of everything.
An interrupted run goes on where it was left; another build of orbsoc is measured anew.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from benchmarks.families import FAMILIES
from benchmarks.folder import VARIABLE
from benchmarks.phases import FULL, QUICK, measure_all
from benchmarks.requirements import requirements, table
from benchmarks.results_page import figures, page


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure, write the page, print the requirements; 0 whether they hold or not."""
    chosen = _arguments(arguments)
    started = time.monotonic()

    def say(line: str) -> None:
        sys.stderr.write(f"{time.monotonic() - started:6.0f} s  {line}\n")
        sys.stderr.flush()

    results = measure_all(
        chosen.out,
        QUICK if chosen.quick else FULL,
        problems=Path(chosen.problems) if chosen.problems else None,
        tol=chosen.tol,
        names=chosen.family or list(FAMILIES),
        say=say,
    )
    target: Path = chosen.page or chosen.out / "results.md"
    drawn = figures(results, target.parent / "figures")
    target.write_text(
        page(results, {title: f"figures/{name}" for title, name in drawn.items()}), encoding="utf-8"
    )
    sys.stdout.write(table(requirements(results)) + "\n")
    say(f"written: {target}")
    return 0


def _arguments(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.results",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--problems", default=os.environ.get(VARIABLE), help=f"public sets; or {VARIABLE}")
    parser.add_argument("--out", type=Path, default=Path("out/results"), help="where parts are kept")
    parser.add_argument("--page", type=Path, help="the results page; default OUT/results.md")
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--tol", type=float, default=1e-8)
    parser.add_argument("--family", action="append", choices=list(FAMILIES), help="only these families")
    return parser.parse_args(arguments)


if __name__ == "__main__":
    raise SystemExit(main())
