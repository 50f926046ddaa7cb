"""`orbsoc.BatchSolver` on one thread beside every peer in a loop over the same problems."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

import orbsoc
from benchmarks.answer import Answer, Array, Solver, Variant
from benchmarks.batches import Batch
from benchmarks.measure import COUNTS_BELOW, forced_switches, geometric_mean, undisturbed
from benchmarks.tables import ORBSOC
from orbsoc.conic.problem import Problem
from orbsoc.conic.verify import verify
from orbsoc.solving.batch import BatchSolution

ATTEMPTS = 5
"""Runs of a whole batch made at most until one was undisturbed; else the least time, scaled by its share of a core."""


@dataclass(frozen=True, slots=True)
class Loop:
    """A peer in a loop, µs per problem: solves alone, and with the set-up of each cold object."""

    solver: str
    solve_us: float
    total_us: float
    verified: int


@dataclass(frozen=True, slots=True)
class BatchTimes:
    """`orbsoc_us` is the wall clock of the whole batch, loading, scaling and certificates included, µs per problem."""

    name: str
    kind: str
    size: int
    orbsoc_us: float
    verified: int
    residual: float
    setup_us: float
    """The pattern's analysis, once for all batches: µs for each problem of one."""
    alone_us: float
    """Our own solver in a loop, solves alone: what the lanes bring."""
    loops: tuple[Loop, ...]

    @property
    def best(self) -> Loop | None:
        """The peer that is fastest, its set-ups left out, among those that solve every problem."""
        able = [loop for loop in self.loops if loop.verified == self.size]
        return min(able, key=lambda loop: loop.solve_us, default=None)

    @property
    def ratio(self) -> float:
        """Best peer's solves over our batch: neither with its set-up, which a loop may keep as well."""
        return self.best.solve_us / self.orbsoc_us if self.best else float("nan")

    @property
    def total_ratio(self) -> float:
        """The same with the set-ups of both: of each cold object on the peer's side, once a batch on orbsoc's."""
        return self.best.total_us / (self.orbsoc_us + self.setup_us) if self.best else float("nan")

    @classmethod
    def from_record(cls, record: Mapping[str, Any]) -> BatchTimes:
        return cls(**{**record, "loops": tuple(Loop(**loop) for loop in record["loops"])})


def measure_batch(
    batch: Batch, solvers: Sequence[Solver], *, repeats: int, tol: float, patience_s: float = 15.0
) -> BatchTimes:
    """Medians over `repeats` interleaved rounds, none begun after `patience_s`.

    Raises ValueError when the problems differ in their pattern.
    """
    problems = batch.generate()
    arrays = stacked(problems)
    able = [s for s in solvers if s.applies(problems[0]) and s.timed(problems[0]) and not s.sampled]
    fitting = {solver.name: _fitting(solver, problems[0], tol) for solver in able}
    loops = {name: _Looped(variant) for name, variant in fitting.items() if variant is not None}
    solver = orbsoc.BatchSolver(problems[0], tol=tol)
    times: list[float] = []
    started = time.perf_counter()
    for _ in range(repeats):
        if times and time.perf_counter() - started > patience_s:
            break
        seconds, solution = _timed_batch(solver, arrays)
        times.append(seconds)
        for loop in loops.values():
            loop.run(problems, tol)
    residuals = [verify(p, _row(solution, k)).worst for k, p in enumerate(problems)]
    size = len(problems)
    rows = {name: loop.times(name, problems) for name, loop in loops.items()}
    return BatchTimes(
        name=batch.name,
        kind=batch.kind,
        size=size,
        orbsoc_us=1e6 * float(np.median(times)) / size,
        setup_us=1e6 * solution.setup_s / size,
        verified=sum(residual <= COUNTS_BELOW for residual in residuals),
        residual=max(residuals),
        alone_us=alone.solve_us if (alone := rows.pop(ORBSOC, None)) else math.nan,
        loops=tuple(rows.values()),
    )


def stacked(problems: Sequence[Problem]) -> dict[str, Array]:
    """What differs between the problems, as `solve_batch` takes it; ValueError when it is the pattern."""
    first = problems[0]
    for k, problem in enumerate(problems):
        for name in ("P", "A", "G"):
            mine, its = getattr(first, name), getattr(problem, name)
            if not (np.array_equal(mine.indices, its.indices) and np.array_equal(mine.indptr, its.indptr)):
                raise ValueError(f"problem {k} of the batch has another pattern of {name}")
    values: dict[str, Callable[[Problem], Array]] = {
        "c": lambda p: p.c,
        "b": lambda p: p.b,
        "h": lambda p: p.h,
        "A": lambda p: p.A.data,
        "G": lambda p: p.G.data,
        "P": lambda p: p.P.data,
    }
    rows = {name: np.array([of(problem) for problem in problems]) for name, of in values.items()}
    return {name: found for name, found in rows.items() if (found != found[0]).any()}


def _timed_batch(solver: orbsoc.BatchSolver, arrays: Mapping[str, Any]) -> tuple[float, BatchSolution]:
    """Seconds on the batch's own clock, without those in which its core was taken away."""
    best, solution = math.inf, None
    for _ in range(ATTEMPTS):
        switches, wall, cpu = forced_switches(), time.perf_counter(), time.process_time()
        solution = solver.solve(**arrays)
        if forced_switches() == switches:
            return solution.solve_s, solution
        share = min(1.0, (time.process_time() - cpu) / (time.perf_counter() - wall))
        best = min(best, solution.solve_s * share)
    assert solution is not None  # ATTEMPTS ≥ 1
    return best, solution


class _Looped:
    """One solver over all problems, again and again; a problem's time is its median over the rounds."""

    def __init__(self, variant: Variant) -> None:
        self.variant = variant
        self.solve_s: list[list[float]] = []
        self.total_s: list[list[float]] = []
        self.answers: list[Answer] = []

    def run(self, problems: Sequence[Problem], tol: float) -> None:
        self.answers = [undisturbed(self.variant, problem, tol) for problem in problems]
        self.solve_s.append([answer.solve_s for answer in self.answers])
        self.total_s.append([answer.setup_s + answer.solve_s for answer in self.answers])

    def times(self, name: str, problems: Sequence[Problem]) -> Loop:
        solve, total = (
            1e6 * float(np.mean(np.median(rounds, axis=0))) for rounds in (self.solve_s, self.total_s)
        )
        good = [verify(p, a).worst <= COUNTS_BELOW for p, a in zip(problems, self.answers, strict=True)]
        return Loop(name, solve, total, sum(good))


def _fitting(solver: Solver, problem: Problem, tol: float) -> Variant | None:
    """The first variant that verifies on the first problem, if any."""
    for variant in solver.variants:
        if verify(problem, variant.solve(problem, tol)).worst <= COUNTS_BELOW:
            return variant
    return None


@dataclass(frozen=True, slots=True, eq=False)
class _Pair:
    x: Array
    y: Array
    z: Array


def _row(solution: BatchSolution, k: int) -> _Pair:
    return _Pair(solution.x[k], solution.y[k], solution.z[k])


def table(rows: Sequence[BatchTimes]) -> str:
    """A Markdown table, a row each batch."""
    lines = [
        "| batch of 64, one thread | verified | orbsoc batch, µs a problem | orbsoc in a loop | best peer in a loop "
        "| its solves over our batch | with its set-ups |",
        "|---|--:|--:|--:|--:|--:|--:|",
    ]
    for row in rows:
        best = f"{row.best.solve_us:.1f} ({row.best.solver})" if row.best else "none solves all"
        lines.append(
            f"| {row.name} | {row.verified} of {row.size} | {row.orbsoc_us:.1f} | {row.alone_us:.1f} | {best} "
            f"| {row.ratio:.2f} | {row.total_ratio:.2f} |"
        )
    for kind in dict.fromkeys(row.kind for row in rows):
        ratios = [row.ratio for row in rows if row.kind == kind and row.best]
        lines.append(f"| **{kind}, geometric mean** | | | | | **{geometric_mean(ratios):.2f}** | |")
    return "\n".join(lines)
