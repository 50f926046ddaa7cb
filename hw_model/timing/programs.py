"""Programs: what the PS writes before the PL can solve problems of another pattern, and how long that takes.

A program is its microcode; its templates and literals, word by word; and the tables of the register file. Microcode that
stays in its memory is written once a boot. Of the others each is written whenever its pattern comes again: a plan is taken
as one of many alike, so that its first solve follows the last one of the plan before. Templates, literals and tables have
one place, and are written at every change of the pattern.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

from hw_model.vocabulary import WORD_BYTES, picoseconds_of_ns

from . import link
from .control_program import SEPARATOR, control_program, streams_of

if TYPE_CHECKING:
    from hw_model.platform.partition import Partition
    from hw_model.platform.platform import Platform

    from .trace import Trace

ROW_WRITES = 8
"""Register writes of a row of the table of segments: module, first line, three masks of two words."""
INSTRUCTION_WRITES = 2
"""Register writes of an instruction of the control program."""
LITERALS = 32
"""Literals of a program of seven modules; six have fewer."""
TEMPLATES = 64
"""Templates that compressed microcode has at most."""
_REGISTER_BYTES = 4


class Program(NamedTuple):
    """One pattern's program, by what is written for it."""

    microcode_bytes: int
    """Its lines as they lie behind the port, each at a power of two of bytes."""
    word_bytes: int
    """Templates and literals."""
    register_writes: int
    """Tables, and the reset before them."""

    @property
    def word_stores(self) -> int:
        """Single stores that write its templates and literals."""
        return self.word_bytes // _REGISTER_BYTES


@dataclass(frozen=True, slots=True)
class Programs:
    """The programs of a trace's patterns."""

    each: tuple[Program, ...]
    resident: tuple[int, ...]
    """Patterns whose microcode stays."""
    changes: tuple[int, ...]
    """Of each pattern: solves of it in a plan that follow one of another."""

    def written(self, pattern: int) -> int:
        """Bytes of microcode that a change to the pattern writes."""
        return 0 if pattern in self.resident else self.each[pattern].microcode_bytes

    @property
    def boot_bytes(self) -> int:
        """Bytes of microcode that are written once a boot: what stays."""
        return sum(self.each[pattern].microcode_bytes for pattern in self.resident)

    @property
    def plan_bytes(self) -> int:
        """Bytes of microcode that are written once a plan."""
        return sum(count * self.written(pattern) for pattern, count in enumerate(self.changes))

    @property
    def loads(self) -> int:
        """Changes of a plan that write microcode."""
        return sum(count for pattern, count in enumerate(self.changes) if pattern not in self.resident)


NONE = Programs((), (), ())
"""Of a partition without a PL; and where programs are taken as there."""


def follows_another(trace: Trace) -> list[bool]:
    """Of each solve whether the one before is of another pattern; before the first is the last."""
    order = [solve.pattern for solve in trace.solves]
    return [pattern != order[k - 1] for k, pattern in enumerate(order)]


def changes_of(trace: Trace) -> tuple[int, ...]:
    """Of each pattern its solves that follow one of another pattern."""
    found = Counter(
        solve.pattern for solve, changed in zip(trace.solves, follows_another(trace), strict=True) if changed
    )
    return tuple(found[pattern] for pattern in range(len(trace.patterns)))


def program_of(
    trace: Trace, partition: Partition, lines: int, line_bits: int, *, compressed: bool
) -> Program:
    """A program whose microcode has `lines` of `line_bits` bits."""
    pieces = -(-line_bits // (8 * _REGISTER_BYTES))
    stride = _REGISTER_BYTES << (pieces - 1).bit_length()
    words = _REGISTER_BYTES * TEMPLATES * compressed + WORD_BYTES[trace.datapath] * LITERALS
    joined = sum(SEPARATOR in name for name in streams_of(trace, partition))
    rows = 1 + len(trace.patterns[0].stages) + joined
    instructions = 0
    if partition.control == "pl" and trace.method is not None:
        code = control_program(trace.method, joined=partition.streams == "iteration")
        instructions = len(code.instructions)
    registers = 1 + ROW_WRITES * rows + INSTRUCTION_WRITES * instructions
    return Program(lines * stride, words, registers)


def microcode_picoseconds(platform: Platform, size_bytes: int) -> int:
    """Microcode of `size_bytes` by one DMA transfer at the slower of the link and the engine's slave; 0 without any.

    It lies in memory since the start: no cache is cleaned.
    """
    if not size_bytes:
        return 0
    clock_mhz = platform.pl.clock_mhz.value
    by_slave = picoseconds_of_ns(size_bytes * 1000.0 / (platform.pl.load_bytes_per_cycle.value * clock_mhz))
    return max(link.dma(platform.link, clock_mhz, size_bytes, "pl"), by_slave)


def tables_picoseconds(platform: Platform, program: Program) -> int:
    """Templates and literals by single stores, tables by register writes."""
    each = link.register_write(platform.link, platform.pl.clock_mhz.value)
    return (program.word_stores + program.register_writes) * each


def boot_picoseconds(platform: Platform, programs: Programs) -> int:
    """What is written once a boot: microcode that stays, and the tables of one program where there is but one."""
    first = programs.each[0] if len(programs.each) == 1 else None
    tables = tables_picoseconds(platform, first) if first else 0
    return microcode_picoseconds(platform, programs.boot_bytes) + tables


def plan_picoseconds(platform: Platform, programs: Programs) -> int:
    """What a plan's changes of the pattern take together; the run's time has them, one before each such solve."""
    return sum(
        count
        * (
            microcode_picoseconds(platform, programs.written(pattern))
            + tables_picoseconds(platform, programs.each[pattern])
        )
        for pattern, count in enumerate(programs.changes)
    )
