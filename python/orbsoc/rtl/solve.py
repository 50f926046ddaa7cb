"""A whole interior-point solve on the RTL: the PL in Verilator, Python as the PS, Rust as the reference.

The PS is the one of `PsScheduler`: the same driver runs the same lists, launches every segment through the RTL's
registers, takes its interrupt, and moves the buffers that cross, word by word, between its memory and the RTL's
storage. Its own stages, statistics and decisions among them, are those of the Rust engine, on what was moved. A
second engine runs every stage in Rust, from the problem on; whatever crosses to the PS, and every iterate, must have its bits.
There the RTL decides nothing on the way, so a solve starts cold: a warm start's verdict would be a segment's.

Under resident control the RTL has all seven modules, and runs whole attempts. The PS sees registers, and the buffers that it
fetches at the end. The harness logs which segments ran: the second engine runs their stages, and every word of the RTL's
storage that belongs to a buffer must then be its.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from orbsoc import _core
from orbsoc.conic.problem import Problem
from orbsoc.conic.settings import Settings
from orbsoc.conic.solution import Solution, Start
from orbsoc.hw.emulation import operation_latencies, resident_program
from orbsoc.hw.schedules import Engine, pl_program, with_exact_depth
from orbsoc.ps.driver import Driver
from orbsoc.ps.events import Kind, PsRecord
from orbsoc.ps.segments import Method
from orbsoc.ps.trace import TraceRecorder
from orbsoc.solving.solver import solution_of, start_values

from .bits import same_solution, unequal
from .clocks import predicted_clocks
from .session import RtlPort, RtlSession
from .validation import Format, built

ITERATE = ("point", "slack", "homogenizer")
"""Buffers of the iterate: (x, y, z), s, and τ and κ."""
_SHOWN = 10


@dataclass(frozen=True, slots=True)
class Difference:
    """A word that the RTL made otherwise than Rust; both as hexadecimal bits. `stage` is the last that had run."""

    iteration: int
    stage: str
    buffer: str
    index: int
    rtl: str
    rust: str


@dataclass(frozen=True, slots=True)
class Launch:
    """One run of a segment: busy cycles by the engine's own counter, and by its schedule."""

    stage: str
    rtl_cycles: int
    model_cycles: int


@dataclass(frozen=True, slots=True, eq=False)
class SolveOutcome:
    """What a solve on the RTL came to, beside the same solve in Rust and beside the model."""

    problem: str
    engine: Engine
    format: Format
    resident: bool
    status: str
    iterations: int
    launches: tuple[Launch, ...]
    iterates: int
    """Iterates compared, the first and the last among them."""
    words: int
    """Words compared: all that crossed to the PS, and all of the iterates."""
    different_words: int
    differences: tuple[Difference, ...]
    """The first few."""
    same_stages: bool
    """The loop in Rust, asked for the whole solve, ran the same stages in the same order."""
    same_solution: bool
    """… and ended with the same status and the same bits of x, y, z and s."""
    assertions: int
    rtl_clocks: int
    """Of the whole solve, from the announcement of the problem to the last word moved."""
    model_clocks: dict[str, int]
    """The same by the hardware model, by cause."""

    @property
    def busy_error_cycles(self) -> int:
        """Σ |RTL − schedule| over the launches."""
        return sum(abs(launch.rtl_cycles - launch.model_cycles) for launch in self.launches)

    @property
    def clock_error(self) -> float:
        """Model / RTL − 1, of the clocks of the whole solve."""
        return sum(self.model_clocks.values()) / self.rtl_clocks - 1.0

    @property
    def good(self) -> bool:
        """Same bits, same stages, same end, equal cycles in every launch, clocks within 1 %, no rule violated."""
        same = not self.different_words and self.same_stages and self.same_solution
        return same and not self.busy_error_cycles and abs(self.clock_error) <= 0.01 and not self.assertions


@dataclass(slots=True, eq=False)
class _Sides:
    """The PS with its memory, the RTL's storage, and the reference in Rust: where words move and are compared.

    It is the driver's engine (`run`) and its mover (`carry`).
    """

    ps: _core.ExactEngine
    rust: _core.ExactEngine
    session: RtlSession
    homes: Mapping[str, tuple[NDArray[np.uint32], NDArray[np.uint32]]]
    """Of each buffer the words that have a place in the RTL's storage, and their addresses."""
    record: PsRecord
    fp: int
    method: Method
    streams: Sequence[tuple[str, ...]] = ()
    """Under resident control, the stages of every segment by its number."""
    launched: list[tuple[int, int]] = field(default_factory=list[tuple[int, int]])
    """… and those that ran, with their busy cycles."""
    warm: bool = False
    """Whether the attempt starts from a point that the PS gave."""
    iterates: int = 0
    compared_clocks: int = 0
    """Clocks in which the storage was read for comparison only."""
    words: int = 0
    different_words: int = 0
    differences: list[Difference] = field(default_factory=list[Difference])
    _seen: int = 0
    _last: str = ""

    def run(self, stage: str) -> int:
        """Run a stage on the PS; before statistics, compare the iterate."""
        self._catch_up()
        if stage == "statistics":
            self._compare_iterate()
        return self.ps.run(stage)

    def carry(self, kind: Kind, buffer: str) -> None:
        """Move the words of a buffer that have a place in the RTL's storage."""
        self._catch_up()
        if buffer not in self.homes:
            return
        indices, addresses = self.homes[buffer]
        if kind is Kind.TO_PL:
            self.session.set_words(addresses, self.ps.words(buffer, indices))
        else:
            words = self.session.get_words(addresses)
            self.ps.set_words(buffer, indices, words)
            self._compare(buffer, indices, words, self.rust.words(buffer, indices))

    def begin_again(self) -> bool:
        """Finish the attempt in Rust, compare its last iterate, and say whether a restart follows."""
        self._catch_up()
        if self.streams:
            self._compare_storage()
            self.ps.take_over()
        else:
            self._compare_iterate()
        return self.rust.begin_again() and self.ps.begin_again()

    def _catch_up(self) -> None:
        """Run in Rust the stages that the PS has run or launched since."""
        events = self.record.after(self._seen)
        self._seen += len(events)
        for event in events:
            if event.kind is Kind.INTERRUPT and self.streams:
                ran = self.session.segments()
                self.launched += ran
                for stage in (stage for number, _ in ran for stage in self.streams[number]):
                    self.rust.run(stage)
                    self._last = stage
            elif event.kind in (Kind.LAUNCH, Kind.RUN) and not self.streams:
                self.rust.run(event.name)
                self._last = event.name

    def _compare_storage(self) -> None:
        """Every word of the RTL's storage that belongs to a buffer which the attempt may have written."""
        self.iterates += 1
        before = self.session.clocks()
        _, written = self.method.attempt(warm=self.warm)
        self.warm = False  # what follows is a cold restart
        for buffer in self.method.names(written):
            if buffer in self.homes and not self._unfinished(buffer):
                indices, addresses = self.homes[buffer]
                found = self.session.get_words(addresses)
                self._compare(buffer, indices, found, self.rust.words(buffer, indices))
        self.compared_clocks += self.session.clocks() - before

    def _unfinished(self, buffer: str) -> bool:
        """Whether no stage that ran has written the buffer."""
        ran = {stage for number, _ in self.launched for stage in self.streams[number]}
        segments = {segment.stage: segment for segment in self.method.segments}
        return not any(segments[stage].writes & self.method.mask([buffer]) for stage in ran)

    def _compare_iterate(self) -> None:
        self.iterates += 1
        for buffer in ITERATE:
            found, wanted = self.ps.words(buffer), self.rust.words(buffer)
            self._compare(buffer, np.arange(len(wanted), dtype=np.uint32), found, wanted)

    def _compare(
        self, buffer: str, indices: NDArray[np.uint32], found: NDArray[np.uint64], wanted: NDArray[np.uint64]
    ) -> None:
        differs = unequal(found, wanted, self.fp)
        self.words += len(found)
        self.different_words += int(differs.sum())
        iteration = self.rust.events()[-1][1] if self._last else 0
        for k in np.flatnonzero(differs)[: _SHOWN - len(self.differences)].tolist():
            bits = (f"{int(side[k]):0{self.fp // 4}x}" for side in (found, wanted))
            self.differences.append(Difference(iteration, self._last, buffer, int(indices[k]), *bits))


def solve_on_rtl(
    rtl: Path,
    name: str,
    problem: Problem,
    settings: Settings | None = None,
    *,
    engine: Engine | None = None,
    form: Format = "flat",
    resident: bool = False,
    start: Solution | Start | None = None,
    exact_depth: bool = False,
) -> SolveOutcome:
    """Solve `problem` on the RTL and compare; `rtl` is its folder, `engine` must leave no field open that matters;
    `resident`: under the RTL's own control, and only then from `start`; `exact_depth`: with no more rows in the engine's banks than
    the schedules need.

    Raises RtlError if the RTL does not build or its session breaks off, `ProtocolError` if PS and RTL disagree about
    the state of the computer, `hw.schedules.EngineError` for an engine that cannot hold the problem.
    """
    settings = settings or Settings()
    control = resident_program() if resident else None
    streams_on_pl = control.streams if control else ()
    program = pl_program(problem, settings, engine, None, streams_on_pl)
    if exact_depth:
        program = pl_program(problem, settings, with_exact_depth(program), None, streams_on_pl)
    image = _core.program_image(program.core, form)
    method = Method.from_core(_core, resident=resident)
    numbered = method.numbered(control).items() if control else ()
    streams = [stages for stages, _ in sorted(numbered, key=lambda item: item[1].number)]
    loop = _core.ExactEngine(problem, settings, program.engine.fp)
    point = None if start is None else start_values(problem, start)
    whole = loop.solve(point)
    ps, rust = (_core.ExactEngine(problem, settings, program.engine.fp) for _ in range(2))
    warm = point is not None and ps.start_from(point) and rust.start_from(point)
    record = PsRecord()
    with RtlSession(
        built(rtl, program.engine, form, lines=len(image.microcode), resident=resident)
    ) as session:
        session.reset()
        session.load(image, method, control)
        before = session.clocks()
        port = RtlPort(session)
        sides = _Sides(ps, rust, session, image.homes, record, program.engine.fp, method, streams, warm=warm)
        driver = Driver(
            method, sides, port, words=ps.buffer_words(), record=record, carry=sides.carry, program=control
        )
        driver.run(restart=sides.begin_again, warm=warm)
        clocks, assertions = session.clocks() - before - sides.compared_clocks, sum(session.violations())
    found = ps.finish()
    trace = TraceRecorder(_core, operation_latencies())
    trace.add(problem, settings, rust, solution_of(found))
    cycles = {name: cycles for name, (_, cycles) in image.entries.items()}
    names = ["_".join(stages) for stages in streams] or [segment.stage for segment in method.segments]
    return SolveOutcome(
        problem=name,
        engine=program.engine,
        format=form,
        resident=resident,
        status=found.status,
        iterations=found.iterations,
        launches=tuple(
            Launch(names[s], busy, cycles[names[s]])
            for s, busy in (sides.launched if resident else port.busy)
        ),
        iterates=sides.iterates,
        words=sides.words,
        different_words=sides.different_words,
        differences=tuple(sides.differences),
        same_stages=rust.events() == loop.events(),
        same_solution=same_solution(found, whole),
        assertions=assertions,
        rtl_clocks=clocks,
        model_clocks=predicted_clocks(
            trace.as_dict(), cycles, rtl, program.engine, "resident" if resident else "paper"
        ),
    )


def described(outcome: SolveOutcome) -> Sequence[str]:
    """The faults of an outcome as sentences; none if it is good."""
    return [
        text
        for wrong, text in (
            (
                outcome.different_words,
                f"{outcome.different_words} words differ; first: {outcome.differences[:1]}",
            ),
            (not outcome.same_stages, "the loop in Rust ran other stages"),
            (not outcome.same_solution, "the loop in Rust ended elsewhere"),
            (outcome.busy_error_cycles, f"segments are off by {outcome.busy_error_cycles} cycles in all"),
            (
                abs(outcome.clock_error) > 0.01,
                f"the model's clocks are off by {100 * outcome.clock_error:.2f} %",
            ),
            (outcome.assertions, f"{outcome.assertions} violations of the rules of a schedule"),
        )
        if wrong
    ]
