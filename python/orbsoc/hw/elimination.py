"""The order in which the KKT matrix is eliminated, chosen by the modelled run.

A core is fastest in the order of fewest operations, and solves on the host keep it. The PL waits for chains: there a shallow
tree may halve a run for more operations. So a run that the PL takes part in is priced in each order that the solver knows,
by the schedules of its own segments, and the fastest of those whose engine fits is taken.
docs/decisions/0018-order-on-the-pl.md has the reasons.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from hw_model.area.budget import budget
from hw_model.report.best import chosen_partition
from hw_model.timing.actions import actions_of
from hw_model.timing.durations import Durations
from hw_model.timing.timeline import makespan_picoseconds
from orbsoc import _core
from orbsoc.conic.settings import ORDERINGS

from .workload import Workload

if TYPE_CHECKING:
    from hw_model import Partition, Platform
    from hw_model.report.study import Point
    from hw_model.timing.stage_cycles import StageCycles

AUTOMATIC = "automatic"
"""The order by the modelled run; to the solver, which knows no engine, the one of fewest operations."""
ORDERS = tuple(name for name in ORDERINGS if name != AUTOMATIC)
"""Orders to choose from, the host's first."""
HOST = ORDERS[0]
"""The order of solves on the host."""


@dataclass(frozen=True, slots=True)
class OrderedRun:
    """A run in one order: whether its engine fits, and how long it takes."""

    ordering: str
    fits: bool
    makespan_picoseconds: int

    @property
    def rank(self) -> tuple[bool, int, int]:
        """The least is taken: what fits before what does not, then the fastest, then the host's order."""
        return (not self.fits, self.makespan_picoseconds, ORDERS.index(self.ordering))


def ordered_run(
    work: Workload, ordering: str, platform: Platform, partition: Partition | str, cycles: StageCycles
) -> OrderedRun:
    """The run of a workload whose segments have these cycles."""
    split = chosen_partition(partition, work.trace, platform, cycles)
    area = budget(work.trace, platform, split, cycles)
    durations = Durations(work.trace, platform, split, cycles, area.programs)
    return OrderedRun(ordering, area.fits, makespan_picoseconds(actions_of(work.trace, split), durations))


def in_order(work: Workload, ordering: str) -> Workload:
    """The same solves with the schedules of another order, and the iterations of the recorded one."""
    return replace(work, settings=tuple(replace(each, ordering=ordering) for each in work.settings))


def differing_orders(work: Workload) -> tuple[str, ...]:
    """The orders that differ from the host's in the factor of at least one pattern; none of a bare trace."""

    def shapes(ordering: str) -> list[tuple[int, int, int]]:
        return [
            _core.factor_shape(problem, replace(settings, ordering=ordering))
            for problem, settings in zip(work.problems, work.settings, strict=True)
        ]

    host = shapes(HOST)
    return tuple(name for name in ORDERS if name != HOST and shapes(name) != host)


def fastest_order(work: Workload, run: Callable[[Workload, str], OrderedRun]) -> str:
    """Of the orders the one whose run ranks first, all with the recorded iterations; `work` was recorded in the host's."""
    others = differing_orders(work)
    if not others:
        return HOST
    runs = [run(in_order(work, name), name) for name in (HOST, *others)]
    return min(runs, key=lambda each: each.rank).ordering


def fastest_points(by_order: Mapping[str, Sequence[Point]]) -> list[Point]:
    """Of each point of a grid that was priced in several orders the one that ranks first; its setting `ordering` says which."""
    priced = with_fastest_baseline(by_order)
    found: dict[object, list[tuple[str, Point]]] = {}
    for ordering, points in priced.items():
        for point in points:
            found.setdefault(_place(point), []).append((ordering, point))

    def rank(pair: tuple[str, Point]) -> tuple[bool, float, int]:
        ordering, point = pair
        return (not point.budget.fits, point.times_ms[0], ORDERS.index(ordering))

    best = (min(pairs, key=rank) for pairs in found.values())
    return [named(point, ordering) for ordering, point in best]


def with_fastest_baseline(by_order: Mapping[str, Sequence[Point]]) -> dict[str, list[Point]]:
    """The same points, all against the PS alone in the order that it is fastest in: a shallow tree makes it slower."""
    least: dict[object, tuple[float, ...]] = {}
    for point in (each for points in by_order.values() for each in points):
        known = least.get(_place(point), point.baselines_ms)
        least[_place(point)] = tuple(map(min, known, point.baselines_ms))
    return {
        ordering: [replace(point, baselines_ms=least[_place(point)]) for point in points]
        for ordering, points in by_order.items()
    }


def named(point: Point, ordering: str) -> Point:
    """A point whose settings say its order."""
    return replace(point, settings={"ordering": ordering, **point.settings})


def _place(point: Point) -> object:
    """What tells the points of a grid apart, but for the order."""
    return point.device, point.partition, point.lanes, point.pl_clock_mhz, tuple(point.settings.items())
