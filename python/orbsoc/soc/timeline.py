"""A run on the simulated computer as a timeline of both halves, for Perfetto, beside waveforms of its wires."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from orbsoc import _core
from orbsoc.hw.emulation import resident_program
from orbsoc.hw.schedules import Engine
from orbsoc.hw.workload import Posed
from orbsoc.ps.segments import Method

from .errors import SocError
from .machine import Machine, Waveform
from .program import compiled
from .runs import FORM, cache_folder, lines_of, stage_names

CORE, ENGINE, LINK = 1, 2, 4
"""Processes, by the numbers of hw_model.report.perfetto."""
_TRACKS = {CORE: "core (counted)", ENGINE: "engine (counted)", LINK: "link (counted)"}
_LINK = {"l": "load", "p": "put", "g": "get", "b": "publish"}


@dataclass(frozen=True, slots=True)
class Span:
    """What ran where, in clocks of the core since power on."""

    process: int
    name: str
    begin: int
    end: int


def traced(
    posed: Posed,
    rtl: Path,
    *,
    partition: str | None,
    engine: Engine,
    ratio: float,
    latency: int,
    limit_clocks: int | None = None,
    waveform: Waveform,
    tell: Callable[[str], None],
) -> dict[str, Any]:
    """One solve from cold, its waveforms written; its trace-event document. The program notes each part, so its clocks are a few
    more than those that `counted` gives. Raises SocError, and what exporting raises."""
    tell("compile the program")
    program = compiled(
        posed,
        rtl,
        cache_folder(),
        partition=partition,
        engine=engine,
        form=FORM,
        limit_clocks=limit_clocks,
        warm=False,
        events=True,
    )
    tell("build the computer with waveforms, minutes the first time")
    machine = Machine.built(rtl, program.engine, FORM, program.code_lines, traced=True)
    lines = lines_of(machine.run(program.image, ratio=ratio, latency=latency, waveform=waveform), tell)
    buffers = tuple(buffer_words(posed))
    return document(spans(lines, stage_names(), segment_names(), Machine.reset_clocks(ratio), buffers))


def buffer_words(posed: Posed) -> dict[str, int]:
    """Words of the solver's buffers, in the order of their numbers in the flight code."""
    return dict(_core.ExactEngine(*posed, 64).buffer_words())


def segment_names() -> dict[int, str]:
    """Of the engine's segments by their numbers: stages, then streams of several under resident control."""
    numbered = Method.from_core(_core, resident=True).numbered(resident_program())
    return {segment.number: " + ".join(stages) for stages, segment in numbered.items() if segment.number}


def spans(
    lines: Iterable[str],
    stages: tuple[str, ...],
    segments: Mapping[int, str],
    reset_clocks: int,
    buffers: tuple[str, ...],
) -> Iterator[Span]:
    """Lines "event KIND NUMBER BEGIN END" of the program (rtl/soc/program/counters.h), whose clock starts after the reset, and lines
    "pl CLOCK SEGMENT" of the harness, SEGMENT -1 where the engine comes to rest."""
    running, since = -1, 0
    for line in lines:
        kind, *fields = line.split()
        if kind == "pl":
            clock, segment = map(int, fields)
            if running in segments:
                yield Span(ENGINE, segments[running], since, clock)
            running, since = segment, clock
        elif kind == "event":
            what, number, *ends = fields
            begin, end = (reset_clocks + int(clock) for clock in ends)
            if what == "s":
                yield Span(CORE, stages[int(number)], begin, end)
            elif what == "w":
                name = stages[int(number) - 1] if int(number) <= len(stages) else "attempt"
                yield Span(CORE, f"waits for the PL: {name}", begin, end)
            else:
                moved = f" {buffers[int(number)]}" if what in "pg" else ""
                yield Span(LINK, _LINK[what] + moved, begin, end)


def document(found: Iterable[Span]) -> dict[str, Any]:
    """Trace events as hw_model.report.perfetto writes them. A nanosecond stands for a clock of the core. Raises SocError without spans."""
    ordered = sorted(found, key=lambda span: (span.begin, -span.end))
    if not ordered:
        raise SocError("the program noted no events")
    events: list[dict[str, Any]] = []
    for process, name in _TRACKS.items():
        for what in ("process_name", "thread_name"):
            events.append({"ph": "M", "name": what, "pid": process, "tid": 1, "args": {"name": name}})
    for span in ordered:
        events.append(
            {
                "ph": "X",
                "name": span.name,
                "cat": _TRACKS[span.process],
                "pid": span.process,
                "tid": 1,
                "ts": span.begin / 1000,
                "dur": (span.end - span.begin) / 1000,
                "args": {"core_clocks": span.end - span.begin},
            }
        )
    return {
        "traceEvents": events,
        "displayTimeUnit": "ns",
        "otherData": {"provenance": "counted", "unit": "a nanosecond is a clock of the core"},
    }
