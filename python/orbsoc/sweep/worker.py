"""Worker processes. Each has a pipe of its own to its parent, so that its end is seen as one (decision 0017)."""

from __future__ import annotations

import multiprocessing
import os
import pickle
import signal
import threading
import time
import traceback
from collections.abc import Callable, Sequence
from contextlib import suppress
from multiprocessing.connection import Connection, wait
from typing import Any

from .store import Columns, Task

Work = Callable[[dict[str, Any]], Columns]
"""A function of a task's payload at the top of a module, so that other processes can find it."""

PARENT_CHECK_S = 1.0
"""Interval at which a worker checks that its parent lives."""


class WorkerLost(RuntimeError):
    """A worker process ended before its task."""


class Worker:
    """The parent's side of a worker process, which does one task at a time.

    There are no threads and locks here that an exception at any moment, such as Ctrl-C's, could leave taken, and no
    queue that is shared: a worker may be killed at any moment, too.
    """

    def __init__(self) -> None:
        self.task: Task | None = None
        """What it is doing."""
        self.pipe, theirs = multiprocessing.Pipe()
        self._process = multiprocessing.get_context("spawn").Process(
            target=_serve, args=(theirs, os.getpid()), daemon=True
        )
        # Ctrl-C reaches every process of a terminal, and is the parent's to answer from a worker's first moment on.
        before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        try:
            self._process.start()
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)
            theirs.close()

    def give(self, work: Work, task: Task) -> None:
        """Let it do a task."""
        self.task = task
        message = pickle.dumps((work, task.payload))
        with suppress(OSError):  # it has died, as will be seen when its result is taken
            self.pipe.send_bytes(message)

    def take(self) -> Columns:
        """The result of its task. Raises WorkerLost, and what the task raised."""
        try:
            message = self.pipe.recv_bytes()
        except (EOFError, OSError) as error:
            raise WorkerLost from error
        self.task = None
        columns: Columns
        columns, raised = pickle.loads(message)
        if raised is not None:
            raise raised
        return columns

    def end(self) -> None:
        """End it, whatever it is doing."""
        self._process.kill()
        self._process.join()
        self.pipe.close()


def answering(workers: Sequence[Worker]) -> list[tuple[Worker, Task]]:
    """Wait for a task that is done, or whose worker is lost; all that are by then."""
    ready = wait([worker.pipe for worker in workers if worker.task is not None])
    return [(worker, worker.task) for worker in workers if worker.task is not None and worker.pipe in ready]


def _serve(pipe: Connection, parent: int) -> None:
    """The worker's side: do what comes until nothing comes any more, or the parent is killed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})

    def follow() -> None:
        while os.getppid() == parent:
            time.sleep(PARENT_CHECK_S)
        os._exit(1)

    threading.Thread(target=follow, daemon=True).start()
    with suppress(EOFError, OSError):
        while True:
            pipe.send_bytes(_answer(pipe.recv_bytes()))


def _answer(message: bytes) -> bytes:
    """Do a task; what it raised instead of a result says where."""
    try:
        work, payload = pickle.loads(message)
        return pickle.dumps((work(payload), None))
    except Exception as error:
        error.add_note(f"In a worker process:\n{traceback.format_exc()}")
        try:
            answer = pickle.dumps((None, error))
            pickle.loads(answer)
        except Exception:
            return pickle.dumps((None, RuntimeError("".join(traceback.format_exception(error)))))
        return answer
