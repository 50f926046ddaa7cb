"""The method as the PS and the operation control both know it: step lists and numbered segments.

Both come from the tables of the Rust core, `orbsoc._core`; nothing of the algorithm is written here.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from .registers import Module

Step = tuple[str, ...]
"""`(stage,)`, or `(stage, until)`: run `stage` as long as `until` returns REPEAT."""

PROBLEM_DATA = "problem data"
"""Name of segment 0: what the outer loop loads before the first stage."""

PARAMETERS = "parameters"
"""Buffer that the PS writes anew before a restart."""


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

    @classmethod
    def from_core(cls, core: Any) -> Method:
        """The method of the extension module `orbsoc._core`."""
        return cls.from_tables(
            startup=core.startup(),
            warm_startup=core.warm_startup(),
            iteration=core.iteration(),
            closing=core.closing(),
            stages=core.stages(),
            repeat=core.REPEAT,
            done=core.DONE,
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

        loaded = mask(_supplied(first, stages))
        segments = [Segment(0, PROBLEM_DATA, Module.PS, reads=0, writes=loaded, stales=0)]
        for number, (stage, info) in enumerate(stages.items(), start=1):
            module = _module(stage, info.module)
            masks = (mask(info.reads), mask(info.writes), mask(info.stales))
            segments.append(Segment(number, stage, module, *masks))
        return cls(first, warm, repeated, last, repeat, done, buffers, tuple(segments))

    @property
    def rewritten(self) -> int:
        """What the PS writes anew before a restart."""
        return sum(1 << position for position, name in enumerate(self.buffers) if name == PARAMETERS)

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


def _supplied(startup: Iterable[Step], stages: Mapping[str, StageInfo]) -> set[str]:
    """Buffers that hold the problem before the first stage: what no stage writes, and what the start-up
    reads before any stage of it wrote."""
    written: set[str] = {name for info in stages.values() for name in info.writes}
    supplied = {name for info in stages.values() for name in info.reads} - written
    produced: set[str] = set()
    for stage, *until in startup:
        for name in (*until, stage):
            supplied |= set(stages[name].reads) - produced
            produced |= set(stages[name].writes)
    return supplied
