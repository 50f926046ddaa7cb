"""Do the tasks whose shards are absent, and put every result on disk as it comes."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import dataclass

from .executors import Executor
from .store import Columns, ShardStore, StoreError, Task
from .worker import Work


@dataclass(frozen=True, slots=True)
class Report:
    """How far a sweep is: shards and rows done in this run and before, and seconds spent in this run."""

    shards: int
    shards_done: int
    rows: int
    rows_before: int
    rows_done: int
    elapsed_s: float

    @property
    def remaining_s(self) -> float:
        """Estimate from this run's pace; NaN before the first shard."""
        fresh = self.rows_done - self.rows_before
        return self.elapsed_s * (self.rows - self.rows_done) / fresh if fresh else float("nan")


Watcher = Callable[[Report, Task, Columns], None]


def run(store: ShardStore, tasks: Sequence[Task], work: Work, executor: Executor, watch: Watcher) -> Report:
    """Run what is left of `tasks`; `watch` sees every shard once it is on disk.

    Raises what `work` raises, WorkersLost, StoreError when a shard cannot be written, and KeyboardInterrupt; finished
    shards stay in every case.
    """
    left = [task for task in tasks if not store.is_finished(task)]
    rows = sum(task.rows for task in tasks)
    before = rows - sum(task.rows for task in left)
    started, done, shards = time.perf_counter(), before, len(tasks) - len(left)
    report = Report(len(tasks), shards, rows, before, done, 0.0)
    if not left:
        return report
    with closing(executor.results(work, left)) as results:
        for task, columns in results:
            try:
                store.write(task, columns)
            except OSError as error:
                raise StoreError(
                    f"{store.folder / task.place}: cannot be written: {error.strerror}; finished shards are kept, free some"
                    " space and resume"
                ) from error
            done, shards = done + task.rows, shards + 1
            report = Report(len(tasks), shards, rows, before, done, time.perf_counter() - started)
            watch(report, task, columns)
    return report
