"""The register map between PS and PL, its bit layouts, and what can go wrong on it.

Registers are 32-bit words at byte addresses. One frame of four writes, in this order and no other, announces
every stage: MODULE, SEGMENT, SEQUENCE, CONTROL. docs/ps-pl-protocol.md gives the protocol with its timing.
Source of the structure: Aerospace Control 43(3), 2025, §2.3 (control, status, data-valid flags, interrupt);
addresses, layouts and checks are this project's.

It is the one source of the map: scripts/write_registers.py makes the driver's C header of it (rtl/driver), and a test holds the
RTL's constants against it. The emulated PL has only `Register`; tables and the wrapper's registers are the RTL's.
"""

from __future__ import annotations

import enum
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

WORD_BITS = 32
WORD_MASK = (1 << WORD_BITS) - 1


class Register(enum.IntEnum):
    """Byte addresses. STOP asks a running attempt to end at its next decision. DATA_VALID is the first of ⌈buffers/32⌉ words, one flag per buffer."""

    MODULE = 0x00
    SEGMENT = 0x04
    SEQUENCE = 0x08
    CONTROL = 0x0C
    STATUS = 0x10
    IRQ_ACK = 0x14
    STOP = 0x18
    DATA_VALID = 0x20


class Module(enum.IntEnum):
    """Values of the MODULE register: the PS itself and the seven modules of the PL."""

    PS = 0
    MATRIX_UPDATE = 1
    MATRIX_SCALING = 2
    FACTORIZATION = 3
    LINEAR_SOLVE = 4
    CONE_OPS = 5
    LINE_SEARCH = 6
    STATISTICS = 7


class Control(enum.IntEnum):
    """Values of the CONTROL register."""

    START = 1
    """Run the announced segment on the PL; an interrupt tells the end."""
    PUBLISH = 2
    """The PS ran the announced stage itself: set and clear the flags of what it wrote and made stale."""
    ATTEMPT = 3
    """Run the control program from the instruction in SEGMENT on, up to its end; an interrupt tells that."""


class Fault(enum.IntEnum):
    """Fault codes in STATUS. The first fault stops the PL, raises the interrupt and stays until reset."""

    NONE = 0
    LAUNCH_WHILE_BUSY = 1
    UNACKNOWLEDGED_INTERRUPT = 2
    SPURIOUS_ACKNOWLEDGE = 3
    WRITE_OUT_OF_ORDER = 4
    WRONG_SEGMENT = 5
    WRONG_SEQUENCE = 6
    READ_BEFORE_VALID = 7
    INVALID_ACCESS = 8
    CYCLE_LIMIT = 9
    """Raised by the wrapper of the engine, not by its register file."""
    PARITY = 10
    """Raised by an engine with parity where a word of storage or a line of microcode that it reads has a bit turned over."""
    STREAM_ERROR = 11
    """Raised by the wrapper of an engine with streamed microcode where memory answers a read of it with an error."""


@dataclass(frozen=True, slots=True)
class Field:
    """Some bits of a word."""

    shift: int
    bits: int

    @property
    def mask(self) -> int:
        """The field's bits in place."""
        return ((1 << self.bits) - 1) << self.shift

    def put(self, value: int) -> int:
        """The low bits of `value` in place."""
        return value << self.shift & self.mask

    def of(self, word: int) -> int:
        """The field's value in a word."""
        return (word & self.mask) >> self.shift


STATUS_FIELDS: Mapping[str, Field] = {
    "busy": Field(0, 1),
    "done": Field(1, 1),
    "armed": Field(2, 1),
    "outcome": Field(4, 2),
    "fault": Field(8, 4),
    "segment": Field(16, 8),
    "sequence": Field(24, 8),
}

# ---- Tables of the RTL (docs/pl-machine.md, Register file) ----

SEGMENTS, BUFFERS, INSTRUCTIONS, TEMPLATES = 64, 64, 128, 64
"""Rows of the table of segments, flags of a mask, instructions of the control program, templates of compressed microcode."""
STREAM_ALIGN = 256
"""Bytes at whose multiples a port's parts of lines begin: the longest burst."""
TABLE, TABLE_ENTRY = 0x1000, 64
"""First byte address of the table of segments, and bytes from entry to entry."""
PROGRAM, PROGRAM_ENTRY = 0x2000, 8
"""The same of the control program: the instruction, and behind it the storage address of its flag."""
PROGRAM_FLAG = 4


class Entry(enum.IntEnum):
    """Offsets in an entry of the table of segments. A mask has two words, buffers 0 to 31 first."""

    MODULE = 0
    START = 4
    READS = 8
    WRITES = 16
    STALES = 24
    LINES = 32
    """How many lines of microcode it has: of streamed microcode alone."""


class Op(enum.IntEnum):
    """What an instruction of the control program does: `if` jumps where the flag is raised, `unless` where it is not."""

    END = 0
    RUN = 1
    IF = 2
    UNLESS = 3


INSTRUCTION_FIELDS: Mapping[str, Field] = {
    "op": Field(0, 2),
    "stop": Field(2, 1),
    "segment": Field(8, 8),
    "target": Field(16, 8),
    "entry": Field(24, 1),
}
"""`stop`: the stop bit counts as the flag; `entry`: an attempt may begin here."""

# ---- AXI (docs/driver.md) ----


class Wrapper(enum.IntEnum):
    """Registers of rtl/axi, which never reach the engine. RESET takes 1: the engine's reset; DIGEST begins anew with any
    write; LIMIT keeps its value over a RESET; the others are read."""

    RESET = 0x3000
    ENGINE = 0x3004
    SIZES = 0x3008
    CYCLES = 0x300C
    """Busy cycles of the segment that runs, or ran last, by the engine's own counter."""
    IDENTITY = 0x3010
    """One number for everything of the engine that a program depends on; the program's must be the same."""
    DIGEST = 0x3014
    """CRC-32 of the pieces of microcode and templates written since the last write to it, and of where they went."""
    LIMIT = 0x3018
    """Clocks that a launch may be busy; one that is busy for more is stopped with CYCLE_LIMIT. 0: as long as it likes."""
    SPENT = 0x301C
    """Clocks for which STATUS has said BUSY of the launch that runs, or ran last."""
    STREAM_BASE = 0x3020
    """Of streamed microcode: where in memory the first port's parts of the lines lie. The other ports' follow, a word each; written
    alone."""
    WORDS = 0x3030
    """Words of storage: only of an engine that says of itself that it has fewer than its addresses reach (ENGINE, `fewer_words`)."""


ENGINE_FIELDS: Mapping[str, Field] = {
    "lanes": Field(0, 7),
    "binary64": Field(7, 1),
    "dividers": Field(8, 8),
    "sequencer": Field(16, 2),
    "stream": Field(18, 3),
    "resident": Field(24, 1),
    "parity": Field(25, 1),
    "fewer_words": Field(26, 1),
}
SIZES_FIELDS: Mapping[str, Field] = {
    "address_bits": Field(0, 8),
    "code_bits": Field(8, 8),
    "code_width": Field(16, 16),
}


class Region(enum.IntEnum):
    """First byte addresses of the memories behind the AXI4 port."""

    STORAGE = 0 << 24
    MICROCODE = 1 << 24
    TEMPLATES = 2 << 24


@dataclass(frozen=True, slots=True)
class Status:
    """The STATUS word: BUSY bit 0, DONE 1, ARMED 2, OUTCOME 4–5, FAULT 8–11, SEGMENT 16–23, SEQUENCE 24–31.

    DONE means that an interrupt awaits its acknowledgement; ARMED that a frame is incomplete; OUTCOME is what
    the last stage returned; SEGMENT and SEQUENCE (its low 8 bits) name the last stage completed or published.
    """

    busy: bool = False
    done: bool = False
    armed: bool = False
    outcome: int = 0
    fault: Fault = Fault.NONE
    segment: int = 0
    sequence: int = 0

    def encode(self) -> int:
        """The 32-bit word."""
        return sum(field.put(int(getattr(self, name))) for name, field in STATUS_FIELDS.items())

    @classmethod
    def decode(cls, word: int) -> Status:
        """The fields of a 32-bit word."""
        found = {name: field.of(word) for name, field in STATUS_FIELDS.items()}
        return cls(
            busy=bool(found["busy"]),
            done=bool(found["done"]),
            armed=bool(found["armed"]),
            outcome=found["outcome"],
            fault=Fault(found["fault"]),
            segment=found["segment"],
            sequence=found["sequence"],
        )


class RegisterFile(Protocol):
    """What the PS sees of the PL: registers, an interrupt line, and time passing while it waits."""

    @property
    def interrupt(self) -> bool:
        """Whether the interrupt line is up."""
        ...

    def write(self, address: int, value: int) -> None:
        """Post one 32-bit write."""
        ...

    def read(self, address: int) -> int:
        """Read one 32-bit word."""
        ...

    def tick(self) -> None:
        """Let the PL work for one poll of the PS."""
        ...


class ProtocolError(RuntimeError):
    """PS and PL disagree about the state of the computer; the solve cannot go on. Base of all faults below."""


class LaunchWhileBusy(ProtocolError):
    """A register was written while a segment ran."""


class UnacknowledgedInterrupt(ProtocolError):
    """A frame began, or the run ended, while an interrupt awaited its acknowledgement."""


class SpuriousAcknowledge(ProtocolError):
    """IRQ_ACK was written with no interrupt up, or for another launch than the one that raised it."""


class WriteOutOfOrder(ProtocolError):
    """A frame's write came out of turn, twice, or not at all."""


class WrongSegment(ProtocolError):
    """The segment does not exist, belongs to another module, or is not the one that was announced."""


class WrongSequence(ProtocolError):
    """The launch counter did not advance by one: a frame was lost or came twice."""


class ReadBeforeValid(ProtocolError):
    """A stage would read a buffer whose data-valid flag is down."""


class InvalidAccess(ProtocolError):
    """An access to an address that does not exist or cannot be written, or an unknown command."""


class CycleLimit(ProtocolError):
    """A launch was busy for more clocks than the PS allowed, and was stopped."""


class Parity(ProtocolError):
    """The PL read a word of storage or a line of microcode with a bit turned over, and stopped."""


class StreamError(ProtocolError):
    """Memory answered a read of streamed microcode with an error, and the launch was stopped."""


class LostInterrupt(ProtocolError):
    """The segment finished, but its interrupt did not arrive within the polling budget."""


class LaunchTimeout(ProtocolError):
    """Neither an interrupt nor the end of the segment within the polling budget."""


class LostWrite(ProtocolError):
    """A command was written, but the status word does not show it carried out."""


ERROR_OF_FAULT: dict[Fault, type[ProtocolError]] = {
    Fault.LAUNCH_WHILE_BUSY: LaunchWhileBusy,
    Fault.UNACKNOWLEDGED_INTERRUPT: UnacknowledgedInterrupt,
    Fault.SPURIOUS_ACKNOWLEDGE: SpuriousAcknowledge,
    Fault.WRITE_OUT_OF_ORDER: WriteOutOfOrder,
    Fault.WRONG_SEGMENT: WrongSegment,
    Fault.WRONG_SEQUENCE: WrongSequence,
    Fault.READ_BEFORE_VALID: ReadBeforeValid,
    Fault.INVALID_ACCESS: InvalidAccess,
    Fault.CYCLE_LIMIT: CycleLimit,
    Fault.PARITY: Parity,
    Fault.STREAM_ERROR: StreamError,
}
