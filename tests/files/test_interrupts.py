"""Ctrl-C held: a step is not torn, and the signal is not lost."""

from __future__ import annotations

import signal
import threading

import pytest

from orbsoc.files.interrupts import Interrupts, held


def test_a_held_signal_is_handed_over_at_the_end_also_after_an_error() -> None:
    went_on: list[Exception | None] = []

    def work(error: Exception | None) -> None:
        with held():
            signal.raise_signal(signal.SIGINT)
            went_on.append(error)
            if error is not None:
                raise error

    with pytest.raises(KeyboardInterrupt):
        work(None)
    own = ValueError("of its own")
    with pytest.raises(KeyboardInterrupt) as caught:
        work(own)
    assert caught.value.__context__ is own
    assert went_on == [None, own]
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_a_held_signal_is_heard_once_by_who_listened_before() -> None:
    heard: list[bool] = []

    def work(interrupts: Interrupts) -> None:
        with held():
            signal.raise_signal(signal.SIGINT)
            heard.append(interrupts.received)

    with Interrupts() as interrupts:
        with pytest.raises(KeyboardInterrupt):
            work(interrupts)
        assert interrupts.received
    assert heard == [False]
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_nothing_is_held_where_the_signal_is_ignored_or_in_another_thread() -> None:
    heard: list[object] = []

    def look() -> None:
        with held():
            heard.append(signal.getsignal(signal.SIGINT))

    thread = threading.Thread(target=look)
    thread.start()
    thread.join()
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        look()
    finally:
        signal.signal(signal.SIGINT, before)
    assert heard == [signal.default_int_handler, signal.SIG_IGN]
