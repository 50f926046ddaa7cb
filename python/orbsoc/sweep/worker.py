"""The side of a worker process: it does tasks, gives one up when told to, and ends when its parent does."""

from __future__ import annotations

import os
import signal
import threading
import time
from collections.abc import Callable
from concurrent.futures.process import BrokenProcessPool
from types import FrameType
from typing import Any

from .store import Columns

PARENT_LOOKED_AT_S = 1.0
"""How often a worker looks whether its parent lives."""

_working = False
_dismissed = False


def follow(parent: int) -> None:
    """Once in every worker: Ctrl-C reaches every process of a terminal, and the parent decides what it means.

    The parent says so by SIGTERM, which ends the task under way and refuses the next ones: a worker that died in the
    middle of sending a result would leave the parent waiting for the rest of it. Where the parent is killed, its
    workers end, too.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, _dismiss)

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(PARENT_LOOKED_AT_S)
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


def do(work: Callable[[dict[str, Any]], Columns], payload: dict[str, Any]) -> Columns:
    """A task. Raises what `work` raises, and BrokenProcessPool after SIGTERM."""
    global _working
    _working = True
    try:
        if not _dismissed:
            return work(payload)
    except KeyboardInterrupt:
        pass
    finally:
        _working = False
    raise BrokenProcessPool("a worker was told to end")


def _dismiss(_signum: int, _frame: FrameType | None) -> None:
    global _dismissed
    _dismissed = True
    if _working:
        raise KeyboardInterrupt
