"""Cost model: how long each piece of work takes on one platform, cause by cause."""

from __future__ import annotations

import math
from collections import Counter
from copy import copy
from typing import TYPE_CHECKING, NamedTuple

from hw_model.vocabulary import WORD_BYTES, Cause, picoseconds_of_cycles

from . import link, programs, ps
from .control_program import control_cycles, members, streams_of
from .stage_cycles import PlCycles, StageCycles, estimated, of_program
from .stream import with_fetch

if TYPE_CHECKING:
    from hw_model.platform.partition import Partition
    from hw_model.platform.platform import Platform

    from .actions import Work
    from .programs import Programs
    from .trace import Trace


class Part(NamedTuple):
    """Part of a duration with one cause. `cycles` counts the clock of the side that computes, 0 where none does.

    `jitter_picoseconds`: how much longer it takes at most.
    """

    cause: Cause
    picoseconds: int
    cycles: int
    jitter_picoseconds: int
    detail: str
    """What the PS or link is doing: "compute", "launch", "flags", "publish", "copy x to the PL by dma", … """
    shared_cycles: int = 0
    """Of the cycles, those at the end in which all computing cores work, not one alone."""


class Durations:
    """Durations of the work in one trace on one platform, each distinct piece computed once.

    `cycles`: where a stage's cycles on the PL come from.
    """

    def __init__(
        self,
        trace: Trace,
        platform: Platform,
        partition: Partition,
        cycles: StageCycles = estimated,
        loaded: Programs = programs.NONE,
    ) -> None:
        self.trace = trace
        self.platform = platform
        self.loaded = loaded
        """The programs of its patterns; NONE: all are there, and a change takes no time."""
        self._source, self.partition = cycles, partition
        self._cycles = of_program(cycles, streams_of(trace, partition))
        self.cores = ps.computing_cores(platform, uses_pl=partition.uses_pl)
        """Cores that may share a stage."""
        self._known: dict[Work, tuple[Part, ...]] = {}
        self._sums: dict[Work, tuple[int, int]] = {}

    def on(self, platform: Platform) -> Durations:
        """The same on another platform."""
        return Durations(self.trace, platform, self.partition, self._source, self.loaded)

    def with_programs(self, loaded: Programs) -> Durations:
        """The same with other programs; what both know of other work is shared."""
        found = copy(self)
        found.loaded = loaded
        return found

    def parts(self, work: Work) -> tuple[Part, ...]:
        """The parts of `work`, in order; none is empty. Σ picoseconds is its duration."""
        if work.kind == "load":  # the only work that others, with whom `_known` is shared, may know otherwise
            return self._load(work.pattern)
        known = self._known.get(work)
        if known is None:
            known = tuple(part for part in self._parts(work) if part.picoseconds or part.cycles)
            self._known[work] = known
        return known

    def picoseconds(self, work: Work) -> int:
        """How long `work` takes without jitter."""
        return sum(part.picoseconds for part in self.parts(work))

    def jitter_picoseconds(self, work: Work) -> int:
        """How much longer `work` takes at most."""
        return sum(part.jitter_picoseconds for part in self.parts(work))

    def total_picoseconds(self, tally: Counter[Work], *, worst: bool = False) -> int:
        """Makespan of work done one piece after another; with `worst`, every jitter at its bound."""
        sums, total = self._sums, 0
        for work, count in tally.items():
            if work.kind == "load":  # known per program, and not to others that share the rest
                total += count * (self.picoseconds(work) + worst * self.jitter_picoseconds(work))
                continue
            if work not in sums:
                alone = self.picoseconds(work)
                sums[work] = alone, alone + self.jitter_picoseconds(work)
            total += count * sums[work][worst]
        return total

    def pl_cycles(self, work: Work) -> PlCycles:
        """Cycles of a "compute" on the PL, waits for streamed microcode included."""
        found = self._cycles(self.trace, self.platform, work.pattern, work.what)
        return with_fetch(found, self.trace, self.platform, work.pattern, work.what)

    def by_dma(self, work: Work) -> bool:
        """Whether a "copy" is done by DMA, not by a core."""
        return self._copy(work).method == "dma"

    def _parts(self, work: Work) -> list[Part]:
        links, pl_clock_mhz = self.platform.link, self.platform.pl.clock_mhz.value
        runtime = self.platform.runtime
        first = link.first(links) if work.first else 0
        match work.kind:
            case "launch":
                return [self._link(first + link.frame(links, pl_clock_mhz), "launch")]
            case "flags":
                acknowledged = link.acknowledgement(links, pl_clock_mhz)
                return [self._link(self._confirmation(work.pattern) + acknowledged, "flags")]
            case "publish":
                framed = first + link.publication(links, pl_clock_mhz)
                return [self._link(framed + self._confirmation(work.pattern), "publish")]
            case "rest":
                return [self._link(link.status(links, pl_clock_mhz), "rest")]
            case "interrupt":
                picoseconds = link.completion(runtime, links, pl_clock_mhz)
                late = link.completion_jitter(runtime, links, pl_clock_mhz)
                return [Part("interrupt", picoseconds, 0, late, runtime.completion.value)]
            case "copy":
                return self._crossing(work)
            case "control":
                return [self._on_control(work)]
            case "load":
                return list(self._load(work.pattern))
            case "build":
                cycles = ps.build_cycles(self.trace.patterns[work.pattern], self.platform.ps)
                return [self._on_ps(cycles, "build")]
            case "outer":
                return [self._outer(work)]
            case "compute":
                return self._on_pl(work) if work.side == "pl" else [self._stage_on_ps(work)]

    def _load(self, pattern: int) -> tuple[Part, ...]:
        """The program of a pattern that follows another, as far as it is not there."""
        if not self.loaded.each:
            return ()
        size = self.loaded.written(pattern)
        moved = programs.microcode_picoseconds(self.platform, size)
        written = programs.tables_picoseconds(self.platform, self.loaded.each[pattern])
        parts = (self._link(moved, "load microcode by dma"), self._link(written, "write tables"))
        return tuple(part for part in parts if part.picoseconds)

    def _link(self, picoseconds: int, detail: str) -> Part:
        return Part(
            "link",
            picoseconds,
            0,
            _share(picoseconds, self.platform.runtime.link_jitter_fraction.value),
            detail,
        )

    def _copy(self, work: Work) -> link.Copy:
        pl_clock_mhz, line_bytes = self.platform.pl.clock_mhz.value, self.platform.ps.cache_line_bytes.value
        return link.copy(self.platform.link, pl_clock_mhz, self.size_bytes(work), work.side, line_bytes)

    def _crossing(self, work: Work) -> list[Part]:
        """Clean, then move to the PL; move to the PS, then invalidate."""
        copy = self._copy(work)
        words = f"copy {work.what} to the {work.side.upper()} by {copy.method}"
        moved = self._link(copy.picoseconds, words)
        late = _share(copy.cache_picoseconds, self.platform.runtime.ps_jitter_fraction.value)
        kept = Part(
            "cache",
            copy.cache_picoseconds,
            0,
            late,
            f"{'clean' if work.side == 'pl' else 'invalidate'} {work.what}",
        )
        return [kept, moved] if work.side == "pl" else [moved, kept]

    def size_bytes(self, work: Work) -> int:
        """Bytes of the buffer of a "copy"."""
        return self.trace.patterns[work.pattern].buffers[work.what] * WORD_BYTES[self.trace.datapath]

    def _confirmation(self, pattern: int) -> int:
        buffers = len(self.trace.patterns[pattern].buffers)
        return link.confirmation(self.platform.link, self.platform.pl.clock_mhz.value, buffers)

    def _stage_on_ps(self, work: Work) -> Part:
        pattern, datapath = self.trace.patterns[work.pattern], self.trace.ps_datapath or self.trace.datapath
        return self._on_ps(ps.run_cycles(work.what, pattern, self.platform.ps, datapath), "compute")

    def _on_ps(self, one_core_cycles: int, detail: str) -> Part:
        cycles, shared = ps.on_cores(one_core_cycles, self.platform, self.cores)
        [picoseconds] = picoseconds_of_cycles([cycles], self.platform.ps.clock_mhz.value)
        late = _share(picoseconds, self.platform.runtime.ps_jitter_fraction.value)
        return Part("ps", picoseconds, cycles, late, detail, shared)

    def _outer(self, work: Work) -> Part:
        """Counted work of one thread around the solves."""
        assert self.trace.outer_loop is not None  # actions_of has made sure
        cycles = ps.outer_cycles(self.trace.outer_loop.works[int(work.what)], self.platform.ps)
        [picoseconds] = picoseconds_of_cycles([cycles], self.platform.ps.clock_mhz.value)
        late = _share(picoseconds, self.platform.runtime.ps_jitter_fraction.value)
        return Part("ps", picoseconds, cycles, late, "outer loop")

    def _on_control(self, work: Work) -> Part:
        """The operation control, between two segments."""
        assert self.trace.method is not None  # actions_of has made sure
        cycles = control_cycles(members(work.what), self.trace.method)
        [picoseconds] = picoseconds_of_cycles([cycles], self.platform.pl.clock_mhz.value)
        return Part("drain", picoseconds, cycles, 0, "operation control")

    def _on_pl(self, work: Work) -> list[Part]:
        """A segment is a fixed schedule: it has no jitter."""
        causes = self.pl_cycles(work).causes
        picoseconds = picoseconds_of_cycles(list(causes.values()), self.platform.pl.clock_mhz.value)
        return [
            Part(cause, part, cycles, 0, "compute")
            for (cause, cycles), part in zip(causes.items(), picoseconds, strict=True)
        ]


def _share(picoseconds: int, fraction: float) -> int:
    return math.ceil(picoseconds * fraction)
