"""The picture of one flight: when the computer computed, what it answered, and what was flown."""

from __future__ import annotations

from pathlib import Path

from orbsoc.guidance.figure_style import BLUE, GREY, ORANGE, STYLE, VERMILION, panels, write_png
from orbsoc.guidance.mission import FigureFile

from .loop import Fate
from .record import FlightRun

COLOURS = {
    Fate.FLOWN: BLUE, Fate.LATE: ORANGE, Fate.MISSED: VERMILION, Fate.BUSY: VERMILION, Fate.TOO_LATE: VERMILION,
    Fate.GIVEN_UP: GREY, Fate.NO_ANSWER: GREY,
}  # fmt: skip


def draw_flight(run: FlightRun, folder: Path) -> tuple[FigureFile, ...]:
    """flight.png: computations over mission time with their fates, and which programme was flown when."""
    from matplotlib import rc_context

    with rc_context(STYLE):
        figure, (times, flown) = panels((8.0, 5.0), (2.0, 1.0))
        seen: set[Fate] = set()
        for cycle in run.flight.cycles:
            label = cycle.fate.value if cycle.fate not in seen else None
            seen.add(cycle.fate)
            height = max(cycle.price.time_ms, 1e-3)
            times.plot([cycle.trigger.at_s] * 2, [0.0, height], color=COLOURS[cycle.fate], lw=5.0, label=label,
                       solid_capstyle="butt")  # fmt: skip
        if run.timing.window_s is not None:
            times.axhline(1e3 * run.timing.window_s, color=VERMILION, ls="--", lw=1.2, label="window")
        times.set_ylabel("computation (ms, modelled)")
        times.set_ylim(bottom=0.0)
        if run.flight.cycles:
            times.legend(loc="upper left", fontsize=8)
        starts = [at for at, _ in run.flight.programmes]
        ends = [*starts[1:], run.flight.vehicle.time_s]
        for k, (begin, end) in enumerate(zip(starts, ends, strict=True)):
            flown.barh(0.0, end - begin, left=begin, height=0.6, color=BLUE if k % 2 else GREY, alpha=0.7)
        for _, programme in run.flight.programmes:
            flown.plot([programme.end_s], [0.45], marker="v", color="#222222", ms=4.0)
        lost = [c for c in run.flight.cycles if c.answer and c.answer.programme and not c.fate.is_flown]
        for cycle in lost:
            assert cycle.answer is not None
            assert cycle.answer.programme is not None
            begin, end = cycle.answer.from_s, cycle.answer.programme.end_s
            flown.plot([begin, end], [-0.8, -0.8], color=COLOURS[cycle.fate], ls="--", lw=1.2, marker="|")
        flown.set_yticks([0.0, -0.8] if lost else [0.0], ["flown", "not flown"] if lost else ["flown"])
        flown.set_ylim(-1.2 if lost else -0.6, 0.7)
        flown.set_xlabel("time from the scenario's state (s)")
        flown.set_xlim(0.0, 1.02 * run.flight.vehicle.time_s)
        times.set_xlim(flown.get_xlim())
        times.set_title(f"{run.scenario.name} on {run.computer.name}", fontsize=10)
    caption = (
        "Above, the modelled time of each computation at the time it began, by what became of it; below, the programmes that were"
        " flown, one colour each by turns, where each of them would have ended, and the answers that were not flown."
    )
    return (write_png(figure, folder, "flight.png", caption),)
