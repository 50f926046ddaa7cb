"""The conic problems of missions' plans beside Clarabel: `python -m benchmarks.mission_solves paper001_fewest paper003_socp`.

Each scenario of `scenarios/` is planned once; then each problem of its search is solved by both, by turns, with the plan's settings and with processor
time of the thread. Set-up is counted for both: the least of `--repeats` counts. What is printed depends on the machine, which is named.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

import orbsoc
from benchmarks.environment import ROOT, machine_class
from benchmarks.measure import geometric_mean
from orbsoc.conic.problem import Problem
from orbsoc.conic.settings import Settings
from orbsoc.conic.solution import Solution
from orbsoc.interfaces import clarabel

SOLVED = orbsoc.Status.SOLVED
MICROSECOND = 1e-6


@dataclass(frozen=True)
class Pair:
    """A problem's answers, and the least processor time of each (s)."""

    ours: Solution
    theirs: Solution
    ours_s: float
    theirs_s: float


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.mission_solves",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("scenarios", nargs="+", help="names of files in scenarios/")
    parser.add_argument("--repeats", type=int, default=10, help="solves of each problem by each solver")
    chosen = parser.parse_args(arguments)
    sys.stdout.write(f"{machine_class()}\n")
    for name in chosen.scenarios:
        sys.stdout.write(f"{line(name, pairs(name, chosen.repeats))}\n")
        sys.stdout.flush()
    return 0


def pairs(name: str, repeats: int) -> list[Pair]:
    """Both solvers on every conic problem of a plan."""
    plan: Any = orbsoc.plan(ROOT / "scenarios" / f"{name}.toml", device="none").plan
    return [paired(row.problem, row.settings, repeats) for row in plan.subproblems]


def paired(problem: Problem, settings: Settings, repeats: int) -> Pair:
    solves: tuple[Callable[[Problem, Settings], Solution], ...] = (orbsoc.solve, clarabel.solve)
    least = [np.inf, np.inf]
    answers: list[Solution] = [solve(problem, settings) for solve in solves]
    for _ in range(repeats):
        for side, solve in enumerate(solves):
            started = time.thread_time()
            solve(problem, settings)
            least[side] = min(least[side], time.thread_time() - started)
    return Pair(*answers, *least)


def line(name: str, found: Sequence[Pair]) -> str:
    """Counts, times, ratios and iterations in words."""
    ours, theirs = (np.array([getattr(pair, key) for pair in found]) for key in ("ours_s", "theirs_s"))
    solved = [sum(getattr(pair, key).status is SOLVED for pair in found) for key in ("ours", "theirs")]
    both = [pair for pair in found if pair.ours.status is pair.theirs.status is SOLVED]
    compared = [pair.ours.iterations / pair.theirs.iterations for pair in both if pair.theirs.iterations]
    iterations = f"{geometric_mean(compared):.2f} times Clarabel's" if compared else "not compared"
    apart = max(abs(pair.ours.objective - pair.theirs.objective) / max(1.0, abs(pair.theirs.objective)) for pair in both)  # fmt: skip
    return (
        f"{name}: {len(found)} problems, solved {solved[0]} / {solved[1]}; {ours.min() / MICROSECOND:.0f} to {ours.max() / MICROSECOND:.0f} µs, "
        f"Clarabel {(theirs / ours).min():.1f} to {(theirs / ours).max():.1f} times that, {theirs.sum() / ours.sum():.1f} in all; "
        f"iterations {iterations}; objectives within {apart:.0e}"
    )


if __name__ == "__main__":
    sys.exit(main())
