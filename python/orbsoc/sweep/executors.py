"""Where tasks run: here, on processes of this machine, or on a Dask cluster. All yield results as they finish."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import closing, contextmanager
from dataclasses import dataclass
from importlib import import_module
from multiprocessing.process import BaseProcess
from typing import Any, Protocol

from orbsoc.interrupts import held

from .store import Columns, StoreError, Task
from .worker import do, follow

Work = Callable[[dict[str, Any]], Columns]
"""A function of a task's payload at the top of a module, so that other processes can find it."""

Results = Generator[tuple[Task, Columns], None, None]

RETRIES = 2
"""How often a task is done again whose worker was lost."""
SIGNALS_LOOKED_AT_S = 0.1
"""How often Ctrl-C is looked for while workers work."""
DISMISSAL_S = 5.0
"""How long a worker may take to give up its task before it is killed."""
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


@dataclass(frozen=True, slots=True)
class Inline:
    """One after the other, in this process."""

    def check(self) -> None:
        """Nothing can be missing."""

    def results(self, work: Work, tasks: Sequence[Task]) -> Results:
        for task in tasks:
            yield task, work(task.payload)


@dataclass(frozen=True, slots=True)
class Processes:
    """On `workers` processes of this machine, one thread of linear algebra each."""

    workers: int

    def check(self) -> None:
        """Nothing can be missing."""

    def results(self, work: Work, tasks: Sequence[Task]) -> Results:
        left, losses = list(tasks), 0
        while left:
            try:
                with closing(self._once(work, left)) as results:
                    for task, columns in results:
                        left.remove(task)
                        yield task, columns
            except BrokenProcessPool as error:
                losses += 1
                if losses > RETRIES:
                    raise WorkersLost(
                        f"worker processes died {losses} times (out of memory?); finished shards are kept, resume with"
                        " fewer workers"
                    ) from error

    def _once(self, work: Work, tasks: Sequence[Task]) -> Results:
        others = set(multiprocessing.active_children())
        with _single_threaded_children(), held() as hand_over_ctrl_c:
            pool = ProcessPoolExecutor(
                min(self.workers, len(tasks)),
                multiprocessing.get_context("spawn"),
                initializer=follow,
                initargs=(os.getpid(),),
            )
            try:
                futures: dict[Future[Columns], Task] = {}
                waiting = iter(tasks)
                for task in waiting:
                    futures[_submit(pool, work, task)] = task
                    if len(futures) == 2 * self.workers:
                        break
                while futures:
                    done, _pending = wait(futures, SIGNALS_LOOKED_AT_S, FIRST_COMPLETED)
                    hand_over_ctrl_c()
                    for future in done:
                        yield futures.pop(future), future.result()
                        for task in waiting:
                            futures[_submit(pool, work, task)] = task
                            break
            finally:
                _dismiss(pool, set(multiprocessing.active_children()) - others)


def _submit(pool: ProcessPoolExecutor, work: Work, task: Task) -> Future[Columns]:
    """Submit a task. The worker that may be started for it never hears of Ctrl-C, also before it can ignore it."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        return pool.submit(do, work, task.payload)
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _dismiss(pool: ProcessPoolExecutor, workers: set[BaseProcess]) -> None:
    """End a pool, its thread and its workers, whatever these are doing."""

    def kill() -> None:
        for worker in workers:
            worker.kill()

    for worker in workers:
        worker.terminate()
    last = threading.Timer(DISMISSAL_S, kill)
    last.start()
    pool.shutdown(cancel_futures=True)
    last.cancel()
    last.join()


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

    def _client(self, dask: Any, to: Any) -> Any:
        try:
            return dask.Client(to, timeout=self.timeout_s)
        except (OSError, TimeoutError, ValueError) as error:
            raise StoreError(
                f"--dask = {self.address}: no scheduler answers within {self.timeout_s:g} s ({type(error).__name__})"
            ) from error

    def results(self, work: Work, tasks: Sequence[Task]) -> Results:
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


@contextmanager
def _single_threaded_children() -> Iterator[None]:
    """Processes started here use one thread each for linear algebra: there is one for every core."""
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
