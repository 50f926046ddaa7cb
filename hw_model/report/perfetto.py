"""A timeline in the Chrome trace-event format, which Perfetto (ui.perfetto.dev) and chrome://tracing read.

Tracks: each core of the PS; each PL module and each cause of its cycles; each lane and divider with what it executes,
where there are schedules; the link and the interrupts. A segment is one complete event; its arguments say which solve,
iteration, stage and cause it belongs to. Times are modelled, on a grid of whole nanoseconds, which is what viewers
keep: on one track no event overlaps another.
"""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

from hw_model.timing.control_program import streams_of
from hw_model.timing.stage_cycles import StageCycles, estimated, of_program
from hw_model.vocabulary import PL_CAUSES, PL_MODULES

from .assumptions import assumptions
from .unit_tracks import unit_arguments, unit_events
from .usage import TIMELINE_USAGE

if TYPE_CHECKING:
    from hw_model.platform.partition import Partition
    from hw_model.platform.platform import Platform
    from hw_model.timing.timeline import Segment, Timeline
    from hw_model.timing.trace import Trace
    from hw_model.timing.unit_schedules import UnitSchedules

PS, PL, UNITS, LINK = 1, 2, 3, 4
_PROCESSES = {PS: "PS cores", PL: "PL modules", UNITS: "PL units", LINK: "link and interrupts"}
_BY_CORE = "registers and copies by a core"

Track = tuple[int, str]


def trace_events(
    timeline: Timeline,
    trace: Trace,
    platform: Platform,
    partition: Partition,
    cycles: StageCycles = estimated,
    units: UnitSchedules | None = None,
) -> dict[str, Any]:
    """The timeline as a trace-event document: JSON-able, times in microseconds.

    `units`: the schedules of `cycles`; without them there are no tracks of units. The metadata echo every parameter of
    the platform with tag and source.
    """
    joined = any(segment.module == "joined" for segment in timeline.segments)
    tracks = _tracks(platform, joined=joined, with_units=units is not None and partition.uses_pl)
    events: list[dict[str, Any]] = []
    for process in dict.fromkeys(process for process, _ in tracks):
        events.append(_metadata("process_name", process, 0, name=f"{_PROCESSES[process]} (modelled)"))
        events.append(_metadata("process_sort_index", process, 0, sort_index=process))
    for (process, name), thread in tracks.items():
        events.append(_metadata("thread_name", process, thread, name=name))
    serial = platform.runtime.schedule.value == "serial"
    period_picoseconds = 1e6 / platform.ps.clock_mhz.value
    for segment in timeline.segments:
        for process, track in _places(segment, platform, serial):
            events.append(_event(segment, process, tracks[process, track]))
        if segment.shared_cycles:  # the other cores join for the last part
            start = segment.end_picoseconds - round(segment.shared_cycles * period_picoseconds)
            events += [
                _event(segment, PS, tracks[PS, f"core {core}"], start) for core in range(1, timeline.cores)
            ]
    if units is not None and partition.uses_pl:
        names = _unit_names(platform)
        of_units = of_program(units, streams_of(trace, partition))
        for item in unit_events(timeline, trace, platform, of_units):
            place = {
                "ph": "X",
                "name": item.name,
                "cat": item.run.stage,
                **_span(item.start_picoseconds, item.end_picoseconds),
            }
            events.append(
                place | {"pid": UNITS, "tid": tracks[UNITS, names[item.unit]], "args": unit_arguments(item)}
            )
    usage = TIMELINE_USAGE.of(trace, partition, platform, cycles)
    return {
        "traceEvents": events,
        "displayTimeUnit": "ns",
        "otherData": {
            "provenance": "modelled, not measured",
            "pl_cycles": ("exact schedules" if usage.scheduled else "estimated")
            if partition.uses_pl
            else "none",
            "platform": timeline.platform,
            "partition": timeline.partition,
            "makespan_us": timeline.makespan_picoseconds / 1e6,
            "unit_tracks": units is not None and partition.uses_pl,
            "parameters": {
                row.key: {"value": row.value, "tag": row.tag, "source": row.source, "used": row.used}
                for row in assumptions(platform, usage)
            },
        },
    }


def as_text(document: dict[str, Any]) -> str:
    """The document as a file holds it: an event a line."""
    rest = {key: value for key, value in document.items() if key != "traceEvents"}
    head = json.dumps(rest, allow_nan=False, ensure_ascii=False)
    lines = (
        json.dumps(event, allow_nan=False, ensure_ascii=False, separators=(",", ":"))
        for event in document["traceEvents"]
    )
    return head[:-1] + ', "traceEvents": [\n' + ",\n".join(lines) + "\n]}\n"


def _tracks(platform: Platform, *, joined: bool, with_units: bool) -> dict[Track, int]:
    """Thread number of each track, in the order of display."""
    names: list[Track] = [(PS, f"core {k}") for k in range(platform.runtime.cores_used.value)]
    names += [(PL, module) for module in (*PL_MODULES, *(["joined"] if joined else []))]
    names += [(PL, f"cycles: {cause} (added up within each segment)") for cause in PL_CAUSES]
    names += [(UNITS, name) for name in _unit_names(platform)] if with_units else []
    names += [(LINK, name) for name in (_BY_CORE, "dma", "cache maintenance", "interrupt")]
    return {name: k + 1 for k, name in enumerate(names)}


def _unit_names(platform: Platform) -> list[str]:
    lanes, dividers = platform.pl.lanes.value, platform.pl.dividers.value
    return [f"lane {k}" for k in range(lanes)] + [f"divider {k}" for k in range(dividers)]


def _places(segment: Segment, platform: Platform, serial: bool) -> list[Track]:
    """The tracks that show a segment: PL time stands under its module and under its cause, the link's also under the
    core that is kept busy by it: core 0, or when work overlaps the one that does nothing else."""
    if segment.side == "pl":
        return [(PL, segment.module), (PL, f"cycles: {segment.cause} (added up within each segment)")]
    if segment.cause == "ps":
        return [(PS, "core 0")]
    controlling = (PS, f"core {0 if serial else platform.runtime.cores_used.value - 1}")
    if segment.cause == "interrupt":
        return [(LINK, "interrupt"), controlling]
    if segment.cause == "cache":  # when work overlaps, it is counted as the DMA engine's
        return [(LINK, "cache maintenance"), *([controlling] if serial else [])]
    if segment.detail.endswith("by dma"):
        return [(LINK, "dma")]
    return [(LINK, _BY_CORE), controlling]


def _event(
    segment: Segment, process: int, thread: int, start_picoseconds: int | None = None
) -> dict[str, Any]:
    computing = segment.kind in ("compute", "build", "outer")
    start = segment.start_picoseconds if start_picoseconds is None else start_picoseconds
    return {
        "ph": "X",
        "name": segment.stage if computing else f"{segment.detail}: {segment.stage}",
        "cat": segment.cause,
        **_span(start, segment.end_picoseconds),
        "pid": process,
        "tid": thread,
        "args": {
            "module": segment.module, "solve": segment.solve, "iteration": segment.iteration,
            "event": segment.event, "cause": segment.cause, "cycles": segment.cycles, "detail": segment.detail,
            "critical": segment.critical,
        },
    }  # fmt: skip


def _span(start_picoseconds: int, end_picoseconds: int) -> dict[str, float]:
    """Start and duration in microseconds; both ends are rounded to nanoseconds, so that neighbours do not overlap."""
    start, end = ((picoseconds + 500) // 1000 for picoseconds in (start_picoseconds, end_picoseconds))
    return {"ts": start / 1000, "dur": (end - start) / 1000}


def _metadata(what: str, process: int, thread: int, **arguments: object) -> dict[str, Any]:
    return {"ph": "M", "name": what, "pid": process, "tid": thread, "args": arguments}
