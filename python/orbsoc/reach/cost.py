"""What the sweep would cost on the emulated computer: the modelled time of its subproblems, times their number.

The cycle model prices condensed subproblems of two cold sequences, as `orbsoc plan` prices a plan, and a subproblem
of the sweep is priced as their mean: the emulated computer solves each by the interior-point method, whatever this
machine did (most of them it solves by Newton on the dual). All are priced as on 12 nodes; those on finer grids cost
more. Generating the data, flights and Newton's polish are the PS's own and not priced.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from itertools import product
from typing import Any

import numpy as np

import hw_model
from orbsoc.missions.reachable_domain.condensed import condense
from orbsoc.missions.reachable_domain.domain import Domain
from orbsoc.missions.reachable_domain.guess import towards_planes
from orbsoc.missions.reachable_domain.terminal import LargestOrbit
from orbsoc.orbit import EARTH
from orbsoc.problem import Problem
from orbsoc.ps import PsScheduler
from orbsoc.solution import Status

from .results import ReachableDomain

RECORDED_EACH = 4
"""Subproblems of a sequence that are priced, each at both tolerances of the sequence."""


@dataclass(frozen=True, slots=True)
class DomainCost:
    """Modelled cost on one device under one partition: of a subproblem, in the mean and at most, with its interior-point
    iterations in the mean, and of the whole domain. `points_per_s` counts every point of the table, held ones included.
    """

    device: str
    partition: str
    pl_clock_mhz: float
    subproblem_us: float
    most_us: float
    iterations: float
    domain_s: float
    point_us: float
    point_pl_cycles: float
    points_per_s: float
    deadline_ms: float | None
    points_within_deadline: int | None

    def to_dict(self) -> dict[str, Any]:
        """Plain data, marked as what it is."""
        return {"provenance": "modelled", **asdict(self)}

    @property
    def words(self) -> str:
        """The cost in a sentence."""
        text = (
            f"modelled: {self.partition} on {self.device} solves the subproblems of {self.points_per_s:.0f} points per"
            f" second, the whole domain in {self.domain_s:.1f} s ({self.point_us:.0f} us a point)"
        )
        if self.deadline_ms is not None:
            text += f"; {self.points_within_deadline} points within {self.deadline_ms:g} ms"
        return text


@dataclass(frozen=True, slots=True)
class RecordedSequence:
    """Traces of subproblems of cold sequences, and the interior-point iterations of each."""

    traces: tuple[dict[str, Any], ...]
    iterations: tuple[int, ...]

    @classmethod
    def of(cls, domain: Domain) -> RecordedSequence:
        """Solve the subproblems of two sequences on the emulated computer. KeyboardInterrupt when interrupted."""
        traces, iterations = [], []
        rules = domain.tools.rules
        for problem, tol in product(_recorded(domain), (rules.loose_tol, rules.tight_tol)):
            scheduler = PsScheduler(tol=tol)
            solution = scheduler(problem)
            if solution.status is Status.INTERRUPTED:
                raise KeyboardInterrupt
            traces.append(scheduler.trace)
            iterations.append(solution.iterations)
        return cls(tuple(traces), tuple(iterations))


def domain_cost(
    found: ReachableDomain,
    *,
    device: str,
    partition: str,
    deadline_ms: float | None = None,
    recorded: RecordedSequence | None = None,
) -> DomainCost:
    """Price the subproblems that the table counts. Raises `hw_model.HwModelError` for unknown names."""
    recorded = recorded or RecordedSequence.of(found.domain)
    reports = [hw_model.speedup(trace, device, partition) for trace in recorded.traces]
    times_us = [1e3 * report.makespan_ms.nominal for report in reports]
    each_us = float(np.mean(times_us))
    total_us = each_us * int(found.points["sequence_iterations"].sum())
    points, clock = len(found.points["status"]), reports[0].pl_clock_mhz
    return DomainCost(
        device=device,
        partition=partition,
        pl_clock_mhz=clock,
        subproblem_us=each_us,
        most_us=max(times_us),
        iterations=float(np.mean(recorded.iterations)),
        domain_s=total_us / 1e6,
        point_us=total_us / points,
        point_pl_cycles=total_us / points * clock,
        points_per_s=1e6 * points / total_us,
        deadline_ms=deadline_ms,
        points_within_deadline=None if deadline_ms is None else int(1e3 * deadline_ms * points / total_us),
    )


def cost_table(found: ReachableDomain, recorded: RecordedSequence) -> list[DomainCost]:
    """The cost on every device and under every partition that the model ships."""
    return [
        domain_cost(found, device=device, partition=partition, recorded=recorded)
        for device in hw_model.platform_names()
        for partition in hw_model.partition_names()
    ]


def _recorded(domain: Domain) -> list[Problem]:
    """The first subproblems of two cold sequences to a plane tilted a few degrees: at the lowest perigee bound of the
    grid, which is idle there, and at the highest, which binds."""
    from orbsoc.solver import solve

    normal = domain.frame.tilted(np.deg2rad([3.0]), np.array([0.5]))
    collocation = domain.tools.collocation(domain.tools.nodes)
    problems: list[Problem] = []
    for height_km in domain.scenario.grid.perigee_height_km.values()[[0, -1]]:
        aim = LargestOrbit(normal, np.array([1.0 + 1e3 * height_km / EARTH.earth_radius_m]))
        arcs = towards_planes(collocation, normal)
        for _ in range(RECORDED_EACH):
            linear = collocation.end_map(arcs)
            problem = condense(linear, aim.rows(arcs.ends)).problem(0)
            solution = solve(problem)
            if solution.status is not Status.SOLVED:
                break
            problems.append(problem)
            arcs = collocation.arcs(linear, solution.x.reshape(arcs.controls.shape))
    return problems
