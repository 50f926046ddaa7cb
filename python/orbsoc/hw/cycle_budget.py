"""What a plan's subproblems would cost the emulated computer: the bridge from a plan to `hw_model`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import hw_model
from hw_model.area.budget import Budget
from hw_model.figures.gantt import gantt_figure
from hw_model.platform.partition import BEST
from hw_model.report.best import chosen_partition
from hw_model.timing.groups import require_one_problem
from hw_model.timing.schedules import engine_of
from hw_model.timing.stage_cycles import StageCycles, estimated
from orbsoc.conic.solution import Solution, Status
from orbsoc.guidance.mission import SolvedProblem
from orbsoc.guidance.outer_loop import OuterLoop
from orbsoc.guidance.scp import Solve
from orbsoc.hw.emulation import PsScheduler
from orbsoc.solving.solver import solve

from .elimination import HOST, OrderedRun, fastest_order, ordered_run
from .exact_cycles import exact_cycles
from .outer_loop import with_outer_loop
from .workload import Workload, record_trace

SOLVES = "the conic solves of the plan"
"""What the time is modelled of: each problem's generation, as assumed, and its solve; not the rest of the outer loop."""
WHOLE = "the whole plan"
"""The same with the outer loop, where the mission has a program in C and its instructions were counted."""


@dataclass(frozen=True, slots=True)
class CycleBudget:
    """A modelled run of every subproblem of a plan. `same_bits`: scheduled and native solves agree bit for bit.

    `deadline_ms` is what was asked; the report judges it only when there is a verified plan that took the time. An engine that
    the device does not hold fails it, whatever the time.
    """

    report: hw_model.Report
    same_bits: bool
    deadline_ms: float | None
    exact: bool
    """Whether the PL's cycles are those of schedules, equal to the RTL, or estimated."""
    timeline: hw_model.Timeline
    """The same run, piece by piece."""
    ordering: str = HOST
    """The order in which the PL eliminates; the plan's own solves are in the host's."""

    @property
    def scope(self) -> str:
        """What the time is of."""
        return WHOLE if self.report.outer_loop else SOLVES

    def draw(self, path: Path) -> None:
        """The run as a Gantt chart of PS, PL modules, link and interrupts, with its longest iteration magnified; PNG."""
        gantt_figure(self.timeline, path)

    @property
    def headline(self) -> str:
        """The model's headline, and what it is about."""
        cycles = "" if self.report.estimated else f" {self.cycles} PL cycles;"
        order = "" if self.ordering == HOST else f" eliminated in the order {self.ordering};"
        fit = f" {self.fit};" if self.area.fits else ""
        return (
            f"{self.scope}, {self.report.headline};{cycles}{order}{fit} {self.report.price_line};"
            f" {self.report.loading.words}; {self.report.energy_line}"
        )

    @property
    def area(self) -> Budget:
        """What the engine takes of the device."""
        return self.report.area

    @property
    def cycles(self) -> str:
        """Where the PL's cycles come from, in a word: "exact" schedules, equal to the RTL, or "estimated"."""
        if not self.report.modules_on_pl:
            return "no"
        return "exact" if self.exact else "estimated"

    @property
    def deadline_line(self) -> str:
        """One sentence on the deadline, or on why it is not judged; empty when none was given."""
        if self.deadline_ms is None:
            return ""
        times, found = self.report.makespan_ms, self.report.deadline
        took = f"{times.nominal:.3f} ms ({times.low:.3f}–{times.high:.3f})"
        if found is None:
            return (
                f"no deadline verdict: there is no verified plan that could meet {self.deadline_ms:g} ms;"
                f" {SOLVES} that was tried take a modelled {took}"
            )
        said = f"{took} {found.words}; binding is {self.report.bottleneck}"
        judged = f"{said}; {self.fit}" if self.area.fits else f"{self.fit}; if it did, {said}"
        left_out = "" if self.report.outer_loop else "; the rest of the outer loop is not in it"
        return f"modelled deadline verdict for {self.scope}, {self.cycles} PL cycles: {found.verdict}: {judged}{left_out}"

    def summary(self) -> dict[str, Any]:
        """The `hardware` entry of `plan.json`; every number is modelled at the nominal parameters."""
        report = self.report
        return {
            "provenance": "modelled",
            "scope": self.scope,
            "outer_loop": report.outer_loop,
            "device": report.device,
            "partition": report.partition,
            "cycles": dict(report.cycles),
            "pl_cycles_from": self.cycles,
            "time_ms": report.makespan_ms.nominal,
            "speedup": report.speedup.nominal,
            "energy_mj": report.energy.nominal_mj,
            "verdict": report.deadline.verdict if report.deadline else None,
            "headline": self.headline,
            "deadline": self.deadline_line or None,
            "fits": self.area.fits,
            "same_bits": self.same_bits,
            "ordering": self.ordering,
        }

    @property
    def fit(self) -> str:
        """Whether the engine fits into the device, in words."""
        return self.area.words if self.report.modules_on_pl else "no engine is needed"

    def to_dict(self) -> dict[str, Any]:
        """The content of `hardware.json`."""
        words = {"headline": self.headline, "deadline_line": self.deadline_line}
        return {"same_bits": self.same_bits, "scope": self.scope, **self.report.to_dict(), **words}


def check_names(device: str, partition: str, *, exact: bool = True) -> None:
    """Raise `hw_model.HwModelError` unless both name (or are paths of) what the model knows.

    `exact`: and unless the device's PL has schedules. Raises it, too, for a device that interleaves problems.
    """
    platform = hw_model.load_platform(device)
    require_one_problem(platform)
    if exact and (partition == BEST or hw_model.load_partition(partition).uses_pl):
        engine_of(platform, "f64")


def cycle_budget(
    subproblems: Sequence[SolvedProblem],
    *,
    device: str,
    partition: str,
    deadline_ms: float | None,
    verified: bool,
    scheduled: PsScheduler | None = None,
    exact: bool = True,
    outer_loop: OuterLoop | None = None,
) -> CycleBudget:
    """Price every subproblem of a plan on `device` under `partition`.

    The trace is that of `scheduled`, the scheduler that made the plan, or comes from solving the same subproblems
    again on a new one. `outer_loop`: what the program on board does around the solves, where it was counted.
    `exact`: cycles of the PL from schedules, not estimated. Where another order of elimination is faster
    on the PL, they are solved once more in that one, against the PS alone in the host's. `deadline_ms` is judged only for a
    `verified` plan: no deadline is met without one. Each is solved by the other path too, and the bits are compared.
    Raises `hw_model.HwModelError` for unknown names or an impossible deadline, KeyboardInterrupt when a solve was
    interrupted: a truncated trace would be priced too low.
    """
    scheduler = scheduled or PsScheduler()
    same_bits = _solved_alike(subproblems, solve if scheduled else scheduler)
    host, platform = _workload(scheduler, outer_loop), hw_model.load_platform(device)
    work, ordering = _in_fastest_order(subproblems, host, platform, partition, outer_loop, exact=exact)
    judged_ms = deadline_ms if verified else None
    cycles = _cycles(work, exact=exact)
    split = chosen_partition(partition, work.trace, platform, cycles)
    report = hw_model.speedup(
        work.trace, platform, split, deadline_ms=judged_ms, cycles=cycles, baseline_trace=host.trace
    )
    timeline = hw_model.simulate(work.trace, platform, split, cycles)
    return CycleBudget(report, same_bits, deadline_ms, exact, timeline, ordering)


def _solved_alike(subproblems: Sequence[SolvedProblem], other: Solve) -> bool:
    """Whether the other path gives each subproblem's bits. Raises KeyboardInterrupt when a solve was interrupted."""
    same_bits = True
    for row in subproblems:  # every one, even after a difference: the trace must hold the whole plan
        again = other(row.problem, row.settings)
        if again.status is Status.INTERRUPTED:
            raise KeyboardInterrupt
        same_bits &= _same_bits(again, row.solution)
    return same_bits


def _workload(scheduler: PsScheduler, outer_loop: OuterLoop | None) -> Workload:
    trace = with_outer_loop(scheduler.trace, outer_loop)
    return record_trace(trace, "plan", "plan", scheduler.patterns, scheduler.pattern_settings)


def _cycles(work: Workload, *, exact: bool) -> StageCycles:
    return exact_cycles(work.problems, settings=work.settings) if exact else estimated


def _in_fastest_order(
    subproblems: Sequence[SolvedProblem],
    host: Workload,
    platform: hw_model.Platform,
    partition: str,
    outer_loop: OuterLoop | None,
    *,
    exact: bool,
) -> tuple[Workload, str]:
    """The subproblems as the PL runs them, and in which order of elimination: the host's, if another solves one otherwise."""

    def run(work: Workload, name: str) -> OrderedRun:
        return ordered_run(work, name, platform, partition, _cycles(work, exact=exact))

    ordering = fastest_order(host, run) if exact else HOST
    if ordering == HOST:
        return host, HOST
    scheduler = PsScheduler(every_ordering=ordering)
    for row in subproblems:
        again = scheduler(row.problem, row.settings)
        if again.status is Status.INTERRUPTED:
            raise KeyboardInterrupt
        if again.status is not row.solution.status:
            return host, HOST
    return _workload(scheduler, outer_loop), ordering


def _same_bits(one: Solution, other: Solution) -> bool:
    """Whether status, iterations and every word of x, y, s and z are the same; −0 is not 0 here."""
    ended_alike = (one.status, one.iterations) == (other.status, other.iterations)
    return ended_alike and all(
        getattr(one, name).tobytes() == getattr(other, name).tobytes() for name in ("x", "y", "s", "z")
    )
