"""A timeline in the Chrome trace-event format, which Perfetto (ui.perfetto.dev) and chrome://tracing read.

Tracks: the PS's cores, each PL module, each cause of PL cycles, the link (DMA and cores), the interrupts. A segment is
one complete event; its arguments say which solve, iteration, stage and cause it belongs to. Times are modelled.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from .vocabulary import PL_CAUSES, PL_MODULES, Datapath

if TYPE_CHECKING:
    from .platform import Platform
    from .timeline import Segment, Timeline

PS, PL, LINK = 1, 2, 3
_PROCESSES = {PS: "PS", PL: "PL", LINK: "link and interrupts"}


def trace_events(timeline: Timeline, platform: Platform, datapath: Datapath = "f64") -> dict[str, Any]:
    """The timeline as a trace-event document: JSON-able, times in microseconds.

    Its metadata echo every parameter of the platform with tag and source.
    """
    tracks = _tracks(platform)
    events: list[dict[str, Any]] = []
    for process, name in _PROCESSES.items():
        events.append(_named("process_name", process, 0, f"{name} (modelled)"))
    for (process, name), thread in tracks.items():
        events.append(_named("thread_name", process, thread, name))
    for segment in timeline.segments:
        for process, track in _places(segment):
            events.append(_event(segment, process, tracks[process, track]))
    return {
        "traceEvents": events,
        "displayTimeUnit": "ns",
        "otherData": {
            "provenance": "modelled, not measured",
            "platform": timeline.platform,
            "partition": timeline.partition,
            "makespan_us": timeline.makespan_picos / 1e6,
            "parameters": {
                row.key: {"value": row.value, "tag": row.tag, "source": row.source}
                for row in platform.assumptions(datapath)
            },
        },
    }


def _tracks(platform: Platform) -> dict[tuple[int, str], int]:
    """Thread number of each track, in the order of display."""
    cores = [f"core {k}" for k in range(platform.runtime.cores_used.value)]
    names = [(PS, core) for core in cores]
    names += [(PL, module) for module in PL_MODULES] + [(PL, f"cycles: {cause}") for cause in PL_CAUSES]
    names += [
        (LINK, name) for name in ("registers and copies by a core", "dma", "cache maintenance", "interrupt")
    ]
    return {name: k + 1 for k, name in enumerate(names)}


def _places(segment: Segment) -> list[tuple[int, str]]:
    """The tracks that show a segment: PL time stands under its module and under its cause."""
    if segment.side == "pl":
        return [(PL, segment.module), (PL, f"cycles: {segment.cause}")]
    if segment.cause == "ps":
        return [(PS, "core 0")]
    if segment.cause == "interrupt":
        return [(LINK, "interrupt")]
    if segment.cause == "cache":
        return [(LINK, "cache maintenance")]
    return [
        (
            LINK,
            "dma"
            if segment.resource == "dma" and segment.detail.endswith("dma")
            else "registers and copies by a core",
        )
    ]


def _event(segment: Segment, process: int, thread: int) -> dict[str, Any]:
    computing = segment.kind in ("compute", "build")
    return {
        "ph": "X",
        "name": segment.stage if computing else f"{segment.detail}: {segment.stage}",
        "cat": segment.cause,
        "ts": segment.start_picos / 1e6,
        "dur": segment.duration_picos / 1e6,
        "pid": process,
        "tid": thread,
        "args": {
            "module": segment.module, "solve": segment.solve, "iteration": segment.iteration,
            "event": segment.event, "cause": segment.cause, "cycles": segment.cycles, "detail": segment.detail,
            "critical": segment.critical,
        },
    }  # fmt: skip


def _named(what: str, process: int, thread: int, name: str) -> dict[str, Any]:
    return {"ph": "M", "name": what, "pid": process, "tid": thread, "args": {"name": name}}
