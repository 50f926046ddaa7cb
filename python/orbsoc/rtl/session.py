"""The RTL under Verilator, driven live: its registers, storage and clock over the pipe of rtl/harness/session.hpp."""

from __future__ import annotations

import subprocess
import tempfile
import threading
import time
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from types import TracebackType
from typing import Self

import numpy as np
from numpy.typing import NDArray

from orbsoc import _core
from orbsoc.ps.program import ControlProgram
from orbsoc.ps.registers import (
    INSTRUCTION_FIELDS,
    PROGRAM,
    PROGRAM_ENTRY,
    PROGRAM_FLAG,
    TABLE,
    TABLE_ENTRY,
    WORD_BITS,
    WORD_MASK,
    Entry,
    Op,
    Register,
)
from orbsoc.ps.segments import Method, Segment

from .validation import RtlError

Addresses = NDArray[np.uint32]
Bits = NDArray[np.uint64]

_AT_ONCE = 256
"""Commands sent before their answers are read: the answers must fit the pipe."""
PATIENCE_S = 60.0
"""Longest wait for an answer of the harness, and for the end of a launch: what runs on without one is stopped."""
_CYCLES_PER_POLL = 10_000
"""How long one poll of the interrupt line lets the PL run, at most."""


def control_words(
    image: _core.ProgramImage, method: Method, program: ControlProgram, copies: int = 1
) -> Iterator[tuple[int, int]]:
    """The instructions of a control program as the RTL has them: word, and the storage address of its flag. Of several copies
    of a problem the flag of all is the buffer's last word."""
    numbers, fields = method.numbered(program), INSTRUCTION_FIELDS
    for place, instruction in enumerate(program.instructions):
        word = fields["op"].put(Op[instruction.op.upper()]) | fields["target"].put(instruction.target)
        word |= fields["entry"].put(place in (program.cold, program.warm))
        flag = 0
        if instruction.op == "run":
            word |= fields["segment"].put(numbers[instruction.stream].number)
        elif instruction.flag:
            kind, buffer = method.flags[instruction.flag]
            indices, addresses = image.homes[buffer]
            index = 0 if copies == 1 else int(indices.max())
            flag = int(addresses[int(np.flatnonzero(indices == index)[0])])
            word |= fields["stop"].put(kind == "stop")
        yield word, flag


class RtlSession:
    """One running harness, an executable of `validation.built`; use it as a context.

    Raises RtlError when the harness ends, answers what it should not, or does not answer within `patience_s`.
    """

    def __init__(self, harness: Path, patience_s: float = PATIENCE_S, options: Sequence[str] = ()) -> None:
        """`options`: +NAMEs that the RTL of a test asks for."""
        self.patience_s = patience_s
        self._asked_at: float | None = None
        self._late = False
        self._closed = threading.Event()
        self._errors = tempfile.TemporaryFile("w+")  # noqa: SIM115  # as long-lived as the session
        self._process = subprocess.Popen(
            [harness, "-", *options],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self._errors, text=True,
        )  # fmt: skip
        threading.Thread(target=self._watch, daemon=True).start()

    def _watch(self) -> None:
        """Stop the harness when an answer is late; the reader of the pipe then finds its end."""
        while not self._closed.wait(min(1.0, self.patience_s)):
            asked_at = self._asked_at
            if asked_at is not None and time.monotonic() - asked_at > self.patience_s:
                self._late = True
                self._process.kill()
                return

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._closed.set()
        self._process.kill()
        self._process.communicate()
        self._errors.close()

    def ask(self, command: str) -> str:
        """One command, one answer."""
        return self.ask_all([command])[0]

    def ask_all(self, commands: Iterable[str]) -> list[str]:
        """Many commands, their answers."""
        pipe_in, pipe_out = self._process.stdin, self._process.stdout
        assert pipe_in is not None and pipe_out is not None  # noqa: PT018  # both are pipes
        waiting, answers = list(commands), list[str]()
        for first in range(0, len(waiting), _AT_ONCE):
            some = waiting[first : first + _AT_ONCE]
            self._asked_at = time.monotonic()
            try:
                pipe_in.write("\n".join(some) + "\n")
                pipe_in.flush()
            except BrokenPipeError:
                raise self._broken(some[0]) from None
            for command in some:
                answer = pipe_out.readline().strip()
                if not answer:
                    raise self._broken(command)
                answers.append(answer)
                self._asked_at = time.monotonic()
        self._asked_at = None
        return answers

    def _broken(self, command: str) -> RtlError:
        if self._late:
            return RtlError(f"the RTL's session gave no answer to {command!r} within {self.patience_s:g} s")
        self._errors.seek(0)
        return RtlError(
            f"the RTL's session ended at {command!r}: {self._errors.read().strip() or 'no reason given'}"
        )

    def reset(self) -> None:
        """Registers, flags and rules afresh; storage counts as unwritten."""
        self._do(["reset"])

    def load(
        self,
        image: _core.ProgramImage,
        method: Method,
        program: ControlProgram | None = None,
        copies: int = 1,
    ) -> None:
        """Microcode, templates and literals of a program, and the table of the method's segments; the control program,
        which reads the flags of as many `copies` of a problem as the segments work on.

        Raises RtlError, with nothing written, for a program of another engine.
        """
        self.require_engine_of(image)
        self._do(f"template {k:x} {word}" for k, word in enumerate(image.templates))
        self._do(f"code {line:x} {word}" for line, word in enumerate(image.microcode))
        self.set_words(*image.literals)
        segments = method.segments if program is None else tuple(method.numbered(program).values())
        for segment in segments:
            start, _ = image.entries.get(segment.stage, (0, 0))
            self.write_segment(segment, start)
        if program is not None:
            for place, (word, flag) in enumerate(control_words(image, method, program, copies)):
                self.write_instruction(place, word, flag)

    def require_engine_of(self, image: _core.ProgramImage) -> None:
        """Raise RtlError unless the program was made for this engine."""
        try:
            image.require_identity(int(self.ask("identity"), 16))
        except _core.HardwareError as error:
            raise RtlError(str(error)) from error

    def write_segment(self, segment: Segment, start: int) -> None:
        """An entry of the table of segments; `start` is the first line of its microcode."""
        entry = TABLE + TABLE_ENTRY * segment.number
        masks = ((Entry.READS, segment.reads), (Entry.WRITES, segment.writes), (Entry.STALES, segment.stales))
        self.write(entry + Entry.START, start)
        for offset, mask in masks:
            self.write(entry + offset, mask & WORD_MASK)
            self.write(entry + offset + WORD_BITS // 8, mask >> WORD_BITS)
        self.write(entry + Entry.MODULE, segment.module)  # makes it exist

    def write_instruction(self, place: int, word: int, flag: int) -> None:
        """An instruction of the control program, and the storage address of its flag."""
        self.write(PROGRAM + PROGRAM_ENTRY * place + PROGRAM_FLAG, flag)
        self.write(PROGRAM + PROGRAM_ENTRY * place, word)

    def write(self, address: int, value: int) -> None:
        """Write a register: one clock."""
        self._do([f"write {address:x} {int(value):x}"])

    def read(self, address: int) -> int:
        """Read a register: one clock."""
        return int(self.ask(f"read {address:x}"), 16)

    def wait(self, cycles: int) -> tuple[bool, int]:
        """Clock until the interrupt is up, `cycles` times at most; whether it is, and the segment's busy cycles."""
        interrupt, busy = self.ask(f"wait {cycles}").split()
        return interrupt == "1", int(busy)

    def set_words(self, addresses: Addresses, words: Bits) -> None:
        """Write words of storage, while nothing runs: one clock each."""
        pairs = zip(addresses.tolist(), words.tolist(), strict=True)
        self._do(f"set {address:x} {word:x}" for address, word in pairs)

    def get_words(self, addresses: Addresses) -> Bits:
        """Read words of storage, while nothing runs: four clocks each."""
        answers = self.ask_all(f"get {address:x}" for address in addresses.tolist())
        return np.array([int(answer, 16) for answer in answers], np.uint64)

    def clocks(self) -> int:
        """Clocks since the session began."""
        return int(self.ask("clocks"))

    def segments(self) -> list[tuple[int, int]]:
        """Number and busy cycles of every segment that has ended since this was last asked."""
        pairs = (each.split(":") for each in self.ask("segments").split()[1:])
        return [(int(number), int(cycles)) for number, cycles in pairs]

    def violations(self) -> Sequence[int]:
        """How often each rule of a schedule was violated since the reset, in the order of docs/pl-machine.md."""
        return [int(count) for count in self.ask("violations").split()]

    def _do(self, commands: Iterable[str]) -> None:
        if any(answer != "ok" for answer in self.ask_all(commands)):
            raise RtlError("the RTL's session did not carry out a command")


class RtlPort:
    """The RTL's register file as the PS of `orbsoc.ps` sees it; `busy` lists segment and busy cycles of its launches."""

    def __init__(self, session: RtlSession) -> None:
        self.session = session
        self.busy: list[tuple[int, int]] = []
        self._segment = 0
        self._launched_at = time.monotonic()

    @property
    def interrupt(self) -> bool:
        """Whether the interrupt line is up."""
        return self.session.wait(0)[0]

    def write(self, address: int, value: int) -> None:
        """Post one write; an acknowledgement notes what the engine's own counter says of the segment."""
        if address == Register.SEGMENT:
            self._segment = value
        if address == Register.CONTROL:
            self._launched_at = time.monotonic()
        if address == Register.IRQ_ACK:
            self.busy.append((self._segment, self.session.wait(0)[1]))
        self.session.write(address, value)

    def read(self, address: int) -> int:
        """Read one register."""
        return self.session.read(address)

    def tick(self) -> None:
        """Let the PL run until its interrupt, or for as long as one poll lasts. Raises RtlError where no end is to be seen."""
        if time.monotonic() - self._launched_at > self.session.patience_s:
            raise RtlError(
                f"the PL has not ended what it was launched for within {self.session.patience_s:g} s"
            )
        self.session.wait(_CYCLES_PER_POLL)
