"""Where the cycles of a stage on the PL come from: the interface through which exact schedules replace the estimate."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, TypeVar

from hw_model.errors import HwModelError
from hw_model.vocabulary import PlCause

from . import pl

if TYPE_CHECKING:
    from hw_model.platform.platform import Platform

    from .trace import Trace

Origin = Literal["estimate", "schedule"]


class Memory(NamedTuple):
    """What streamed microcode comes from: ports with beats of `beat_bits`; a burst comes `latency` cycles of the PL after its
    address, and `beats` beats in `per` cycles."""

    ports: int
    beat_bits: int
    latency: int
    beats: int
    per: int


@dataclass(frozen=True, slots=True)
class Microcode:
    """What a segment's microcode takes: `words`, one a cycle, their bits when flat, and the bits that are stored.

    `streamed`: the segment's cycles where its lines come from memory; None: its items are not known.
    """

    words: int
    flat_bits: int
    bits: int
    streamed: Callable[[Memory], int] | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True, slots=True)
class PlCycles:
    """One run of a stage on the PL engine: cycles by cause, which add up to the whole, and the L0 bound below it.

    `origin`: "schedule" is exact, equal to the RTL cycle for cycle; "estimate" is L1 as pl.py describes it.
    `microcode`, and `storage_words` that hold the buffers and temporaries of all stages: of a schedule; an estimate knows none.
    """

    causes: dict[PlCause, int]
    lower_bound: int
    bottleneck: str
    origin: Origin
    microcode: Microcode | None = None
    storage_words: int | None = None

    @property
    def cycles(self) -> int:
        """Sum of the causes."""
        return sum(self.causes.values())


StageCycles = Callable[["Trace", "Platform", int, str], PlCycles]
"""(trace, platform, pattern, stage or stream) → cycles of one run of it on that engine."""


NO_GROUPS_ESTIMATED = "the estimate knows no interleaved problems; ask for schedules (--exact)"


Source = TypeVar("Source", bound=Callable[..., Any])


def of_program(source: Source, streams: tuple[str, ...]) -> Source:
    """`source` for the segments of the program with these streams; (): the six modules stage by stage.

    A source whose answers depend on the program has a method of this name; an estimate knows of no program.
    """
    chosen: Callable[[tuple[str, ...]], Source] | None = getattr(source, "of_program", None)
    return source if chosen is None else chosen(streams)


def estimated(trace: Trace, platform: Platform, pattern: int, stage: str) -> PlCycles:
    """The L1 estimate: from operation counts and the longest chain, without banks, ports and fetch.

    Raises HwModelError where problems are interleaved.
    """
    copies = platform.pl.interleaved.value
    if copies > 1:
        raise HwModelError(f"`pl.interleaved` = {copies}: {NO_GROUPS_ESTIMATED}")
    found = pl.estimate(trace.patterns[pattern].stage(stage), platform.pl, trace.datapath, stage)
    causes: dict[PlCause, int] = {
        "issue": found.issue, "dependency": found.dependency, "divider": found.divider, "drain": found.drain,
    }  # fmt: skip
    return PlCycles(causes, found.bounds.cycles, found.bounds.bottleneck, "estimate")
