"""A sweep as it goes on: where it runs; a bar with the time left on a terminal, plain lines elsewhere."""

from __future__ import annotations

import math
import os
from types import TracebackType
from typing import Self

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from orbsoc.sweep import DaskCluster, Executor, Processes, Report, Task
from orbsoc.sweep.store import Columns

EMBEDDED = "embedded"


def executor_of(dask: str | None, workers: int | None) -> Executor:
    """Processes of this machine, all its cores by default, or a Dask cluster by its address."""
    count = workers or len(os.sched_getaffinity(0))
    if dask is None:
        return Processes(count)
    return DaskCluster(None if dask == EMBEDDED else dask, count)


class SweepProgress:
    """Shows every shard it is called with. Use as a context manager; one bar per dataset."""

    def __init__(self, console: Console) -> None:
        self._console = console
        self._progress: Progress | None = None
        self._bars: dict[str, int] = {}

    def __call__(self, report: Report, task: Task, columns: Columns) -> None:
        left = "" if math.isnan(report.remaining_s) else f"{report.remaining_s:.0f} s left"
        if self._progress is None:
            line = f"{task.dataset}: shard {report.shards_done} of {report.shards}, {report.rows_done} of {report.rows} rows"
            self._console.print(f"{line}, {left}", markup=False, highlight=False, soft_wrap=True)
            return
        if task.dataset not in self._bars:
            self._bars[task.dataset] = self._progress.add_task(task.dataset, total=report.rows, left="")
        self._progress.update(self._bars[task.dataset], completed=report.rows_done, left=left)  # type: ignore[arg-type]

    def __enter__(self) -> Self:
        if self._console.is_terminal:
            self._progress = Progress(
                TextColumn("{task.description:>8}"),
                BarColumn(),
                MofNCompleteColumn(),
                TimeElapsedColumn(),
                TextColumn("{task.fields[left]}"),
                console=self._console,
            )
            self._progress.__enter__()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._progress is not None:
            self._progress.__exit__(kind, error, trace)
            self._progress = None
