"""The pictures of many flights: computation over mission time, the ends with and without re-planning, what a slow computer costs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from orbsoc.guidance.figure_style import BLUE, GREY, ORANGE, STYLE, VERMILION, panels, write_png
from orbsoc.guidance.mission import FigureFile

from .many import WITHOUT, DelayRow, Study, by_mission_time, quantiles


def draw_many(
    study: Study,
    found: Mapping[str, NDArray[Any]],
    delays: Sequence[DelayRow],
    shown: Sequence[tuple[str, str]],
    folder: Path,
) -> tuple[FigureFile, ...]:
    """computation.png, dispersion.png and deadline.png; `shown` are two figures of a flight's end with their labels."""
    from matplotlib import rc_context

    with rc_context(STYLE):
        return (
            _computation(study, found, folder),
            _dispersion(found, shown, folder),
            _deadline(delays, folder),
        )


def _computation(study: Study, found: Mapping[str, NDArray[Any]], folder: Path) -> FigureFile:
    figure, (panel,) = panels((8.0, 4.0))
    rows = [(at, quantiles(took)) for at, took in by_mission_time(found)]
    at = [time for time, _ in rows]
    for name, colour, marker in (("p50", BLUE, "o"), ("p99", ORANGE, "s"), ("worst", VERMILION, "^")):
        panel.plot(at, [row[name] for _, row in rows], color=colour, marker=marker, ms=4.0, label=name)
    if study.timing.window_s is not None:
        panel.axhline(1e3 * study.timing.window_s, color="#222222", ls="--", lw=1.2, label="window")
    panel.set_yscale("log")
    panel.set_xlabel("mission time at which the computation began (s)")
    panel.set_ylabel("computation (ms, modelled)")
    panel.legend()
    caption = f"Modelled time of each re-plan of {study.runs} flights on {study.device}, partition {study.partition}, by when it began."
    return write_png(figure, folder, "computation.png", caption)


def _dispersion(
    found: Mapping[str, NDArray[Any]], shown: Sequence[tuple[str, str]], folder: Path
) -> FigureFile:
    figure, (panel,) = panels((6.5, 5.5))
    (x, x_label), (y, y_label) = shown
    panel.plot(found[WITHOUT + x], found[WITHOUT + y], ".", color=GREY, ms=3.0, label="without re-planning")
    panel.plot(found[x], found[y], ".", color=BLUE, ms=3.0, label="with")
    panel.set_xlabel(x_label)
    panel.set_ylabel(y_label)
    panel.legend()
    caption = "The end of every flight, beside the end of the same vehicle with the same errors that flew its first plan."
    return write_png(figure, folder, "dispersion.png", caption)


def _deadline(delays: Sequence[DelayRow], folder: Path) -> FigureFile:
    figure, (cost, ends) = panels((7.0, 5.0), (1.0, 1.0))
    took = np.array([max(each.computed_ms, 1e-2) for each in delays])
    cost.plot(took, [each.more_spent for each in delays], color=BLUE, marker="o")
    cost.set_ylabel(f"more {delays[0].spent}")
    ends.plot(took, [100.0 * each.on_target for each in delays], color=VERMILION, marker="o")
    ends.set_ylabel("on target (%)")
    ends.set_ylim(-5.0, 105.0)
    ends.set_xscale("log")
    ends.set_xlabel("median computation of a re-plan (ms, modelled)")
    caption = "The same flights on slower and slower computers, late answers flown late: what they spend beyond that of answers at once, and how many end on target."
    return write_png(figure, folder, "deadline.png", caption)
