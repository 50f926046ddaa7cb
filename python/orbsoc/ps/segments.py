"""The method as the PS and the operation control both know it: step lists and numbered segments.

Both come from the tables of the Rust core, `orbsoc._core`; nothing of the algorithm is written here.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from .program import ControlProgram
from .registers import Module

Step = tuple[str, ...]
"""`(stage,)`, or `(stage, until)`: run `stage` as long as `until` returns REPEAT."""

PROBLEM_DATA = "problem data"
"""Name of segment 0: what the outer loop loads before the first stage."""

REWRITTEN = ("parameters", "control", "verdict", "best", "farkas", "ray")
"""Buffers that the PS writes anew before a restart: parameters, limits, and what is kept from better to best."""

OUTCOME = ("control", "verdict")
"""Buffers in which an attempt leaves how it has ended, where the PL decides by itself."""


class StageInfo(Protocol):
    """One row of the dataflow table: the module's name, and buffer names."""

    @property
    def module(self) -> str: ...
    @property
    def reads(self) -> Sequence[str]: ...
    @property
    def writes(self) -> Sequence[str]: ...
    @property
    def stales(self) -> Sequence[str]: ...
    @property
    def flag(self) -> tuple[str, str] | None: ...


@dataclass(frozen=True, slots=True)
class Segment:
    """A stage as the registers know it; `reads`, `writes` and `stales` are bit masks over the buffers.

    A buffer both read and written is updated in place. One both written and made stale is left unfinished.
    """

    number: int
    stage: str
    module: Module
    reads: int
    writes: int
    stales: int

    def unreadable(self, valid: int, written: int) -> int:
        """The buffers that this stage would read and must not: neither valid, nor updated from an older content."""
        return self.reads & ~(valid | self.writes & written)

    def valid_after(self, valid: int) -> int:
        """The data-valid flags when the stage has ended."""
        return (valid | self.writes) & ~self.stales


@dataclass(frozen=True, slots=True)
class Method:
    """Step lists, outcomes and segments of the interior-point method, read once from the core."""

    startup: tuple[Step, ...]
    warm_startup: tuple[Step, ...]
    iteration: tuple[Step, ...]
    closing: tuple[Step, ...]
    repeat: int
    done: int
    buffers: tuple[str, ...]
    segments: tuple[Segment, ...]
    """In order of their numbers; segment 0 is the problem data."""
    flags: Mapping[str, tuple[str, str]]
    """Of each stage that decides: "repeat" or "stop", and the buffer whose first word is its flag."""

    @classmethod
    def from_core(cls, core: Any, *, resident: bool = False) -> Method:
        """The method of the extension module `orbsoc._core`; `resident`: with the module `statistics` on the PL, too."""
        return cls.from_tables(
            startup=core.startup(),
            warm_startup=core.warm_startup(),
            iteration=core.iteration(),
            closing=core.closing(),
            stages=core.stages(),
            repeat=core.REPEAT,
            done=core.DONE,
            resident=resident,
        )

    @classmethod
    def from_tables(
        cls,
        *,
        startup: Iterable[Sequence[str]],
        iteration: Iterable[Sequence[str]],
        closing: Iterable[Sequence[str]] = (),
        warm_startup: Iterable[Sequence[str]] = (),
        stages: Mapping[str, StageInfo],
        repeat: int,
        done: int,
        resident: bool = False,
    ) -> Method:
        """Number the stages and buffers of a dataflow table, in its order.

        Raises ValueError if a list names a stage that the table lacks, or a stage an unknown module.
        """
        lists = (startup, warm_startup, iteration, closing)
        first, warm, repeated, last = (tuple(map(tuple, steps)) for steps in lists)
        unknown = [name for step in (*first, *warm, *repeated, *last) for name in step if name not in stages]
        if unknown:
            raise ValueError(f"stage {unknown[0]!r} is in a step list, but not in the dataflow table")
        buffers = tuple(dict.fromkeys(b for info in stages.values() for b in _touched(info)))
        bit = {name: 1 << position for position, name in enumerate(buffers)}

        def mask(names: Iterable[str]) -> int:
            return sum(bit[name] for name in set(names))

        loaded = mask(
            _supplied(first, [[*begin, *repeated, *last] for begin in (first, warm) if begin], stages)
        )
        segments = [Segment(0, PROBLEM_DATA, Module.PS, reads=0, writes=loaded, stales=0)]
        for number, (stage, info) in enumerate(stages.items(), start=1):
            module = _module(stage, info.module)
            if module is Module.STATISTICS and not resident:
                module = Module.PS
            masks = (mask(info.reads), mask(info.writes), mask(info.stales))
            segments.append(Segment(number, stage, module, *masks))
        flags = {stage: info.flag for stage, info in stages.items() if info.flag is not None}
        return cls(first, warm, repeated, last, repeat, done, buffers, tuple(segments), flags)

    def stream(self, number: int, stages: Sequence[str]) -> Segment:
        """Stages that run as one segment: what they read before they write it, and what they leave."""
        by_stage = {segment.stage: segment for segment in self.segments}
        reads = writes = stales = 0
        for segment in (by_stage[stage] for stage in stages):
            reads |= segment.reads & ~writes
            writes |= segment.writes
            stales = stales & ~segment.writes | segment.stales
        return Segment(number, "_".join(stages), by_stage[stages[0]].module, reads, writes, stales)

    def numbered(self, program: ControlProgram) -> dict[tuple[str, ...], Segment]:
        """The segments of a control program: stages under their own numbers, streams of several from the next on."""
        found: dict[tuple[str, ...], Segment] = {(segment.stage,): segment for segment in self.segments}
        for stages in (each.stream for each in program.instructions if each.op == "run"):
            if stages not in found:
                found[stages] = self.stream(len(found), stages)
        return found

    @property
    def rewritten(self) -> int:
        """What the PS writes anew before a restart."""
        return self.mask(REWRITTEN)

    def mask(self, names: Iterable[str]) -> int:
        """The bit mask of some buffers."""
        return sum(1 << self.buffers.index(name) for name in set(names) & set(self.buffers))

    def attempt(self, *, warm: bool) -> tuple[int, int]:
        """The buffers that an attempt reads before it writes them, and those that it may write."""
        needed = written = 0
        segments = {segment.stage: segment for segment in self.segments}
        for step in (*(self.warm_startup if warm else self.startup), *self.iteration, *self.closing):
            for stage in reversed(step):
                needed |= segments[stage].reads & ~written
                written |= segments[stage].writes
        return needed, written

    def names(self, mask: int) -> list[str]:
        """The buffers of a bit mask."""
        return [name for position, name in enumerate(self.buffers) if mask >> position & 1]


def _touched(info: StageInfo) -> tuple[str, ...]:
    return (*info.reads, *info.writes, *info.stales)


def _module(stage: str, name: str) -> Module:
    try:
        return Module[name.upper()]
    except KeyError:
        known = ", ".join(module.name.lower() for module in Module)
        raise ValueError(f"stage {stage!r} belongs to module {name!r}; known are {known}") from None


def _supplied(
    startup: Iterable[Step], attempts: Iterable[Iterable[Step]], stages: Mapping[str, StageInfo]
) -> set[str]:
    """Buffers that hold the problem before the first stage: what no stage writes, what the start-up reads before any stage
    of it wrote, and what the first stage of an attempt that writes it updates: what is kept until something better comes.
    """
    written: set[str] = {name for info in stages.values() for name in info.writes}
    supplied = {name for info in stages.values() for name in info.reads} - written
    produced: set[str] = set()
    for name in _in_order(startup):
        supplied |= set(stages[name].reads) - produced
        produced |= set(stages[name].writes)
    for steps in attempts:
        produced = set()
        for name in _in_order(steps):
            supplied |= set(stages[name].reads) & set(stages[name].writes) - produced
            produced |= set(stages[name].writes)
    return supplied


def _in_order(steps: Iterable[Step]) -> Iterator[str]:
    for stage, *until in steps:
        yield from (*until, stage)
