"""A whole attempt at several problems of one pattern, interleaved in one stream, on the RTL under its own control.

The PS loads the buffers of all, starts the attempt, and fetches what each problem has left when the last has ended. An engine in
Rust solves each problem by itself: its outcome and its solution must have the same bits. The segments that ran must be those that
the hardware model counts for a group (`hw_model.timing.groups`), each in the cycles of its schedule. There is one attempt: a
problem that would restart is refused.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hw_model import load_partition
from hw_model.timing.actions import actions_of
from hw_model.timing.control_program import control_cycles, members
from hw_model.timing.groups import grouped
from hw_model.timing.trace import Trace, parse_trace
from orbsoc import _core
from orbsoc.conic.problem import Problem
from orbsoc.conic.settings import Settings
from orbsoc.hw.emulation import operation_latencies, resident_program
from orbsoc.hw.schedules import Engine, pl_program
from orbsoc.ps.driver import Driver
from orbsoc.ps.events import Kind, PsRecord
from orbsoc.ps.registers import Control, Register
from orbsoc.ps.segments import Method
from orbsoc.ps.trace import TraceRecorder
from orbsoc.solving.solver import solution_of

from .bits import same_solution, unequal
from .session import RtlPort, RtlSession
from .solve import Launch
from .validation import Format, built

OUTCOME = ("control", "best", "farkas", "ray", "answer", "witness")
"""Buffers that hold what a problem that has ended leaves: later segments of the others must not change them."""


@dataclass(frozen=True, slots=True, eq=False)
class GroupOutcome:
    """What an attempt at a group on the RTL came to."""

    name: str
    engine: Engine
    format: Format
    statuses: tuple[str, ...]
    """Of each problem, as the PS reads it."""
    iterations: tuple[int, ...]
    launches: tuple[Launch, ...]
    words: int
    """Of the outcomes, compared."""
    different_words: int
    same_solutions: bool
    """Status, iterations, x, y, z and s of each problem, as the PS reads them."""
    uncounted: Mapping[str, int]
    """Segments that ran more often than the hardware model counts, or less often, and by how much."""
    assertions: int
    rtl_clocks: int
    """From the launch of the attempt to its interrupt."""
    model_clocks: int
    """Of the segments that the hardware model counts, by their schedules, and of the operation control."""

    @property
    def busy_error_cycles(self) -> int:
        """Σ |RTL − schedule| over the segments."""
        return sum(abs(launch.rtl_cycles - launch.model_cycles) for launch in self.launches)

    @property
    def good(self) -> bool:
        """Same bits, the segments of the model in the cycles of their schedules, no rule violated."""
        same = self.same_solutions and not self.different_words
        return same and not self.uncounted and not self.busy_error_cycles and not self.assertions


def group_on_rtl(
    rtl: Path,
    name: str,
    problems: Sequence[Problem],
    settings: Settings | None = None,
    *,
    engine: Engine | None = None,
    form: Format = "flat",
) -> GroupOutcome:
    """Solve problems of one pattern together on the RTL, and compare; `rtl` is its folder.

    Raises ValueError for a problem that restarts, and what `rtl.solve.solve_on_rtl` raises.
    """
    settings, control, copies = settings or Settings(), resident_program(), len(problems)
    program = pl_program(problems[0], settings, engine, None, control.streams, copies)
    image = _core.program_image(program.core, form)
    method = Method.from_core(_core, resident=True)
    fp = program.engine.fp
    own = [_core.ExactEngine(problem, settings, fp) for problem in problems]
    solved = [each.solve() for each in own]
    again = [number for number, found in enumerate(solved) if found.attempts > 1]
    if again:
        raise ValueError(f"problem {again[0]} of the group restarts: a group makes one attempt")
    with RtlSession(built(rtl, program.engine, form, lines=len(image.microcode), resident=True)) as session:
        session.reset()
        session.load(image, method, control, copies)
        ps = [_core.ExactEngine(problem, settings, fp) for problem in problems]
        group, port = _Group(ps, session, image.homes), _TimedPort(session)
        Driver(
            method,
            ps[0],
            port,
            words=ps[0].buffer_words(),
            record=PsRecord(),
            carry=group.carry,
            program=control,
        ).run()
        ran, assertions = session.segments(), sum(session.violations())
        compared = [
            unequal(group.fetched(buffer, number), each.words(buffer, group.entries(buffer, number)), fp)
            for buffer in OUTCOME
            for number, each in enumerate(own)
        ]
    for each in ps:
        each.take_over()
    found = [each.finish() for each in ps]
    cycles = {segment: busy for segment, (_, busy) in image.entries.items()}
    numbered = sorted(method.numbered(control).items(), key=lambda item: item[1].number)
    names = ["_".join(stages) for stages, _ in numbered]
    counted, clocks = _model(_trace(problems, settings, own, solved, fp), copies, cycles)
    counted.subtract(names[number] for number, _ in ran)
    return GroupOutcome(
        name=name,
        engine=program.engine,
        format=form,
        statuses=tuple(each.status for each in found),
        iterations=tuple(each.iterations for each in found),
        launches=tuple(Launch(names[number], busy, cycles[names[number]]) for number, busy in ran),
        words=sum(map(len, compared)),
        different_words=int(sum(each.sum() for each in compared)),
        same_solutions=all(map(same_solution, found, solved)),
        uncounted={segment: -times for segment, times in counted.items() if times},
        assertions=assertions,
        rtl_clocks=port.clocks,
        model_clocks=clocks,
    )


@dataclass(frozen=True, slots=True, eq=False)
class _Group:
    """The PS's memory, an engine for each problem, and the RTL's storage."""

    ps: Sequence[_core.ExactEngine]
    session: RtlSession
    homes: Mapping[str, tuple[NDArray[np.uint32], NDArray[np.uint32]]]

    def carry(self, kind: Kind, buffer: str) -> None:
        """Move the words of a buffer of every problem that have a place in the RTL's storage."""
        if buffer not in self.homes:
            return
        for number, engine in enumerate(self.ps):
            entries = self.entries(buffer, number)
            if kind is Kind.TO_PL:
                self.session.set_words(self._addresses(buffer, number), engine.words(buffer, entries))
            else:
                engine.set_words(buffer, entries, self.fetched(buffer, number))

    def entries(self, buffer: str, number: int) -> NDArray[np.uint32]:
        """Of a problem's buffer those that have a place in the storage."""
        return self.homes[buffer][0][self._own(buffer, number)] // np.uint32(len(self.ps))

    def fetched(self, buffer: str, number: int) -> NDArray[np.uint64]:
        """Their words there."""
        return self.session.get_words(self._addresses(buffer, number))

    def _addresses(self, buffer: str, number: int) -> NDArray[np.uint32]:
        return self.homes[buffer][1][self._own(buffer, number)]

    def _own(self, buffer: str, number: int) -> NDArray[np.bool_]:
        """Words of the problem among those of all: entry i of problem c is word i · copies + c; a flag of all comes last."""
        indices, words = self.homes[buffer][0], self.ps[0].buffer_words()[buffer]
        own: NDArray[np.bool_] = (indices % len(self.ps) == number) & (indices < len(self.ps) * words)
        return own


class _TimedPort(RtlPort):
    """The register file; `clocks` are those from the launch of an attempt to its interrupt."""

    clocks = 0

    def write(self, address: int, value: int) -> None:
        super().write(address, value)
        if (address, value) == (Register.CONTROL, Control.ATTEMPT):
            self.clocks = -self.session.clocks()

    def tick(self) -> None:
        super().tick()
        if self.clocks < 0 and self.interrupt:
            self.clocks += self.session.clocks()


def _trace(
    problems: Sequence[Problem],
    settings: Settings,
    own: Sequence[_core.ExactEngine],
    solved: Sequence[_core.RawSolution],
    fp: int,
) -> Trace:
    """Of the solves of each problem by itself."""
    recorder = TraceRecorder(_core, operation_latencies())
    for problem, engine, solution in zip(problems, own, solved, strict=True):
        recorder.add(problem, settings, engine, solution_of(solution))
    return parse_trace(recorder.as_dict() | {"datapath": "f64" if fp == 64 else "f32"})


def _model(trace: Trace, copies: int, cycles: Mapping[str, int]) -> tuple[Counter[str], int]:
    """How often each segment of a group runs, and the clocks of all and of the control between them."""
    assert trace.method is not None  # it is of a recorder
    segments: Counter[str] = Counter()
    clocks = 0
    for work in grouped(actions_of(trace, load_partition("resident")), trace, copies):
        if work.kind == "compute" and work.side == "pl":
            segment = "_".join(members(work.what))
            segments[segment] += 1
            clocks += cycles[segment]
        elif work.kind == "control":
            clocks += control_cycles(members(work.what), trace.method)
    return segments, clocks
