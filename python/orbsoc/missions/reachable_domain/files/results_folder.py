"""Solve a scenario's domain into a results folder."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from orbsoc.sweep import Executor, Report, ShardStore, Task, run
from orbsoc.sweep.store import Columns

from ..continuation.domain import Domain
from ..continuation.tasks import boundary_shards, grid_shards, solve_boundary_shard, solve_grid_shard
from ..query.results import BOUNDARY, POINTS
from ..scenario import Scenario

Watcher = Callable[[Report, Task, Columns], None]


def solve_into(
    folder: Path, scenario: Scenario, executor: Executor, watch: Watcher, *, resume: bool = False
) -> tuple[Report, Report]:
    """Do the shards of the boundary and of the grid that are absent; `watch` sees each. Returns both reports.

    Raises `orbsoc.sweep.StoreError`, WorkersLost and KeyboardInterrupt; finished shards stay.
    """
    executor.check()
    domain = Domain.of(scenario)
    store = ShardStore.open(folder, scenario.model_dump(mode="json"), resume=resume)
    edge = [Task(BOUNDARY, k, rows, payload) for k, (rows, payload) in enumerate(boundary_shards(domain))]
    grid = [Task(POINTS, k, rows, payload) for k, (rows, payload) in enumerate(grid_shards(domain))]
    return (
        run(store, edge, solve_boundary_shard, executor, watch),
        run(store, grid, solve_grid_shard, executor, watch),
    )
