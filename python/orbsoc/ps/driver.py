"""The PS: runs the step lists of the method, and launches each stage through the register file.

A solve attempt is the loop of the Rust engine, over the same lists. The PS compares words, branches, moves
data and answers interrupts; it computes nothing, and it never asks the engine for a whole solve.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from typing import Protocol

from .events import Kind, PsRecord
from .program import ControlProgram
from .registers import (
    ERROR_OF_FAULT,
    WORD_BITS,
    WORD_MASK,
    Control,
    Fault,
    LaunchTimeout,
    LostInterrupt,
    LostWrite,
    Module,
    ReadBeforeValid,
    Register,
    RegisterFile,
    Status,
    UnacknowledgedInterrupt,
    Wrapper,
    WrongSegment,
)
from .segments import OUTCOME, Method, Segment, Step

ATTEMPT = "attempt"
"""Name of what the PL runs by itself."""

ATTEMPT_SEGMENTS = 10_000
"""Segments that an attempt may run before its launch counts as lost."""

POLL_BUDGET = 1000
"""Polls of the interrupt line before a launch counts as lost. Polls, not seconds: the emulation has no clock."""


class StageRunner(Protocol):
    """What the PS asks of an engine."""

    def run(self, stage: str) -> int:
        """Run one stage; NEXT, REPEAT or DONE."""
        ...


Carry = Callable[[Kind, str], None]
"""Moves one buffer, `Kind.TO_PL` or `Kind.TO_PS`, between two memories that really are two."""


class Driver:
    """One solve on the PS.

    `port` is the PL's register file, in reset; `words` gives the size of each buffer in words. `carry` moves a buffer
    where the PL has a storage of its own; without it both sides work on the engine's. With a `program` the PL runs
    whole attempts: the PS launches one, waits, and fetches how it has ended; when `stopped` says so, it asks the PL to
    end at its next decision. `limit_clocks`: a launch that is busy for more is stopped by the PL, `CycleLimit`. Every disagreement between the
    two sides raises a `ProtocolError` that names the stage.
    """

    def __init__(
        self,
        method: Method,
        engine: StageRunner,
        port: RegisterFile,
        *,
        words: Mapping[str, int],
        record: PsRecord,
        poll_budget: int = POLL_BUDGET,
        carry: Carry | None = None,
        program: ControlProgram | None = None,
        stopped: Callable[[], bool] = lambda: False,
        limit_clocks: int | None = None,
    ) -> None:
        self._method = method
        self._engine = engine
        self._port = port
        self._words = words
        self._record = record
        self._poll_budget = poll_budget
        self._carry = carry
        self._program = program
        self._stopped = stopped
        self._limit_clocks = limit_clocks
        self._segments = {segment.stage: segment for segment in method.segments}
        self._flag_words = -(-len(method.buffers) // WORD_BITS)
        self._last = method.segments[0]
        self._sequence = 0
        self._valid = 0
        self._written = 0
        self._held_by_ps = 0
        self._held_by_pl = 0

    def run(
        self,
        *,
        restart: Callable[[], bool] = lambda: False,
        warm: bool = False,
        observe: Callable[[], None] | None = None,
    ) -> None:
        """Load the problem and solve; restart from cold as long as `restart` asks for it, which may set parameters.

        `warm` starts from the point that the engine holds; `observe` is called after each iteration but an attempt's last.
        """
        if self._limit_clocks is not None:
            self._write(Wrapper.LIMIT, self._limit_clocks)
        self._publish(self._method.segments[0])
        self._attempt(warm, observe)
        while restart():
            self._held_by_pl &= ~self._method.rewritten
            self._attempt(warm=False, observe=observe)

    def _attempt(self, warm: bool, observe: Callable[[], None] | None) -> None:
        """Start up, iterate until a stage says DONE, close, and fetch what the last stage wrote."""
        if self._program is not None:
            self._launch_attempt(self._program, warm)
            return
        outcome = self._run_steps(self._method.warm_startup if warm else self._method.startup)
        while outcome != self._method.done:
            outcome = self._run_steps(self._method.iteration)
            if observe is not None and outcome != self._method.done:
                observe()
        self._run_steps(self._method.closing)
        self._require_rest()
        self._move(Kind.TO_PS, self._last.writes & ~self._held_by_ps)

    def _launch_attempt(self, program: ControlProgram, warm: bool) -> None:
        """Have the PL run an attempt by itself, and fetch how it has ended."""
        needed, written = self._method.attempt(warm=warm)
        closing = 0
        for step in self._method.closing:
            closing |= self._segments[step[0]].writes
        self._move(Kind.TO_PL, needed & ~self._held_by_pl)
        attempt = Segment(
            program.warm if warm else program.cold, ATTEMPT, Module.PS, reads=needed, writes=written, stales=0
        )
        self._last = attempt
        self._write_frame(attempt, Control.ATTEMPT)
        self._record.add(Kind.LAUNCH, attempt.stage, self._sequence)
        self._await_attempt(attempt)
        self._confirm(replace(attempt, number=0, writes=closing))
        self._written |= written
        self._held_by_pl |= needed | written
        self._held_by_ps &= ~written
        self._write(Register.IRQ_ACK, self._sequence)
        self._require_rest()
        outcome = (closing | self._method.mask(OUTCOME) & written) & self._valid
        self._move(Kind.TO_PS, outcome)
        self._held_by_ps |= outcome

    def _await_attempt(self, attempt: Segment) -> None:
        """Wait for the end of an attempt, which takes as long as all its segments; ask it to stop where `stopped` says so."""
        asked = False
        for _ in range(self._poll_budget * ATTEMPT_SEGMENTS):
            if self._port.interrupt:
                break
            if not asked and self._stopped():
                self._write(Register.STOP, 1)
                asked = True
            self._port.tick()
        self._await_interrupt(attempt)

    def _run_steps(self, steps: Iterable[Step]) -> int | None:
        """Run the steps in order, as the Rust loop does; stop at DONE."""
        outcome = None
        for stage, *until in steps:
            if until:
                while (outcome := self._stage(until[0])) == self._method.repeat:
                    self._stage(stage)
            else:
                outcome = self._stage(stage)
            if outcome == self._method.done:
                break
        return outcome

    def _stage(self, stage: str) -> int:
        """Run one stage where it belongs; its outcome."""
        segment = self._last = self._segments[stage]
        if segment.module is not Module.PS:
            return self._launch(segment)
        self._require(segment, segment.unreadable(self._valid, self._written))
        self._fetch(segment)
        outcome = self._engine.run(stage)
        self._record.add(Kind.RUN, stage, self._sequence + 1)
        self._publish(segment)
        return outcome

    def _launch(self, segment: Segment) -> int:
        """Start a segment on the PL, take its interrupt, check its flags, acknowledge."""
        self._deliver(segment)
        self._write_frame(segment, Control.START)
        self._record.add(Kind.LAUNCH, segment.stage, self._sequence)
        self._await_interrupt(segment)
        outcome = self._confirm(segment).outcome
        self._held_by_pl |= segment.writes
        self._held_by_ps &= ~segment.writes
        self._write(Register.IRQ_ACK, self._sequence)
        return outcome

    def _publish(self, segment: Segment) -> None:
        """Tell the PL which buffers a stage of the PS wrote and made stale."""
        self._held_by_ps |= segment.writes
        self._held_by_pl &= ~segment.writes
        self._write_frame(segment, Control.PUBLISH)
        self._confirm(segment)

    def _write_frame(self, segment: Segment, command: Control) -> None:
        self._sequence = (self._sequence + 1) & WORD_MASK
        self._write(Register.MODULE, segment.module)
        self._write(Register.SEGMENT, segment.number)
        self._write(Register.SEQUENCE, self._sequence)
        self._write(Register.CONTROL, command)

    def _await_interrupt(self, segment: Segment) -> None:
        for polls in range(self._poll_budget):
            if self._port.interrupt:
                self._record.add(Kind.INTERRUPT, segment.stage, polls)
                return
            self._port.tick()
        status = self._read_status(segment)
        where = f"stage {segment.stage!r}, launch {self._sequence}"
        if status.done:
            raise LostInterrupt(f"{where}: finished, but no interrupt within {self._poll_budget} polls")
        state = "still busy" if status.busy else "never started"
        raise LaunchTimeout(f"{where}: {state} after {self._poll_budget} polls")

    def _confirm(self, segment: Segment) -> Status:
        """Check that the PL carried out this command and no other, and take over its data-valid flags."""
        status = self._read_status(segment)
        where = f"stage {segment.stage!r}, launch {self._sequence}"
        if status.busy or status.armed or status.sequence != self._sequence & 0xFF:
            raise LostWrite(f"{where}: the PL is at launch {status.sequence} (modulo 256), {status}")
        if status.segment != segment.number:
            raise WrongSegment(f"{where}: segment {status.segment} ran, not {segment.number}")
        self._valid = sum(
            self._read(Register.DATA_VALID + 4 * word) << (WORD_BITS * word)
            for word in range(self._flag_words)
        )
        self._written |= segment.writes
        self._require(segment, segment.writes & ~segment.stales & ~self._valid)
        return status

    def _require(self, segment: Segment, invalid: int) -> None:
        """Raise if there is any buffer in `invalid`."""
        if invalid:
            names = ", ".join(self._method.names(invalid))
            raise ReadBeforeValid(f"stage {segment.stage!r}: data-valid flag is down for {names}")

    def _require_rest(self) -> None:
        """At the end of a run nothing may be running, half announced or unacknowledged."""
        status = self._read_status(None)
        if status.done or self._port.interrupt:
            raise UnacknowledgedInterrupt(f"the run ended with launch {status.sequence} unacknowledged")
        if status.busy or status.armed:
            raise LostWrite(f"the run ended, but the PL is not at rest: {status}")

    def _fetch(self, segment: Segment) -> None:
        """Move to the PS what the stage reads and only the PL holds."""
        self._move(Kind.TO_PS, segment.reads & ~self._held_by_ps)
        self._held_by_ps |= segment.reads

    def _deliver(self, segment: Segment) -> None:
        """Move to the PL what the segment reads and only the PS holds."""
        self._move(Kind.TO_PL, segment.reads & ~self._held_by_pl)
        self._held_by_pl |= segment.reads

    def _move(self, kind: Kind, buffers: int) -> None:
        for name in self._method.names(buffers):
            self._record.add(kind, name, self._words[name])
            if self._carry is not None:
                self._carry(kind, name)

    def _read_status(self, segment: Segment | None) -> Status:
        status = Status.decode(self._read(Register.STATUS))
        if status.fault is not Fault.NONE:
            where = f"stage {segment.stage!r}, launch {self._sequence}" if segment else "end of the run"
            raise ERROR_OF_FAULT[status.fault](f"{where}: the PL reports {status.fault.name}")
        return status

    def _write(self, register: Register | Wrapper, value: int) -> None:
        self._record.add(Kind.WRITE, register.name, int(value))
        self._port.write(register, int(value))

    def _read(self, address: int) -> int:
        value = self._port.read(address)
        name = Register.DATA_VALID if address >= Register.DATA_VALID else Register(address)
        self._record.add(Kind.READ, name.name, value)
        return value
