"""Interleaved timing: every solver on every problem, again and again, in one process, each answer verified."""

from __future__ import annotations

import gc
import math
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from benchmarks.answer import Answer, Solver, Variant
from benchmarks.families import Instance
from orbsoc.verify import Verification, verify

if sys.platform == "linux":
    import resource

ATTEMPTS = 20
"""Cold solves made at most until one ran undisturbed."""
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


@dataclass(frozen=True, slots=True, eq=False)
class Measurement:
    """One solver on one problem. Where `failure` is not empty the times do not count, and it says why."""

    instance: Instance
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
    progress: Callable[[str], None] = lambda line: None,
) -> list[Measurement]:
    """Time every solver on every problem `repeats` times, in the order A B C D, B C D A, … within each problem.

    Before, each solver answers each problem once, untimed: this chooses its variant. A solve from which the
    operating system took its core away is made again, whosesoever it is. Raises ValueError when repeats < 1.
    """
    if repeats < 1:
        raise ValueError(f"repeats = {repeats} must be 1 or more")
    variants = {
        (i, s): _chosen(solver, instance, tol)
        for i, instance in enumerate(instances)
        for s, solver in enumerate(solvers)
    }
    runs: dict[tuple[int, int], _Runs] = {key: _Runs() for key in variants}
    collecting = gc.isenabled()
    gc.disable()
    try:
        for repeat in range(repeats):
            for i, instance in enumerate(instances):
                for k in range(len(solvers)):
                    s = (k + repeat + i) % len(solvers)
                    answer = _undisturbed(variants[i, s], instance, tol)
                    runs[i, s].add(answer, verify(instance.problem, answer))
            gc.collect()
            progress(f"repetition {repeat + 1} of {repeats}")
    finally:
        if collecting:
            gc.enable()
    return [
        _summary(instances[i], solvers[s].name, variants[i, s].label, found) for (i, s), found in runs.items()
    ]


def _undisturbed(variant: Variant, instance: Instance, tol: float) -> Answer:
    """A cold solve without a forced context switch; the last of `ATTEMPTS` when there is none."""
    for _ in range(ATTEMPTS - 1):
        before = forced_switches()
        answer = variant.solve(instance.problem, tol)
        if forced_switches() == before:
            return answer
    return variant.solve(instance.problem, tol)


def forced_switches() -> int:
    """How often this thread has lost its core against its will; always 0 where the system does not tell."""
    if sys.platform != "linux":
        return 0
    return resource.getrusage(resource.RUSAGE_THREAD).ru_nivcsw


def _chosen(solver: Solver, instance: Instance, tol: float) -> Variant:
    """The first variant whose answer verifies; the first of all when none does."""
    for variant in solver.variants:
        answer = variant.solve(instance.problem, tol)
        if verify(instance.problem, answer).worst <= COUNTS_BELOW:
            return variant
    return solver.variants[0]


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
    totals = [a + b for a, b in zip(runs.setup_s, runs.solve_s, strict=True)]
    return Measurement(
        instance,
        solver,
        variant,
        runs.status,
        max(runs.iterations),
        runs.worst,
        Spread.of(runs.setup_s),
        Spread.of(runs.solve_s),
        Spread.of(totals),
        failure,
    )


def geometric_mean(values: Sequence[float]) -> float:
    """exp of the mean logarithm; NaN of nothing."""
    array: NDArray[np.float64] = np.asarray(values, dtype=np.float64)
    return float(np.exp(np.mean(np.log(array)))) if array.size else float("nan")
