"""Ctrl-C, remembered: a signal that something swallowed still ends the run, and none can tear the last step."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType, TracebackType
from typing import Self


@contextmanager
def held() -> Iterator[None]:
    """While entered, SIGINT is only remembered; on leaving, the handler of before hears of it.

    For a step that an exception in its middle would leave half done. Outside the main thread, or where SIGINT is
    ignored, nothing is held. Left in the reverse order of entering, and never over a `yield` of a generator.
    """
    before = signal.getsignal(signal.SIGINT)
    if threading.current_thread() is not threading.main_thread() or not callable(before):
        yield
        return
    came = False

    def remember(_signum: int, _frame: FrameType | None) -> None:
        nonlocal came
        came = True

    signal.signal(signal.SIGINT, remember)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
        if came:
            before(signal.SIGINT, None)


class Interrupts:
    """While entered, SIGINT raises KeyboardInterrupt as ever, and is remembered.

    A solver answers Ctrl-C with a status, or has already solved when it looks; a callback in foreign code may lose
    the exception. `check` raises it again. After `commit` a signal changes nothing: the run is about to put its
    output in place, and says so. Outside the main thread, or where SIGINT is ignored, nothing is installed.
    """

    def __init__(self) -> None:
        self.received = False
        """Whether a signal came since entering."""
        self._committed = False
        self._previous: object = None

    def check(self) -> None:
        """Raise KeyboardInterrupt if a signal came since entering."""
        if self.received:
            raise KeyboardInterrupt

    def commit(self) -> None:
        """The last moment to be interrupted; from here on signals are ignored."""
        self.check()
        self._committed = True

    def __enter__(self) -> Self:
        previous = signal.getsignal(signal.SIGINT)
        if threading.current_thread() is threading.main_thread() and callable(previous):
            self._previous = previous
            signal.signal(signal.SIGINT, self._receive)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if callable(self._previous):
            signal.signal(signal.SIGINT, self._previous)
            self._previous = None

    def _receive(self, _signum: int, _frame: FrameType | None) -> None:
        if self._committed:
            return
        self.received = True
        raise KeyboardInterrupt
