"""Two pictures of modelled time: speedups with their bands, and where the time goes module by module.

matplotlib is imported when a figure is drawn, not before.
"""

# matplotlib leaves its keyword arguments untyped:
# pyright: reportUnknownMemberType=false

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from hw_model.errors import HwModelError
from hw_model.vocabulary import by_place, count_of

from .drawing import GREEN, GREY, PALE, PLACES, RED, blank, finished, legend, note

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from hw_model.report.bands import Band
    from hw_model.report.speedup import Report

_DEVICES_IN_A_ROW = 6
_GAIN = {"faster": GREEN, "band crosses 1": GREY, "slower": RED}


def speedup_figure(
    reports: Sequence[Report], path: str | Path | None = None, fits: Sequence[bool] | None = None
) -> Figure:
    """A bar per report with its band, grouped by device, many devices in rows of their own; the dashed line is the baseline.

    `fits`: whether each report's engine fits into its device; one that does not is an outline and says so. Saves a PNG
    when `path` is given. Raises HwModelError without reports or with different baselines.
    """
    if not reports:
        raise HwModelError("`reports` is empty: a speedup figure needs at least one")
    baselines = sorted({report.baseline for report in reports})
    if len(baselines) > 1:
        raise HwModelError(f"`reports` have different baselines: {', '.join(baselines)}")
    devices = list(dict.fromkeys(report.device for report in reports))
    fitting = {id(report): fit for report, fit in zip(reports, fits or [True] * len(reports), strict=True)}
    rows = [
        [report for device in group for report in reports if report.device == device]
        for group in _in_rows(devices)
    ]
    figure = blank(max(5.0, 1.6 + 0.95 * max(map(len, rows))), 4.2 * len(rows))
    top = 1.2 * max(1.0, *(report.speedup.high for report in reports))
    for place, (axes, row) in enumerate(
        zip(figure.subplots(len(rows), squeeze=False).flat, rows, strict=True)
    ):
        _bars(axes, row, fitting)
        axes.set_ylim(0.0, top)
        axes.set_ylabel(f"modelled speedup over {baselines[0]}")
        if place == 0:
            axes.set_title("Modelled speedup, with the band of the assumed parameters", fontsize=10)
    shown = {_gain(report.speedup) for report in reports}
    legend(figure, {name: colour for name, colour in _GAIN.items() if name in shown})
    return finished(figure, path)


def _in_rows(devices: list[str]) -> list[list[str]]:
    """The devices in rows of nearly one length, at most `_DEVICES_IN_A_ROW` each."""
    rows = -(-len(devices) // _DEVICES_IN_A_ROW)
    length = -(-len(devices) // rows)
    return [devices[start : start + length] for start in range(0, len(devices), length)]


def _bars(axes: Axes, reports: list[Report], fitting: dict[int, bool]) -> None:
    """One row of bars, with space between the devices."""
    devices = list(dict.fromkeys(report.device for report in reports))
    places = [k + 0.6 * devices.index(report.device) for k, report in enumerate(reports)]
    for place, report in zip(places, reports, strict=True):
        band = report.speedup
        reach = [[band.nominal - band.low], [band.high - band.nominal]]
        colour, fit = _GAIN[_gain(band)], fitting[id(report)]
        axes.bar(
            place, band.nominal, width=0.7, color=colour if fit else "none", edgecolor=colour,
            hatch=None if fit else "///", yerr=reach, capsize=4,
        )  # fmt: skip
        text = f"{band.nominal:.2f}×" if fit else f"{band.nominal:.2f}×\ndoes not fit"
        note(axes, text, (place, band.high), ha="center", fontsize=9)
    axes.axhline(1.0, color="black", linestyle="--", linewidth=0.8)
    labels = [
        "\n".join((report.device, count_of(report.lanes, "lane"), report.partition.replace("+", "\n+ ")))
        for report in reports
    ]
    axes.set_xticks(places, labels, fontsize=8)
    axes.set_xlim(places[0] - 1.0, places[-1] + 1.0)


def module_figure(report: Report, path: str | Path | None = None) -> Figure:
    """Time of each module: the baseline above, this partition below, split into PS, PL, link and interrupt.

    Saves a PNG when `path` is given.
    """
    figure = blank(7.2, 1.6 + 0.62 * len(report.modules))
    axes = figure.add_subplot()
    for place, row in enumerate(report.modules):
        axes.barh(place - 0.2, row.baseline_picoseconds / 1e9, height=0.36, color=PALE)
        start = 0.0
        for name, picoseconds in by_place(row.causes_picoseconds).items():
            axes.barh(place + 0.2, picoseconds / 1e9, height=0.36, left=start, color=PLACES[name])
            start += picoseconds / 1e9
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
    legend(figure, {f"{report.baseline} (baseline)": PALE} | PLACES)
    return finished(figure, path)


def _gain(band: Band) -> str:
    if band.low > 1.0:
        return "faster"
    return "slower" if band.high < 1.0 else "band crosses 1"
