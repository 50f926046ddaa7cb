"""Solve a scenario's domain into a results folder."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from orbsoc.orbit.array import Array
from orbsoc.sweep import DaskCluster, Executor, Inline, Processes, Report, ShardStore, Task, run
from orbsoc.sweep.store import JOURNAL, Columns

from ..scenario import Scenario
from ..search.continuation.boundary import first_azimuths, next_azimuths
from ..search.continuation.domain import Domain
from ..search.continuation.tasks import boundary_shards, grid_shards, solve_boundary_shard, solve_grid_shard
from ..search.query.results import BOUNDARY, POINTS

Watcher = Callable[[Report, Task, Columns], None]


def solve_into(
    folder: Path, scenario: Scenario, executor: Executor, watch: Watcher, *, resume: bool = False
) -> tuple[Report, ...]:
    """Do the shards of the boundary and of the grid that are absent; `watch` sees each. Returns the reports of both.

    Raises `orbsoc.sweep.StoreError`, WorkersLost and KeyboardInterrupt; finished shards stay.
    """
    executor.check()
    domain = Domain.of(scenario)
    store = ShardStore.open(folder, scenario.model_dump(mode="json"), resume=resume)
    grid = [Task(POINTS, k, rows, payload) for k, (rows, payload) in enumerate(grid_shards(domain))]
    first = _boundary_tasks(domain, first_azimuths(domain), 0)
    if len(first) == len(grid) == 1 and isinstance(executor, Processes):
        executor = Inline()  # nothing to share out
    if not isinstance(executor, DaskCluster):  # its workers may have other disks
        for task in grid:
            task.payload["journal"] = str((folder / task.place / JOURNAL).resolve())
    with executor.standing() as workers:
        edge = _solve_boundary(store, domain, first, workers, watch)
        return *edge, run(store, grid, solve_grid_shard, workers, watch)


def _solve_boundary(
    store: ShardStore, domain: Domain, first: list[Task], executor: Executor, watch: Watcher
) -> list[Report]:
    """The first azimuths, then those added where the edge bends, a few at a time: which follows from the shards before. A Dask
    cluster is not asked for these, since its every use takes longer than they do."""
    reports = [run(store, first, solve_boundary_shard, executor, watch)]
    number, near = len(first), Inline() if isinstance(executor, DaskCluster) else executor
    while True:
        azimuths = next_azimuths(domain.scenario.boundary, store.read(BOUNDARY))
        if not azimuths.size:
            return reports
        more = _boundary_tasks(domain, azimuths, number)
        reports.append(run(store, more, solve_boundary_shard, near, watch))
        number += len(more)


def _boundary_tasks(domain: Domain, azimuths: Array, first: int) -> list[Task]:
    """Tasks numbered from `first`."""
    shards = enumerate(boundary_shards(domain, azimuths), start=first)
    return [Task(BOUNDARY, k, rows, payload) for k, (rows, payload) in shards]
