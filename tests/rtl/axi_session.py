"""The engine behind AXI under Verilator with the driver in C as its PS (rtl/harness/axi_engine.cpp), for `solve_on_rtl`.

Python still decides which buffers move and compares every word; frames, waiting, acknowledgements and each word that moves
are the C driver's, and every access of it is an AXI transaction.
"""

from __future__ import annotations

from pathlib import Path

from orbsoc import _core
from orbsoc.hw.schedules import Engine
from orbsoc.ps.driver import Driver
from orbsoc.ps.events import Kind
from orbsoc.ps.program import ControlProgram
from orbsoc.ps.registers import WORD_MASK, Control, Register
from orbsoc.ps.segments import Method, Segment
from orbsoc.rtl.digest import program_digest
from orbsoc.rtl.session import RtlPort, RtlSession, control_words
from orbsoc.rtl.validation import Format
from tests.rtl.engine_sources import build

SEQUENCERS = {"flat": 0, "compressed": 1}
CODE_BITS = 14


def built_behind_axi(
    folder: Path,
    engine: Engine,
    form: Format,
    *,
    lines: int,
    resident: bool = True,
    parity: bool = False,
    stream: int = 0,
    beat: int = 64,
) -> Path:
    """The harness of an engine behind AXI; one microcode memory for all programs of the tests, or `stream` ports with beats of
    `beat` bits for compressed lines from the host's memory."""
    assert lines <= 1 << CODE_BITS
    return build(
        "axi_engine", rtl=folder, FP=engine.fp, LANES=engine.lanes, DIVIDERS=engine.dividers, BANKS=engine.banks,
        ADDRESS_BITS=engine.address_bits, SEQUENCER=3 if stream else SEQUENCERS[form], CODE_BITS=CODE_BITS, RESIDENT=int(resident),
        **({"PARITY": 1} if parity else {}), **({"STREAM": stream, "BEAT": beat} if stream else {}),
        **({"CLUSTERS": engine.clusters} if engine.clusters > 1 else {}), **({"ROWS": engine.rows} if engine.rows else {}),
    )  # fmt: skip


class AxiSession(RtlSession):
    """A session whose program is loaded by `orbsoc_pl_load`, and whose words move through the driver."""

    def load(self, image: _core.ProgramImage, method: Method, program: ControlProgram | None = None) -> None:
        """The image piece by piece to the harness, and from there by the driver to the PL."""
        assert program is not None
        self.give(image, method, program)
        assert self.driver("load") == 0

    def give(self, image: _core.ProgramImage, method: Method, program: ControlProgram) -> None:
        """The image piece by piece to the harness."""
        self._do([f"image_identity {image.identity:x}", f"image_digest {self._digest(image):x}"])
        self._do(f"image_template {word}" for word in image.templates)
        self._do(f"image_line {word}" for word in image.microcode)
        addresses, literals = image.literals
        pairs = zip(addresses.tolist(), literals.tolist(), strict=True)
        self._do(f"image_literal {address:x} {word:x}" for address, word in pairs)
        for segment in sorted(method.numbered(program).values(), key=lambda each: each.number):
            start, _ = image.entries.get(segment.stage, (0, 0))
            masks = f"{segment.reads:x} {segment.writes:x} {segment.stales:x}"
            self._do([f"image_segment {int(segment.module):x} {start:x} {masks}"])
        self._do(
            f"image_instruction {word:x} {flag:x}" for word, flag in control_words(image, method, program)
        )

    @staticmethod
    def _digest(image: _core.ProgramImage) -> int:
        width = 4 * len(image.microcode[0])
        lines = [
            [int(line, 16) >> low & WORD_MASK for low in range(0, width, 32)] for line in image.microcode
        ]
        return program_digest([int(word, 16) for word in image.templates], lines)

    def driver(self, command: str) -> int:
        """Have the driver do something; its error."""
        return int(self.ask(command))


class CDriver(Driver):
    """The PS of `solve_on_rtl` with the protocol in C; `interrupts` says how it waits."""

    interrupts = False

    def _write_frame(self, segment: Segment, command: Control) -> None:
        session = self._session()
        self._sequence = (self._sequence + 1) & WORD_MASK
        if command is Control.PUBLISH:
            assert session.driver(f"publish {segment.number:x}") == 0
            return
        assert command is Control.ATTEMPT
        closing = 0
        for step in self._method.closing:
            closing |= self._segments[step[0]].writes
        assert session.driver(f"attempt {segment.number:x} {closing:x} {segment.writes:x}") == 0

    def _await_attempt(self, attempt: Segment) -> None:
        session = self._session()
        if self._stopped():
            assert session.driver("stop") == 0
        assert session.driver("interrupt 10000000" if self.interrupts else "poll 10000000") == 0
        self._record.add(Kind.INTERRUPT, attempt.stage, 0)

    def _write(self, register: Register, value: int) -> None:
        """The driver has acknowledged already, and nothing else is left to write."""
        assert register is Register.IRQ_ACK

    def _require_rest(self) -> None:
        assert self._session().driver("rest") == 0

    def _session(self) -> AxiSession:
        assert isinstance(self._port, RtlPort)
        assert isinstance(self._port.session, AxiSession)
        return self._port.session


class InterruptedCDriver(CDriver):
    """It takes the end of an attempt in the interrupt handler."""

    interrupts = True
