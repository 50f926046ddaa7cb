"""The picture of engine sets: solves a second over those of all cores, by how many problems are interleaved."""

# matplotlib leaves its keyword arguments untyped:
# pyright: reportUnknownMemberType=false

from __future__ import annotations

from typing import TYPE_CHECKING

from hw_model.vocabulary import count_of

from .drawing import GREY, blank, finished

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from matplotlib.figure import Figure

    from hw_model.report.throughput_study import EngineSet


def throughput_figure(sets: Sequence[EngineSet], title: str, path: str | Path | None = None) -> Figure:
    """A line for each shape, of the most engines that fit at each number of problems; hollow where not even one does."""
    figure = blank(7.2, 4.4)
    axes = figure.add_subplot()
    counts = list(dict.fromkeys(each.copies for each in sets))
    for shape in dict.fromkeys(each.shape for each in sets):
        chosen = [_most(sets, shape, copies) for copies in counts]
        places = [each.copies for each in chosen], [each.found.gain for each in chosen]
        label = f"{count_of(shape[0], 'lane')}, {count_of(shape[3], 'cluster')}"
        (line,) = axes.plot(*places, linewidth=0.9, label=label)
        for each in chosen:
            face = line.get_color() if each.fits else "white"
            axes.plot(each.copies, each.found.gain, "o", color=line.get_color(), markerfacecolor=face)
            axes.annotate(
                f"×{each.found.engines}", (each.copies, each.found.gain), (4, 4), textcoords="offset points", fontsize=7
            )  # fmt: skip
    axes.axhline(1.0, color=GREY, linewidth=0.9, label=f"{count_of(sets[0].found.cores, 'core')} alone")
    axes.set_xscale("log", base=2)
    axes.set_xticks(counts, [f"{count}" for count in counts])
    axes.minorticks_off()
    axes.set_xlabel("problems interleaved in each engine (hollow: one engine does not fit)", fontsize=8)
    axes.set_ylabel("modelled solves a second over those of all cores", fontsize=8)
    axes.set_ylim(bottom=0.0)
    axes.set_title(title, fontsize=10)
    axes.legend(fontsize=8, edgecolor="none")
    return finished(figure, path)


def _most(sets: Sequence[EngineSet], shape: tuple[int, int, int, int], copies: int) -> EngineSet:
    """The set with the most solves a second that fits, or the smallest one."""
    here = [each for each in sets if (each.shape, each.copies) == (shape, copies)]
    fitting = [each for each in here if each.fits]
    if fitting:
        return max(fitting, key=lambda each: each.found.solves_per_s)
    return min(here, key=lambda each: each.found.engines)
