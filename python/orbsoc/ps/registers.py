"""The register map between PS and PL, its bit layouts, and what can go wrong on it.

Registers are 32-bit words at byte addresses. One frame of four writes, in this order and no other, announces
every stage: MODULE, SEGMENT, SEQUENCE, CONTROL. docs/ps-pl-protocol.md gives the protocol with its timing.
Source of the structure: Aerospace Control 43(3), 2025, §2.3 (control, status, data-valid flags, interrupt);
addresses, layouts and checks are this project's.
"""

from __future__ import annotations

import enum
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
        flags = self.busy | self.done << 1 | self.armed << 2 | (self.outcome & 0x3) << 4
        return flags | self.fault << 8 | (self.segment & 0xFF) << 16 | (self.sequence & 0xFF) << 24

    @classmethod
    def decode(cls, word: int) -> Status:
        """The fields of a 32-bit word."""
        return cls(
            busy=bool(word & 1),
            done=bool(word >> 1 & 1),
            armed=bool(word >> 2 & 1),
            outcome=word >> 4 & 0x3,
            fault=Fault(word >> 8 & 0xF),
            segment=word >> 16 & 0xFF,
            sequence=word >> 24 & 0xFF,
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
}
