"""What Python adds to the native solve: `Solver.update` of some 300 numbers and `Solver.solve`, wall clock less native."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

import orbsoc
from benchmarks.guidance import powered_descent
from benchmarks.measure import forced_switches

REPEATS = 400


@dataclass(frozen=True, slots=True)
class Overhead:
    """Medians in µs over undisturbed rounds; `numbers` are the entries replaced."""

    numbers: int
    update_us: float
    """Python's share of `update`."""
    solve_us: float
    """Python's share of `solve`."""
    both_us: float
    native_us: float
    """The native update (equilibration) and solve themselves, which are not overhead."""

    @classmethod
    def from_record(cls, record: Mapping[str, Any]) -> Overhead:
        return cls(**record)


def measure_overhead(repeats: int = REPEATS) -> Overhead:
    """Alternates two cases of one powered descent of ten nodes; c, b and h are replaced. The native clocks are the core's."""
    cases = [powered_descent(10, seed) for seed in (0, 1)]
    solver = orbsoc.Solver(cases[0])
    rounds = [_round(solver, cases[k % 2]) for k in range(repeats)]
    kept = [row for row, undisturbed in rounds if undisturbed] or [row for row, _ in rounds]
    update, solve, both, native = (1e6 * float(np.median(column)) for column in np.array(kept).T)
    return Overhead(sum(v.size for v in (cases[0].c, cases[0].b, cases[0].h)), update, solve, both, native)


def _round(solver: orbsoc.Solver, case: orbsoc.Problem) -> tuple[tuple[float, float, float, float], bool]:
    """Seconds of one round, and whether the core was kept in it."""
    switches = forced_switches()
    start = time.perf_counter()
    solver.update(c=case.c, b=case.b, h=case.h)
    middle = time.perf_counter()
    solution = solver.solve()
    end = time.perf_counter()
    update = middle - start - solution.setup_s
    solve = end - middle - solution.solve_s
    row = (update, solve, update + solve, solution.setup_s + solution.solve_s)
    return row, forced_switches() == switches
