"""`PsScheduler`: the solver as the emulated computer runs it, with the call shape of `orbsoc.solve`."""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from types import FrameType
from typing import Any

from orbsoc import _core
from orbsoc.conic.problem import Problem
from orbsoc.conic.settings import Settings
from orbsoc.conic.solution import Solution, Start, Status
from orbsoc.solving.iteration_table import print_table
from orbsoc.solving.solver import engine, resolve, solution_of, start_values

from .driver import Driver
from .events import PsRecord
from .pl import ProgrammableLogic
from .program import BusyClocks, ControlProgram
from .segments import Method
from .trace import Latencies, TraceRecorder


class PsScheduler:
    """Python plays the PS: a callable that solves stage by stage through the register file of an emulated PL.

    The answer has the bits of `orbsoc.solve`. `settings` and `overrides` (fields of `Settings`) are the default of
    every call; a call's own come before them. `latencies` (preset → operation → cycles) are those of the trace's
    critical paths; `orbsoc.PsScheduler` takes the hardware model's. `every_ordering`: the `ordering` of every solve,
    whatever a call's settings say, as of a mission's that chooses its own. With a `program`, the PL has all modules and runs
    whole attempts by itself; the PS starts them, and restarts, and sees nothing of the iterations between. `limit_clocks`: the PL
    stops a launch that is busy for more clocks, which a solve ends on with `CycleLimit`; what it takes `busy_clocks` says.
    """

    def __init__(
        self,
        settings: Settings | None = None,
        *,
        latencies: Latencies,
        every_ordering: str | None = None,
        program: ControlProgram | None = None,
        busy_clocks: Callable[[Problem, Settings], BusyClocks] | None = None,
        limit_clocks: int | None = None,
        **overrides: Any,
    ) -> None:
        self._settings = resolve(settings, overrides)
        self._ordering = every_ordering
        self._recorder = TraceRecorder(_core, latencies)
        self._program = program
        self._busy_clocks, self._limit_clocks = busy_clocks, limit_clocks
        self._method = Method.from_core(_core, resident=program is not None)
        self.record = PsRecord()
        """What the PS did in the last solve."""

    @property
    def trace(self) -> dict[str, Any]:
        """All solves since this scheduler was made, as hw_model reads them ("orbsoc.trace/2")."""
        return self._recorder.as_dict()

    @property
    def patterns(self) -> tuple[Problem, ...]:
        """One problem of each sparsity pattern of the trace, in the order of `trace["patterns"]`."""
        return tuple(self._recorder.problems)

    @property
    def pattern_settings(self) -> tuple[Settings, ...]:
        """The settings that each of `patterns` was first solved with."""
        return tuple(self._recorder.settings)

    def _chosen(self, settings: Settings) -> Settings:
        """What a solve with these settings runs with."""
        return settings if self._ordering is None else replace(settings, ordering=self._ordering)

    def __call__(
        self,
        problem: Problem,
        settings: Settings | None = None,
        /,
        *,
        warm_start: Solution | Start | None = None,
        **overrides: Any,
    ) -> Solution:
        """Solve on a fresh engine and a fresh PL, and add the solve to the trace; `warm_start` as in `orbsoc.solve`.

        Not converging is a status, and Ctrl-C ends the solve with `Status.INTERRUPTED`, as with `orbsoc.solve`; where another
        status stands, as the solve ended at that moment or on a proof, it goes up as KeyboardInterrupt, as it does there.
        Raises `ProtocolError` if PS and PL disagree, and what `orbsoc.solve` raises for wrong data or settings.
        """
        chosen = self._chosen(resolve(settings or self._settings, overrides))
        native = engine(problem, chosen)
        self.record = PsRecord()
        clocks = None if self._busy_clocks is None else self._busy_clocks(problem, chosen)
        pl = ProgrammableLogic(self._method, native.run, program=self._program, clocks=clocks)
        values = None if warm_start is None else start_values(problem, warm_start)
        observe = _table(native) if chosen.verbose and self._program is None else None
        started = time.perf_counter()
        with _ctrl_c_stops(native) as stopped:
            driver = Driver(
                self._method, native, pl,
                words=native.buffer_words(), record=self.record, program=self._program, stopped=stopped.is_set,
                limit_clocks=self._limit_clocks,
            )  # fmt: skip
            warm = values is not None and native.start_from(values)
            driver.run(restart=native.begin_again, warm=warm, observe=observe)
        solution = solution_of(native.finish(time.perf_counter() - started))
        self._recorder.add(problem, chosen, native, solution, pl.ran if self._program else None)
        if stopped.is_set() and solution.status is not Status.INTERRUPTED:
            raise KeyboardInterrupt
        return solution


def _table(native: _core.Engine) -> Callable[[], None]:
    """Prints an iteration's line of the progress table each time it is called."""
    watch = print_table()

    def observe() -> None:
        watch(native.progress())

    return observe


@contextmanager
def _ctrl_c_stops(native: _core.Engine) -> Iterator[threading.Event]:
    """Let Ctrl-C end the solve at its next statistics, and say that it came; a handler of the user's own is called first.

    An exception between two register accesses would leave the PL in mid-launch, so none is let through here.
    """
    stopped = threading.Event()
    previous = signal.getsignal(signal.SIGINT)
    if threading.current_thread() is not threading.main_thread() or not callable(previous):
        yield stopped
        return

    def stop(signum: int, frame: FrameType | None) -> None:
        try:
            previous(signum, frame)
        except KeyboardInterrupt:
            stopped.set()
            native.interrupt()

    signal.signal(signal.SIGINT, stop)
    try:
        yield stopped
    finally:
        signal.signal(signal.SIGINT, previous)
