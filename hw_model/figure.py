"""Two pictures of modelled time: speedups with their bands, and where the time goes module by module.

matplotlib is imported when a figure is drawn, not before.
"""

# matplotlib leaves its keyword arguments untyped:
# pyright: reportUnknownMemberType=false

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from .errors import HwModelError
from .vocabulary import by_place

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from .report import Band, Report

# Colour-blind safe (Okabe and Ito).
_COLOURS = {"PS": "#0072B2", "PL": "#009E73", "link": "#E69F00", "interrupt": "#D55E00"}
_GAIN = {"faster": "#009E73", "band crosses 1": "#999999", "slower": "#D55E00"}
_BASELINE = "#BBBBBB"
_DPI = 150


def speedup_figure(reports: Sequence[Report], path: str | Path | None = None) -> Figure:
    """A bar per report with its band, grouped by device; the dashed line is the baseline.

    Saves a PNG when `path` is given. Raises HwModelError without reports or with different baselines.
    """
    if not reports:
        raise HwModelError("`reports` is empty: a speedup figure needs at least one")
    baselines = sorted({report.baseline for report in reports})
    if len(baselines) > 1:
        raise HwModelError(f"`reports` have different baselines: {', '.join(baselines)}")
    figure = _figure(max(5.0, 1.6 + 0.95 * len(reports)), 3.9)
    axes = figure.add_subplot()
    devices = list(dict.fromkeys(report.device for report in reports))
    ordered = sorted(reports, key=lambda report: devices.index(report.device))
    places = [k + 0.6 * devices.index(report.device) for k, report in enumerate(ordered)]
    for place, report in zip(places, ordered, strict=True):
        band = report.speedup
        reach = [[band.nominal - band.low], [band.high - band.nominal]]
        axes.bar(place, band.nominal, width=0.7, color=_GAIN[_gain(band)], yerr=reach, capsize=4)
        axes.annotate(
            f"{band.nominal:.2f}×",
            (place, band.high),
            (0, 3),
            textcoords="offset points",
            ha="center",
            fontsize=9,
        )
    axes.axhline(1.0, color="black", linestyle="--", linewidth=0.8)
    labels = [f"{report.partition}\n{report.device}\n{report.lanes} lanes" for report in ordered]
    axes.set_xticks(places, labels, fontsize=8)
    axes.set_xlim(places[0] - 1.0, places[-1] + 1.0)
    axes.set_ylim(0.0, 1.15 * max(1.0, *(report.speedup.high for report in reports)))
    axes.set_ylabel(f"modelled speedup over {baselines[0]}")
    axes.set_title("Modelled speedup, with the band of the assumed parameters", fontsize=10)
    _legend(figure, _GAIN)
    return _finished(figure, path)


def module_figure(report: Report, path: str | Path | None = None) -> Figure:
    """Time of each module: the baseline above, this partition below, split into PS, PL, link and interrupt.

    Saves a PNG when `path` is given.
    """
    figure = _figure(7.2, 1.6 + 0.62 * len(report.modules))
    axes = figure.add_subplot()
    for place, row in enumerate(report.modules):
        axes.barh(place - 0.2, row.baseline_picos / 1e9, height=0.36, color=_BASELINE)
        start = 0.0
        for name, picos in by_place(row.causes_picos).items():
            axes.barh(place + 0.2, picos / 1e9, height=0.36, left=start, color=_COLOURS[name])
            start += picos / 1e9
    names = [
        "PS's own tasks" if row.module == "ps" else f"{row.module} ({row.side.upper()})"
        for row in report.modules
    ]
    axes.set_yticks(range(len(names)), names, fontsize=9)
    axes.invert_yaxis()
    axes.set_xlabel("modelled time, ms")
    axes.set_title(
        f"Modelled time by module: {report.partition} on {report.device}, {report.lanes} lanes, "
        f"{report.pl_clock_mhz:g} MHz",
        fontsize=10,
    )
    _legend(figure, {f"{report.baseline} (baseline)": _BASELINE} | _COLOURS)
    return _finished(figure, path)


def _gain(band: Band) -> str:
    if band.low > 1.0:
        return "faster"
    return "slower" if band.high < 1.0 else "band crosses 1"


def _legend(figure: Figure, colours: dict[str, str]) -> None:
    """One row under the axes, in the given order whatever was drawn."""
    from matplotlib.patches import Patch

    patches = [Patch(color=colour, label=name) for name, colour in colours.items()]
    figure.legend(handles=patches, loc="outside lower center", ncols=len(patches), fontsize=8, frameon=False)


def _figure(width: float, height: float) -> Figure:
    """An empty figure without any window system behind it."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def _finished(figure: Figure, path: str | Path | None) -> Figure:
    for axes in figure.axes:
        axes.spines[["top", "right"]].set_visible(False)
    if path is not None:
        figure.savefig(path, dpi=_DPI)
    return figure
