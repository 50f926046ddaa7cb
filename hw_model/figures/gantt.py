"""A modelled run as a Gantt chart: the whole of it, and one iteration magnified."""

# matplotlib leaves its keyword arguments untyped:
# pyright: reportUnknownMemberType=false

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hw_model.vocabulary import PL_MODULES, count_of

from .drawing import PLACES, blank, finished, legend

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from hw_model.timing.timeline import Segment, Timeline


def _rows(segments: Iterable[Segment]) -> list[str]:
    """The PS, the modules (and what joins several of them, where anything does), link and interrupts."""
    joined = ["joined"] if any(segment.module == "joined" for segment in segments) else []
    return ["PS", *PL_MODULES, *joined, "link", "interrupt"]


def gantt_figure(timeline: Timeline, path: str | Path | None = None) -> Figure:
    """Rows for the PS, each PL module, link and interrupts; above the run, below its longest iteration."""
    figure = blank(10.0, 6.4)
    above, below = figure.subplots(2, 1)
    _draw(above, timeline.segments, 1e9)
    above.set_xlabel("modelled time, ms")
    above.set_title(f"Modelled run: {timeline.partition} on {timeline.platform}", fontsize=10)
    solve, iteration = timeline.longest_iteration()
    part = [s for s in timeline.segments if (s.solve, s.iteration) == (solve, iteration)]
    _draw(below, part, 1e6)
    below.set_xlabel("modelled time, µs")
    below.set_title(f"Its longest iteration: solve {solve}, iteration {iteration}", fontsize=10)
    legend(figure, PLACES)
    return finished(figure, path)


def iterations_figure(timelines: Sequence[Timeline], path: str | Path | None = None) -> Figure:
    """The longest iteration of each timeline, one above the other on one scale."""
    figure = blank(10.0, 3.2 * len(timelines))
    axes = figure.subplots(len(timelines), 1, sharex=True, squeeze=False)[:, 0]
    for place, timeline in zip(axes, timelines, strict=True):
        solve, iteration = timeline.longest_iteration()
        part = [s for s in timeline.segments if (s.solve, s.iteration) == (solve, iteration)]
        _draw(place, part, 1e6)
        launches = sum(s.kind == "launch" for s in part)
        place.set_title(
            f"{timeline.partition} on {timeline.platform}, modelled: its longest iteration (solve {solve}, iteration "
            f"{iteration}), {count_of(launches, 'launch', 'launches')} by the PS",
            fontsize=10,
        )
    axes[-1].set_xlabel("modelled time, µs")
    legend(figure, PLACES)
    return finished(figure, path)


def _draw(axes: Axes, segments: Sequence[Segment], picoseconds: float) -> None:
    origin = min((s.start_picoseconds for s in segments), default=0)
    rows = _rows(segments)
    for place, row in enumerate(rows):
        own = [s for s in segments if _row(s) == row]
        spans: Any = [
            ((s.start_picoseconds - origin) / picoseconds, s.duration_picoseconds / picoseconds) for s in own
        ]
        colour = PLACES.get(row, PLACES["PL"])
        axes.broken_barh(spans, (place - 0.4, 0.8), facecolors=colour, edgecolors=colour, linewidth=0.4)
    axes.set_yticks(range(len(rows)), [name.replace("_", " ") for name in rows], fontsize=8)
    axes.invert_yaxis()
    axes.set_xlim(left=0.0)


def _row(segment: Segment) -> str:
    if segment.side == "pl":
        return segment.module
    return {"ps": "PS", "interrupt": "interrupt"}.get(segment.cause, "link")
