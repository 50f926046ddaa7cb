"""Where tasks run: here, on processes of this machine, or on a Dask cluster. All yield results as they finish."""

from __future__ import annotations

import os
import threading
from collections import Counter, deque
from collections.abc import Generator, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from dataclasses import dataclass, field, replace
from importlib import import_module
from typing import Any, Protocol, cast

from orbsoc.files.interrupts import held

from .store import Columns, StoreError, Task
from .worker import Work, Worker, WorkerLost, answering

Results = Generator[tuple[Task, Columns], None, None]

RETRIES = 2
"""How often a task is done again whose worker was lost."""
BLAS_THREADS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")


class WorkersLost(RuntimeError):
    """Workers died again and again; what is finished is kept."""


class Executor(Protocol):
    """Does tasks in any order."""

    def check(self) -> None:
        """Find out what would keep tasks from being done at all, before anything is written. Raises StoreError."""
        ...

    def results(self, work: Work, tasks: Sequence[Task]) -> Results:
        """Pairs of task and columns as they finish; errors of `work` propagate."""
        ...

    def standing(self) -> AbstractContextManager[Executor]:
        """The same, its workers kept from one call of `results` to the next until the context ends."""
        ...


@dataclass(frozen=True, slots=True)
class Inline:
    """One after the other, in this process."""

    def check(self) -> None:
        """Nothing can be missing."""

    def results(self, work: Work, tasks: Sequence[Task]) -> Results:
        for task in tasks:
            yield task, work(task.payload)

    def standing(self) -> AbstractContextManager[Executor]:
        return nullcontext(self)


@dataclass(frozen=True, slots=True)
class Processes:
    """On `workers` processes of this machine, one thread of linear algebra each."""

    workers: int
    kept: list[Worker] | None = field(default=None, repr=False, compare=False)
    """Those of `standing`."""

    def check(self) -> None:
        """Nothing can be missing."""

    @contextmanager
    def standing(self) -> Iterator[Executor]:
        kept: list[Worker] = []
        try:
            yield replace(self, kept=kept)
        finally:
            _end(kept)

    def results(self, work: Work, tasks: Sequence[Task]) -> Results:
        left, losses = deque(tasks), Counter[str]()
        workers: list[Worker] = [] if self.kept is None else self.kept
        try:
            while left or any(worker.task for worker in workers):
                idle = [worker for worker in workers if worker.task is None]
                while left and (idle or len(workers) < self.workers):
                    if not idle:
                        with held(), _single_threaded_children():
                            workers.append(Worker())
                    (idle.pop() if idle else workers[-1]).give(work, left.popleft())
                for worker, task in answering(workers):
                    try:
                        columns = worker.take()
                    except WorkerLost as error:
                        workers.remove(worker)
                        worker.end()
                        left.appendleft(task)
                        losses[task.place] += 1
                        if losses[task.place] > RETRIES:
                            raise WorkersLost(
                                f"{task.place}: its worker process died {losses[task.place]} times (out of memory?);"
                                " finished shards are kept, resume with fewer workers"
                            ) from error
                        continue
                    if left:
                        worker.give(work, left.popleft())
                    yield task, columns
        finally:
            if self.kept is None or any(worker.task for worker in workers):
                _end(workers)


def _end(workers: list[Worker]) -> None:
    """End workers, whatever they are doing."""
    with held():
        while workers:
            workers.pop().end()


@dataclass(frozen=True, slots=True)
class DaskCluster:
    """On the workers of a Dask scheduler at `address`, or of an embedded cluster of `workers` processes for None."""

    address: str | None
    workers: int = 2
    timeout_s: float = 10.0

    def check(self) -> None:
        """Ask the scheduler for an answer. Raises StoreError when none comes, or Dask is not installed."""
        dask = _dask()
        if self.address is not None:
            self._client(dask, self.address).close()

    def standing(self) -> AbstractContextManager[Executor]:
        return nullcontext(self)

    def _client(self, dask: Any, to: Any) -> Any:
        try:
            return dask.Client(to, timeout=self.timeout_s)
        except (OSError, TimeoutError, ValueError) as error:
            raise StoreError(
                f"--dask = {self.address}: no scheduler answers within {self.timeout_s:g} s ({type(error).__name__})"
            ) from error

    def results(self, work: Work, tasks: Sequence[Task]) -> Results:
        with _without_worker_timeout():
            yield from self._results(work, tasks)

    def _results(self, work: Work, tasks: Sequence[Task]) -> Results:
        dask, cluster = _dask(), None
        with _single_threaded_children():
            if self.address is None:
                cluster = dask.LocalCluster(
                    n_workers=self.workers, threads_per_worker=1, dashboard_address=None
                )
            client = self._client(dask, cluster or self.address)
        try:
            futures = {
                client.submit(work, task.payload, pure=False, retries=RETRIES, key=task.place): task
                for task in tasks
            }
            for future in dask.as_completed(futures):
                columns = future.result()
                task = futures.pop(future)
                future.release()
                yield task, columns
        except dask.scheduler.KilledWorker as error:
            raise WorkersLost(
                "Dask workers died again and again at one task (out of memory?); finished shards are kept, resume with"
                " fewer workers"
            ) from error
        except (dask.CancelledError, dask.comm.core.CommClosedError) as error:
            raise WorkersLost(
                f"--dask = {self.address or 'embedded'}: the scheduler went away ({type(error).__name__}); finished"
                " shards are kept, resume"
            ) from error
        finally:
            client.close()
            if cluster is not None:
                cluster.close()


def _dask() -> Any:
    """The package, typed in parts only. Raises StoreError when it is not installed."""
    try:
        return import_module("distributed")
    except ImportError as error:
        raise StoreError("Dask is not installed; pip install 'orbsoc[reach]'") from error


def _without_worker_timeout() -> AbstractContextManager[object]:
    """An embedded cluster gives a lost worker all the time that it needs to start again.

    Dask gives it 15 s, on its clusters of this process, and closes it for good then; work of a cluster that has no other
    waits for ever.
    """
    _dask()
    setting = {"distributed.deploy.lost-worker-timeout": "1 day"}
    return cast("AbstractContextManager[object]", import_module("dask.config").set(setting))


_environment = threading.Lock()


@contextmanager
def _single_threaded_children() -> Iterator[None]:
    """Processes started here use one thread each for linear algebra: there is one for every core."""
    with _environment:
        before = {name: os.environ.get(name) for name in BLAS_THREADS}
        os.environ.update(dict.fromkeys(BLAS_THREADS, "1"))
        try:
            yield
        finally:
            for name, value in before.items():
                if value is None:
                    os.environ.pop(name, None)
                else:
                    os.environ[name] = value
