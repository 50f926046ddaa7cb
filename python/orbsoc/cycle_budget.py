"""What a plan's subproblems would cost the emulated computer: the bridge from a plan to `hw_model`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import hw_model
from orbsoc.ps import PsScheduler
from orbsoc.scp import Iteration, Solve
from orbsoc.settings import Settings
from orbsoc.solution import Solution, Status
from orbsoc.solver import solve


@dataclass(frozen=True, slots=True)
class CycleBudget:
    """A modelled run of every subproblem of a plan. `same_bits`: scheduled and native solves agree bit for bit."""

    report: hw_model.Report
    same_bits: bool

    def summary(self) -> dict[str, Any]:
        """The `hardware` entry of `plan.json`; every number is modelled at the nominal parameters."""
        report = self.report
        return {
            "provenance": "modelled",
            "device": report.device,
            "partition": report.partition,
            "cycles": dict(report.cycles),
            "time_ms": report.makespan_ms.nominal,
            "speedup": report.speedup.nominal,
            "verdict": report.deadline.verdict if report.deadline else None,
            "headline": report.headline,
            "deadline": report.deadline_line or None,
            "same_bits": self.same_bits,
        }

    def to_dict(self) -> dict[str, Any]:
        """The content of `hardware.json`."""
        return {"same_bits": self.same_bits, **self.report.to_dict()}


def check_names(device: str, partition: str) -> None:
    """Raise `hw_model.HwModelError` unless both name (or are paths of) what the model knows."""
    hw_model.load_platform(device)
    hw_model.load_partition(partition)


def cycle_budget(
    iterations: Sequence[Iteration],
    *,
    device: str,
    partition: str,
    deadline_ms: float | None,
    scheduled: PsScheduler | None = None,
) -> CycleBudget:
    """Price every subproblem of `iterations` on `device` under `partition`.

    The trace is that of `scheduled`, the scheduler that made the plan, or comes from solving the same subproblems
    again on a new one. Either way each is solved by the other path too, and the bits are compared.
    Raises `hw_model.HwModelError` for unknown names or an impossible deadline, KeyboardInterrupt when a solve was
    interrupted: a truncated trace would be priced too low.
    """
    scheduler = scheduled or PsScheduler()
    other: Solve = solve if scheduled else scheduler
    same_bits = True
    for row in iterations:  # every one, even after a difference: the trace must hold the whole plan
        again = other(row.problem, Settings(tol=row.tolerance))
        if again.status is Status.INTERRUPTED:
            raise KeyboardInterrupt
        same_bits &= _same_bits(again, row.solution)
    report = hw_model.speedup(scheduler.trace, device, partition, deadline_ms=deadline_ms)
    return CycleBudget(report, same_bits)


def _same_bits(one: Solution, other: Solution) -> bool:
    """Whether status, iterations and every word of x, y, s and z are the same; −0 is not 0 here."""
    ended_alike = (one.status, one.iterations) == (other.status, other.iterations)
    return ended_alike and all(
        getattr(one, name).tobytes() == getattr(other, name).tobytes() for name in ("x", "y", "s", "z")
    )
