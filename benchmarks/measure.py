"""Interleaved timing: every solver on every problem, again and again, in one process, each answer verified."""

from __future__ import annotations

import gc
import math
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from benchmarks.answer import Answer, Solver, Variant
from benchmarks.families import Instance
from orbsoc.conic.problem import Problem
from orbsoc.conic.verify import Verification, verify

if sys.platform == "linux":
    import resource

ATTEMPTS, ATTEMPTS_S = 20, 0.05
"""Cold solves made at most until one ran undisturbed, and seconds after which no fourth is begun."""
FEWEST = 3
"""Repetitions of a slow solver."""
COUNTS_BELOW = 1e-7
"""A time counts only when max(pres, dres, gap) of `orbsoc.verify` is no larger: one formula for every solver."""


@dataclass(frozen=True, slots=True)
class Spread:
    """Median and quartiles of repeated measurements, in microseconds."""

    median: float
    q1: float
    q3: float

    @classmethod
    def of(cls, seconds: Sequence[float]) -> Spread:
        q1, median, q3 = np.percentile(np.asarray(seconds) * 1e6, [25.0, 50.0, 75.0])
        return cls(float(median), float(q1), float(q3))

    @property
    def relative(self) -> float:
        """Interquartile range over median: what a noisy machine does to the number."""
        return (self.q3 - self.q1) / self.median if self.median else 0.0


@dataclass(frozen=True, slots=True)
class Measurement:
    """One solver on one problem of size n / p / m. Where `failure` is not empty the times do not count, and it says why."""

    problem: str
    group: str
    n: int
    p: int
    m: int
    solver: str
    variant: str
    status: str
    iterations: int
    verification: Verification
    setup: Spread
    solve: Spread
    total: Spread
    failure: str

    @property
    def counts(self) -> bool:
        return not self.failure


@dataclass(slots=True)
class _Runs:
    """The repetitions of one solver on one problem so far; `worst` is the worst verified answer of them all."""

    setup_s: list[float] = field(default_factory=list[float])
    solve_s: list[float] = field(default_factory=list[float])
    iterations: set[int] = field(default_factory=set[int])
    worst: Verification = field(default_factory=lambda: Verification(0.0, 0.0, 0.0))
    status: str = ""

    @classmethod
    def first(cls, answer: Answer, verification: Verification) -> _Runs:
        """The answer that chose the variant. Its time stays only when there is no other: it warms the caches."""
        runs = cls()
        runs.add(answer, verification)
        return runs

    def add(self, answer: Answer, verification: Verification) -> None:
        self.setup_s.append(answer.setup_s)
        self.solve_s.append(answer.solve_s)
        self.iterations.add(answer.iterations)
        self.status = answer.status
        if verification.worst >= self.worst.worst:
            self.worst = verification


def measure(
    instances: Sequence[Instance],
    solvers: Sequence[Solver],
    *,
    repeats: int,
    tol: float,
    patience_s: float = 1.0,
    progress: Callable[[str], None] = lambda line: None,
) -> list[Measurement]:
    """Time every solver on every problem `repeats` times, in the order A B C D, B C D A, … within each problem.

    Before, each solver answers each problem once: this chooses its variant. One whose answer does not verify has no
    time, and is not asked again; one that takes longer than `patience_s` / repeats is asked less often, at least
    `FEWEST` times. A solve from which the operating system took its core away is made again, whosesoever it is.
    Raises ValueError when repeats < 1.
    """
    if repeats < 1:
        raise ValueError(f"repeats = {repeats} must be 1 or more")
    variants: dict[tuple[int, int], Variant] = {}
    runs: dict[tuple[int, int], _Runs] = {}
    visits: dict[tuple[int, int], int] = {}
    for i, instance in enumerate(instances):
        first = all(earlier.group != instance.group for earlier in instances[:i])
        for s, solver in enumerate(solvers):
            if _takes_part(solver, instance, first):
                variants[i, s], answer = _chosen(solver, instance, tol)
                runs[i, s] = _Runs.first(answer, verify(instance.problem, answer))
                visits[i, s] = _visits(runs[i, s], repeats, patience_s)
        progress(f"first answers, problem {i + 1} of {len(instances)}")
    collecting = gc.isenabled()
    gc.disable()
    try:
        for repeat in range(repeats):
            for i, instance in enumerate(instances):
                for k in range(len(solvers)):
                    s = (k + repeat + i) % len(solvers)
                    if repeat < visits.get((i, s), 0):
                        answer = undisturbed(variants[i, s], instance.problem, tol)
                        runs[i, s].add(answer, verify(instance.problem, answer))
            gc.collect()
            progress(f"repetition {repeat + 1} of {repeats}")
    finally:
        if collecting:
            gc.enable()
    return [
        _summary(instances[i], solvers[s].name, variants[i, s].label, runs[i, s]) for i, s in sorted(runs)
    ]


def _takes_part(solver: Solver, instance: Instance, first: bool) -> bool:
    return (
        solver.applies(instance.problem) and solver.timed(instance.problem) and (first or not solver.sampled)
    )


def _visits(runs: _Runs, repeats: int, patience_s: float) -> int:
    """How often to repeat what took so long, and ended so, the first time."""
    if not runs.worst.worst <= COUNTS_BELOW:
        return 0
    once = runs.setup_s[0] + runs.solve_s[0]
    return min(repeats, max(FEWEST, int(patience_s / once)))


def undisturbed(variant: Variant, problem: Problem, tol: float) -> Answer:
    """A cold solve without a forced context switch.

    Where several attempts bring none, the one that kept its core for the largest share of the time, with its times
    scaled by that fraction: what a core did for other processes is not solve time.
    """
    started = time.perf_counter()
    best, best_share = None, 0.0
    for attempt in range(ATTEMPTS):
        switches, wall, cpu = forced_switches(), time.perf_counter(), time.process_time()
        answer = variant.solve(problem, tol)
        if forced_switches() == switches:
            return answer
        share = min(1.0, (time.process_time() - cpu) / (time.perf_counter() - wall))
        if best is None or share > best_share:
            best, best_share = answer, share
        if attempt >= 2 and time.perf_counter() - started > ATTEMPTS_S:
            break
    assert best is not None  # ATTEMPTS ≥ 1
    return replace(best, setup_s=best.setup_s * best_share, solve_s=best.solve_s * best_share)


def forced_switches() -> int:
    """How often this process has lost a core against its will; always 0 where the system does not tell."""
    if sys.platform != "linux":
        return 0
    return resource.getrusage(resource.RUSAGE_SELF).ru_nivcsw


def _chosen(solver: Solver, instance: Instance, tol: float) -> tuple[Variant, Answer]:
    """The first variant whose answer verifies, with that answer; the first of all when none does."""
    answers: list[Answer] = []
    for variant in solver.variants:
        answers.append(variant.solve(instance.problem, tol))
        if verify(instance.problem, answers[-1]).worst <= COUNTS_BELOW:
            return variant, answers[-1]
    return solver.variants[0], answers[0]


def _summary(instance: Instance, solver: str, variant: str, runs: _Runs) -> Measurement:
    worst = runs.worst.worst
    failure = ""
    if not worst <= COUNTS_BELOW:
        failure = (
            f"{runs.status}: verified residual {worst:.1e}"
            if math.isfinite(worst)
            else f"{runs.status}: not finite"
        )
    elif len(runs.iterations) > 1:
        failure = f"iterations differ between cold solves: {sorted(runs.iterations)}"
    timed = slice(1 if len(runs.solve_s) > 1 else 0, None)
    setups, solves = runs.setup_s[timed], runs.solve_s[timed]
    totals = [a + b for a, b in zip(setups, solves, strict=True)]
    return Measurement(
        instance.name,
        instance.group,
        *(instance.problem.n, instance.problem.p, instance.problem.m),
        solver,
        variant,
        runs.status,
        max(runs.iterations),
        runs.worst,
        Spread.of(setups),
        Spread.of(solves),
        Spread.of(totals),
        failure,
    )


def geometric_mean(values: Sequence[float]) -> float:
    """exp of the mean logarithm; NaN of nothing."""
    array: NDArray[np.float64] = np.asarray(values, dtype=np.float64)
    return float(np.exp(np.mean(np.log(array)))) if array.size else float("nan")
