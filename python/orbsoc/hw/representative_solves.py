"""What a solve costs the emulated computer, from a few that stand for many of their sparsity pattern."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from hw_model import Trace, parse_trace
from hw_model.timing.actions import Action, actions_of
from hw_model.timing.durations import Durations
from hw_model.timing.timeline import as_partition, as_platform, makespan_picoseconds
from orbsoc.conic.problem import Problem
from orbsoc.conic.solution import Status

from .emulation import PsScheduler
from .exact_cycles import exact_cycles

if TYPE_CHECKING:
    from hw_model.platform.platform import Platform

PICOSECONDS_PER_US = 1e6


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

    traces: tuple[Trace, ...]
    iterations: tuple[int, ...]
    patterns: tuple[tuple[Problem, ...], ...]
    _makespans: dict[tuple[str, str], list[int]] = field(default_factory=dict, init=False, repr=False)
    _actions: dict[str, list[list[Action]]] = field(default_factory=dict, init=False, repr=False)
    """Found before, by names: actions depend on the partition alone."""

    @classmethod
    def of(cls, subproblems: Iterable[tuple[Problem, float]]) -> RepresentativeSolves:
        """Solve each problem to its tolerance. Raises KeyboardInterrupt when interrupted."""
        found: list[tuple[Trace, int, tuple[Problem, ...]]] = []
        for problem, tol in subproblems:
            scheduler = PsScheduler(tol=tol)
            solution = scheduler(problem)
            if solution.status is Status.INTERRUPTED:
                raise KeyboardInterrupt
            found.append((parse_trace(scheduler.trace), solution.iterations, scheduler.patterns))
        return cls(*zip(*found, strict=True))

    def price(self, device: str, partition: str) -> SolvePrice:
        """The price on a device under a partition, by exact schedules, the start of a solve included.

        Raises `hw_model.HwModelError` for unknown names, and for a device whose PL has no schedules.
        """
        clock = as_platform(device).pl.clock_mhz.value
        taken = self._taken(device, partition)
        priced = np.array(taken, float) * clock / PICOSECONDS_PER_US
        iterations = np.array(self.iterations, float)
        return SolvePrice(
            iterations=float(iterations.mean()),
            cycles_per_iteration=float(priced.sum() / iterations.sum()),
            most_cycles=float(priced.max()),
            pl_clock_mhz=clock,
            speedup=sum(self._taken(device, "all_ps")) / sum(taken),
        )

    def _taken(self, device: str, partition: str) -> list[int]:
        """Picoseconds of each solve. Those of one pattern share what its stages take."""
        found = self._makespans.get((device, partition))
        if found is None:
            found = self._makespans[device, partition] = self._timed(as_platform(device), partition)
        return found

    def _timed(self, platform: Platform, partition: str) -> list[int]:
        sides = as_partition(partition)
        if partition not in self._actions:
            self._actions[partition] = [actions_of(trace, sides) for trace in self.traces]
        known: list[Durations] = []
        out: list[int] = []
        for trace, problems, actions in zip(
            self.traces, self.patterns, self._actions[partition], strict=True
        ):
            durations = next((each for each in known if _same_stages(each.trace, trace)), None)
            if durations is None:
                durations = Durations(trace, platform, sides, exact_cycles(problems))
                known.append(durations)
            out.append(makespan_picoseconds(actions, durations))
        return out


def _same_stages(one: Trace, other: Trace) -> bool:
    return (one.datapath, one.ps_datapath, one.patterns) == (
        other.datapath,
        other.ps_datapath,
        other.patterns,
    )
