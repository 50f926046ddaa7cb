"""Count the instructions of the library in C on aarch64 under QEMU, and hold what BOUNDS.md states against them.

    python scripts/count_flight_instructions.py [--problem rec1] [--sets 50] [--solves 10000]

Bounds are taken from a few data sets of the pattern, as an export takes them. Prints, for each stage, the least and most
instructions of other data sets and the most over the bound; then solves with c, b and h moved by up to 4 %, from cold and
from near the solution, and the instructions of each over what its iterations and refinement steps allow. Exits 1 where a
bound was exceeded. Needs gcc, gcc-aarch64-linux-gnu and qemu-user.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

from benchmarks.guidance import rendezvous
from benchmarks.recorded import first_insertions
from orbsoc.conic.settings import Settings
from orbsoc.flight.instructions import (
    SETS,
    WORST_ITERATIONS,
    bounds_of,
    counted,
    solve_instructions,
    used_instructions,
    varied,
)

PROBLEMS = {"rec1": lambda: first_insertions(12, 1)[0], "rendezvous": lambda: rendezvous(10, 0)}
AT_ONCE = 1000
"""Solves of one run of the emulator: the data's file stays small."""


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--problem", choices=PROBLEMS, default="rec1")
    parser.add_argument("--sets", type=int, default=50)
    parser.add_argument("--solves", type=int, default=1000)
    given = parser.parse_args()
    problem, settings = PROBLEMS[given.problem](), Settings()
    with tempfile.TemporaryDirectory() as folder:
        bounds = bounds_of(counted(Path(folder), varied(problem, SETS), settings, 64, "stages"))
        found = counted(Path(folder), varied(problem, given.sets, seed=1), settings, 64, "stages")
    say = sys.stdout.write
    say("| stage | runs | least | most | bound | most/bound |\n|---|---|---|---|---|---|\n")
    exceeded = 0
    for stage, runs in found.runs.items():
        exceeded += sum(run > bounds[stage] for run in runs)
        ratio = f"{max(runs) / bounds[stage]:.4f}"
        say(f"| {stage} | {len(runs)} | {min(runs)} | {max(runs)} | {bounds[stage]} | {ratio} |\n")
    for warm in (False, True):
        worst = solve_instructions(bounds, settings, 1 + settings.max_restarts, warm=warm)
        say(f"worst case {'from a point' if warm else 'from cold'}: {worst}\n")
    short = replace(settings, max_iterations=WORST_ITERATIONS)
    with tempfile.TemporaryDirectory() as folder:
        full = counted(Path(folder), [problem], settings, 64, "worst").runs["worst"][0]
    allowed = solve_instructions(bounds, short, 1, warm=False)
    exceeded += full > allowed
    say(
        f"an attempt with all refinement, of {WORST_ITERATIONS} iterations: {full}, {full / allowed:.4f} of its bound\n"
    )
    ratios: dict[bool, list[float]] = {False: [], True: []}
    others = 0
    for first in range(0, given.solves, AT_ONCE):
        some = varied(problem, min(AT_ONCE, given.solves - first), seed=2 + first)
        with tempfile.TemporaryDirectory() as folder:
            solved = counted(Path(folder), some, settings, 64, "solves")
        for k, outcome in enumerate(solved.outcomes):
            warm = k % 2 == 1
            others += outcome[2] != 1
            if outcome[2] == 1:
                taken = solved.runs["solve_from" if warm else "solve"][k // 2]
                ratios[warm].append(taken / used_instructions(bounds, outcome, warm=warm))
        say(f"{first + len(some)} data sets solved\n")
    for warm, each in ratios.items():
        exceeded += sum(ratio > 1.0 for ratio in each)
        name = "from near the solution" if warm else "from cold"
        say(f"{len(each)} solves {name}: {min(each):.4f} to {max(each):.4f} of what their counts allow\n")
    say(f"{others} solves with more attempts than one; {exceeded} bounds exceeded\n")
    return 1 if exceeded else 0


if __name__ == "__main__":
    sys.exit(main())
