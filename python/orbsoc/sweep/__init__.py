"""Many solves as coarse tasks: on processes of this machine or on a Dask cluster, into shards that survive anything.

A task is a dictionary of plain values; its work is a function of it that returns columns. A shard is one task's table
as a Parquet file: complete or absent, so a sweep that was interrupted, killed or starved of disk is resumed by doing
the tasks whose shards are absent. Needs the extra `reach` (`pip install 'orbsoc[reach]'`).
"""

from .executors import DaskCluster, Executor, Inline, Processes, WorkersLost
from .runner import Report, run
from .store import ShardStore, StoreError, Task

__all__ = [
    "DaskCluster",
    "Executor",
    "Inline",
    "Processes",
    "Report",
    "ShardStore",
    "StoreError",
    "Task",
    "WorkersLost",
    "run",
]
