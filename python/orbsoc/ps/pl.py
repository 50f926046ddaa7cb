"""The PL as the PS sees it: register file, operation control, data-valid flags and interrupt line.

The operation control runs one segment at a time; its numbers come from `Engine.run(stage)`. It accepts the
writes of a frame in their one order only, so that a write that is lost, doubled or overtaken leaves a fault.
"""

from __future__ import annotations

import enum
from collections.abc import Callable, Sequence

from .program import BusyClocks, ControlProgram, instruction_clocks
from .registers import WORD_BITS, WORD_MASK, Control, Fault, Module, Register, Status, Wrapper
from .segments import Method, Segment


class _State(enum.Enum):
    """Where the operation control is in a frame."""

    IDLE = enum.auto()
    HAVE_MODULE = enum.auto()
    HAVE_SEGMENT = enum.auto()
    HAVE_SEQUENCE = enum.auto()
    BUSY = enum.auto()
    DONE = enum.auto()
    FAULT = enum.auto()


_ARMED = frozenset({_State.HAVE_MODULE, _State.HAVE_SEGMENT, _State.HAVE_SEQUENCE})
_FRAME = {
    _State.IDLE: Register.MODULE,
    _State.HAVE_MODULE: Register.SEGMENT,
    _State.HAVE_SEGMENT: Register.SEQUENCE,
    _State.HAVE_SEQUENCE: Register.CONTROL,
}
_NEXT = {
    Register.MODULE: _State.HAVE_MODULE,
    Register.SEGMENT: _State.HAVE_SEGMENT,
    Register.SEQUENCE: _State.HAVE_SEQUENCE,
}


class ProgrammableLogic:
    """A fresh PL: flags down, launch counter 0.

    `execute` runs a stage and returns its outcome; a segment takes `busy_ticks` ≥ 1 polls of the PS. With a `program`,
    the operation control runs whole attempts, one segment of it a poll. With `clocks` it has the wrapper's LIMIT and SPENT as
    well: a launch that would be busy for more is stopped before the segment that would exceed it.
    """

    def __init__(
        self,
        method: Method,
        execute: Callable[[str], int],
        *,
        busy_ticks: int = 1,
        program: ControlProgram | None = None,
        clocks: BusyClocks | None = None,
    ) -> None:
        if busy_ticks < 1:
            raise ValueError(f"busy_ticks = {busy_ticks} must be at least 1")
        self._segments = method.segments
        self._words = -(-len(method.buffers) // WORD_BITS)
        self._execute = execute
        self._busy_ticks = busy_ticks
        self._state = _State.IDLE
        self._frame = dict.fromkeys((Register.MODULE, Register.SEGMENT, Register.SEQUENCE), 0)
        self._valid = 0
        self._written = 0
        self._outcome = 0
        self._completed = (0, 0)
        self._fault = Fault.NONE
        self._ticks_left = 0
        self._by_stage = {segment.stage: segment for segment in method.segments}
        self._flags = method.flags
        self._code = () if program is None else program.instructions
        self._entries = () if program is None else (program.cold, program.warm)
        self._at: int | None = None
        """The next instruction of an attempt; None: a single segment runs."""
        self._raised = self._stop_asked = False
        self._clocks = clocks
        self._limit = self._spent = 0
        self.ran: list[tuple[str, ...]] = []
        """The segments that the operation control ran by itself."""

    @property
    def interrupt(self) -> bool:
        """Up from the end of a segment, or a fault, until it is acknowledged, or for ever."""
        return self._state in (_State.DONE, _State.FAULT)

    def read(self, address: int) -> int:
        """STATUS, a DATA_VALID word, LIMIT or SPENT; anything else is a fault, and reads 0."""
        if self._clocks is not None and address in (Wrapper.LIMIT, Wrapper.SPENT):
            return self._limit if address == Wrapper.LIMIT else self._spent
        if address == Register.STATUS:
            return self._status().encode()
        word, offset = divmod(address - Register.DATA_VALID, WORD_BITS // 8)
        if offset or not 0 <= word < self._words:
            self._stop(Fault.INVALID_ACCESS)
            return 0
        return self._valid >> (word * WORD_BITS) & WORD_MASK

    def write(self, address: int, value: int) -> None:
        """Take one write; the first that is out of turn stops the PL with its fault."""
        if self._clocks is not None and address == Wrapper.LIMIT:
            self._limit = value
            return
        if self._state is _State.FAULT:
            return
        fault = self._refusal(address)
        if fault is not Fault.NONE:
            self._stop(fault)
        elif address == Register.IRQ_ACK:
            self._acknowledge(value)
        elif address == Register.STOP:
            self._stop_asked = bool(value & 1)
        elif address == Register.CONTROL:
            self._command(value)
        else:
            register = Register(address)
            self._frame[register] = value
            self._state = _NEXT[register]

    def tick(self) -> None:
        """Let the running segment advance; at its end the flags move and the interrupt goes up."""
        if self._state is not _State.BUSY:
            return
        if self._at is not None:
            self._run_on()
            return
        self._ticks_left -= 1
        if self._ticks_left == 0:
            segment = self._announced()
            if self._clocks and self._exceeds(self._clocks.segments[segment.stage,] + self._clocks.launch):
                return
            self._outcome = self._execute(segment.stage)
            if self._state is _State.BUSY:
                self._complete(segment)
                self._state = _State.DONE

    def upset(self) -> None:
        """An engine with parity has read a word or a line with a bit turned over, while a stage runs or at rest: it stops."""
        self._stop(Fault.PARITY)

    def _run_on(self) -> None:
        """Run the control program up to and with its next segment, or to its end."""
        while self._state is _State.BUSY and self._at is not None:
            instruction = self._code[self._at]
            self._at += 1
            if self._clocks and self._exceeds(instruction_clocks(instruction, self._clocks)):
                return
            match instruction.op:
                case "run":
                    self._run_stream(instruction.stream)
                    return
                case "end":
                    self._completed = (0, self._frame[Register.SEQUENCE])
                    self._state, self._at = _State.DONE, None
                case _:
                    raised = self._raised or (self._stop_asked and self._flags[instruction.flag][0] == "stop")
                    if raised == (instruction.op == "if"):
                        self._at = instruction.target

    def _run_stream(self, stream: Sequence[str]) -> None:
        """The stages of one segment; the last leaves the flag that the next instruction reads."""
        for stage in stream:
            segment = self._by_stage[stage]
            if segment.unreadable(self._valid, self._written):
                self._stop(Fault.READ_BEFORE_VALID)
                return
            self._valid &= ~segment.writes
            self._raised = self._execute(stage) != 0
            if self._state is not _State.BUSY:
                return
            self._valid = segment.valid_after(self._valid)
            self._written |= segment.writes
        self.ran.append(tuple(stream))

    def _refusal(self, address: int) -> Fault:
        """The fault of a write to `address` in the present state, if any."""
        if address == Register.STOP and self._code:
            return Fault.NONE
        if address not in (*_FRAME.values(), Register.IRQ_ACK):
            return Fault.INVALID_ACCESS
        if self._state is _State.BUSY:
            return Fault.LAUNCH_WHILE_BUSY
        if address == Register.IRQ_ACK:
            return Fault.NONE if self._state is _State.DONE else Fault.SPURIOUS_ACKNOWLEDGE
        if self._state is _State.DONE:
            return Fault.UNACKNOWLEDGED_INTERRUPT
        return Fault.NONE if address == _FRAME[self._state] else Fault.WRITE_OUT_OF_ORDER

    def _acknowledge(self, sequence: int) -> None:
        if sequence != self._frame[Register.SEQUENCE]:
            self._stop(Fault.SPURIOUS_ACKNOWLEDGE)
        else:
            self._state = _State.IDLE

    def _command(self, value: int) -> None:
        fault = self._frame_fault(value)
        if fault is not Fault.NONE:
            self._stop(fault)
            return
        if value != Control.PUBLISH:
            self._spent = 0
        if value == Control.ATTEMPT:
            self._at, self._stop_asked = self._frame[Register.SEGMENT], False
            self._state = _State.BUSY
            return
        segment = self._announced()
        self._valid &= ~segment.writes
        if value == Control.START:
            self._ticks_left = self._busy_ticks
            self._state = _State.BUSY
        else:
            self._complete(segment)
            self._state = _State.IDLE

    def _frame_fault(self, value: int) -> Fault:
        """What is wrong with a complete frame, if anything."""
        if value not in (Control.START, Control.PUBLISH) and not (self._code and value == Control.ATTEMPT):
            return Fault.INVALID_ACCESS
        if self._frame[Register.SEQUENCE] != (self._completed[1] + 1) & WORD_MASK:
            return Fault.WRONG_SEQUENCE
        if value == Control.ATTEMPT:
            known = self._frame[Register.SEGMENT] in self._entries
            return Fault.NONE if known and self._frame[Register.MODULE] == Module.PS else Fault.WRONG_SEGMENT
        if self._frame[Register.SEGMENT] >= len(self._segments):
            return Fault.WRONG_SEGMENT
        segment = self._announced()
        runs_on_ps = value == Control.PUBLISH
        if segment.module != self._frame[Register.MODULE] or (segment.module is Module.PS) != runs_on_ps:
            return Fault.WRONG_SEGMENT
        if segment.unreadable(self._valid, self._written):
            return Fault.READ_BEFORE_VALID
        return Fault.NONE

    def _announced(self) -> Segment:
        return self._segments[self._frame[Register.SEGMENT]]

    def _complete(self, segment: Segment) -> None:
        self._valid = segment.valid_after(self._valid)
        self._written |= segment.writes
        self._completed = (segment.number, self._frame[Register.SEQUENCE])

    def _exceeds(self, clocks: int) -> bool:
        """Whether the launch is stopped within its next clocks. The engine's reset forgets flags and completed stages."""
        self._spent += clocks
        if self._limit == 0 or self._spent <= self._limit:
            return False
        self._spent = self._limit + 1
        self._valid = self._written = self._outcome = 0
        self._completed = (0, 0)
        self._stop(Fault.CYCLE_LIMIT)
        return True

    def _stop(self, fault: Fault) -> None:
        if self._state is not _State.FAULT:
            self._fault = fault
            self._state = _State.FAULT

    def _status(self) -> Status:
        segment, sequence = self._completed
        return Status(
            busy=self._state is _State.BUSY,
            done=self._state is _State.DONE,
            armed=self._state in _ARMED,
            outcome=self._outcome,
            fault=self._fault,
            segment=segment,
            sequence=sequence & 0xFF,
        )
