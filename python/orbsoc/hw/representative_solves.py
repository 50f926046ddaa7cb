"""What a solve costs the emulated computer, from a few that stand for many of their sparsity pattern."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

import hw_model
from orbsoc.conic.problem import Problem
from orbsoc.conic.solution import Status

from .emulation import PsScheduler
from .exact_cycles import exact_cycles


@dataclass(frozen=True, slots=True)
class SolvePrice:
    """Modelled price of a solve: its interior-point iterations in the mean, the PL's cycles per iteration (a solve's start
    is shared out among them), the most cycles of a solve that was priced, the clock that counts them, and how many times
    as long everything on the PS takes."""

    iterations: float
    cycles_per_iteration: float
    most_cycles: float
    pl_clock_mhz: float
    speedup: float


@dataclass(frozen=True, slots=True)
class RepresentativeSolves:
    """Traces of solves on the emulated computer, the iterations of each, and the problems of their patterns, which are
    what schedules are made from."""

    traces: tuple[dict[str, Any], ...]
    iterations: tuple[int, ...]
    patterns: tuple[tuple[Problem, ...], ...]

    @classmethod
    def of(cls, subproblems: Iterable[tuple[Problem, float]]) -> RepresentativeSolves:
        """Solve each problem to its tolerance. Raises KeyboardInterrupt when interrupted."""
        found: list[tuple[dict[str, Any], int, tuple[Problem, ...]]] = []
        for problem, tol in subproblems:
            scheduler = PsScheduler(tol=tol)
            solution = scheduler(problem)
            if solution.status is Status.INTERRUPTED:
                raise KeyboardInterrupt
            found.append((scheduler.trace, solution.iterations, scheduler.patterns))
        return cls(*zip(*found, strict=True))

    def price(self, device: str, partition: str) -> SolvePrice:
        """The price on a device under a partition, by exact schedules, the start of a solve included.

        Raises `hw_model.HwModelError` for unknown names, and for a device whose PL has no schedules.
        """
        reports = [
            hw_model.speedup(trace, device, partition, cycles=exact_cycles(problems))
            for trace, problems in zip(self.traces, self.patterns, strict=True)
        ]
        clock = reports[0].pl_clock_mhz
        priced = np.array([1e3 * report.makespan_ms.nominal * clock for report in reports])
        iterations = np.array(self.iterations, float)
        return SolvePrice(
            iterations=float(iterations.mean()),
            cycles_per_iteration=float(priced.sum() / iterations.sum()),
            most_cycles=float(priced.max()),
            pl_clock_mhz=clock,
            speedup=sum(report.baseline_ms.nominal for report in reports)
            / sum(report.makespan_ms.nominal for report in reports),
        )
