"""Exact cycles of stages from the schedules of their operation streams, in place of the estimate.

A schedule is asked for by (pattern, stage, engine) and answers with its cycles by cause, as the scheduler names
them; two causes of it may be one here. docs/pl-machine.md is the engine.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, NamedTuple

from hw_model.errors import HwModelError
from hw_model.vocabulary import PL_CAUSES, Datapath, PlCause

from .stage_cycles import Microcode, PlCycles, StageCycles

if TYPE_CHECKING:
    from hw_model.platform.platform import Platform

    from .trace import Trace

CAUSE_OF: dict[str, PlCause] = {
    "issue": "issue", "dependency": "dependency", "read_port": "bank", "write_port": "write_port",
    "result": "write_port", "divider": "divider", "fetch": "fetch", "startup": "drain", "drain": "drain",
    "finish": "drain",
}  # fmt: skip
"""The scheduler's causes → the model's: a taken result register counts as a write port, the ends of a segment as drain."""


class Engine(NamedTuple):
    """What a schedule depends on, beside the operations: the configuration of the PL engine."""

    lanes: int
    dividers: int
    banks: int
    datapath: Datapath
    compressed: bool
    """Whether its microcode is: a schedule for few bits, and cycles in which the decoder waits for a line."""
    streams: tuple[str, ...] = ()
    """Its program's streams, by name; (): the six modules stage by stage."""
    clusters: int = 1
    interleaved: int = 1
    """Problems of the pattern that every segment works on."""
    streamed: bool = False
    """Whether cycles of microcode from memory are asked for."""
    exact_depth: bool = False
    """Whether its banks have no more rows than the schedules of all patterns need."""


@dataclass(frozen=True, slots=True)
class Schedule:
    """One segment: cycles by the scheduler's causes, the L0 bound with its bottleneck, its microcode, and the words of storage
    that the whole program needs."""

    causes: Mapping[str, int]
    lower_bound: int
    bottleneck: str
    microcode: Microcode
    storage_words: int | None = None


def engine_of(platform: Platform, datapath: Datapath) -> Engine:
    """The engine of a platform. Raises HwModelError when its `pl.latency_preset` is not the RTL's, which has no schedule."""
    pl = platform.pl
    if pl.latency_preset != "orbsoc_rtl":
        raise HwModelError(
            f"`pl.latency_preset` = {pl.latency_preset!r}: schedules are made with the latencies of 'orbsoc_rtl' only;"
            " ask for --estimate, or set pl.latency_preset to orbsoc_rtl"
        )
    compressed = pl.microcode_format.value == "compressed"
    units = (pl.lanes.value, pl.dividers.value, pl.banks.value)
    streamed = compressed and pl.microcode_memory.value.startswith("streamed")
    return Engine(
        *units,
        datapath,
        compressed,
        clusters=pl.clusters.value,
        interleaved=pl.interleaved.value,
        streamed=streamed,
        exact_depth=pl.storage_depth.value == "exact",
    )


def scheduled(source: Callable[[int, str, Engine], Schedule]) -> StageCycles:
    """Cycles from `source`, each schedule asked for once.

    Raises HwModelError for a platform that has no schedules (`engine_of`), and for a cause that is not known.
    """

    return Scheduled(cache(lambda *key: _translated(source(*key), key[1])))


@dataclass(frozen=True, slots=True)
class Scheduled:
    """Cycles from schedules: a `StageCycles` of one program's segments."""

    known: Callable[[int, str, Engine], PlCycles]
    streams: tuple[str, ...] = ()

    def __call__(self, trace: Trace, platform: Platform, pattern: int, stage: str) -> PlCycles:
        """Cycles of one run of a segment."""
        engine = engine_of(platform, trace.datapath)
        return self.known(pattern, stage, engine._replace(streams=self.streams))

    def of_program(self, streams: tuple[str, ...]) -> Scheduled:
        """The same, of the program with these streams."""
        return Scheduled(self.known, streams)


def _translated(found: Schedule, stage: str) -> PlCycles:
    causes: dict[PlCause, int] = dict.fromkeys(PL_CAUSES, 0)
    for name, cycles in found.causes.items():
        if name not in CAUSE_OF:
            raise HwModelError(
                f"schedule of {stage!r}: cause {name!r} is not known; allowed: {', '.join(CAUSE_OF)}"
            )
        if cycles < 0:
            raise HwModelError(f"schedule of {stage!r}: {name} = {cycles} cycles: must be 0 or more")
        causes[CAUSE_OF[name]] += cycles
    result = PlCycles(
        causes, found.lower_bound, found.bottleneck, "schedule", found.microcode, found.storage_words
    )
    if result.cycles < found.lower_bound:
        raise HwModelError(
            f"schedule of {stage!r}: {result.cycles} cycles are fewer than the bound {found.lower_bound} allows"
        )
    return result
