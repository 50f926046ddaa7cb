"""Pictures of many configurations: the Pareto front, Amdahl's limits, and the roofline of one engine."""

# matplotlib leaves its keyword arguments untyped:
# pyright: reportUnknownMemberType=false

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from hw_model.errors import HwModelError

from .drawing import BLUE, GREY, PALE, RED, SERIES, blank, finished, note

if TYPE_CHECKING:
    from matplotlib.axis import Axis
    from matplotlib.figure import Figure

    from hw_model.platform.platform import Platform
    from hw_model.report.bands import Band
    from hw_model.report.study import Point
    from hw_model.timing.limits import Limits, Roof


def pareto_figure(
    points: Sequence[Point], front: Sequence[Point], path: str | Path | None = None, highlight: str = "paper"
) -> Figure:
    """Time against the tightest resource, a panel per device: all points, the front with its bands, `highlight`."""
    devices = list(dict.fromkeys(point.device for point in points))
    if not devices:
        raise HwModelError("`points` is empty: a Pareto figure needs at least one")
    figure = blank(max(5.0, 3.6 * len(devices)), 4.4)
    panels = figure.subplots(1, len(devices), squeeze=False, sharey=True)[0]
    tops = [point.time_ms.high for point in front]
    for axes, device in zip(panels, devices, strict=True):
        own = [point for point in points if point.device == device]
        best = [point for point in front if point.device == device]
        special = [point for point in own if point.partition == highlight]
        axes.plot(*_places(own), ".", color=PALE, markersize=3, label="a configuration")
        if special:
            axes.plot(*_places(special), "x", color=RED, markersize=5, label=f"{highlight} split")
        low = [point.times_ms[0] - point.time_ms.low for point in best]
        high = [point.time_ms.high - point.times_ms[0] for point in best]
        axes.errorbar(
            *_places(best), yerr=[low, high], fmt="o", color=BLUE, markersize=4, capsize=2, linewidth=0.8,
            label="Pareto front, with its band",
        )  # fmt: skip
        axes.axvline(100.0, color="black", linestyle="--", linewidth=0.8)
        log_axis(
            axes.yaxis, [time for point in points for time in (point.time_ms.low, point.times_ms[0])] + tops
        )
        widest = min(400.0, 1.05 * max(100.0, *(100 * point.area_share for point in own)))
        axes.set_xlim(-0.04 * widest, widest)  # nothing on the PL stands at 0, and whole
        axes.set_title(device, fontsize=10)
        axes.set_xlabel("tightest resource, % of its ceiling", fontsize=8)
    panels[0].set_ylabel("modelled time, ms")
    figure.suptitle("Modelled time against area; right of the dashed line it does not fit", fontsize=10)
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=3, fontsize=8, frameon=False)
    return finished(figure, path)


def log_axis(axis: Axis, values: Sequence[float]) -> None:
    """A logarithmic axis over `values` with ticks at 1, 2 and 5 of each decade, in plain digits."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

    axis.axes.set_yscale("log")
    axis.axes.set_ylim(0.8 * min(values), 1.25 * max(values))
    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axis.set_minor_locator(NullLocator())
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))


def _places(points: Sequence[Point]) -> tuple[list[float], list[float]]:
    return [100 * point.area_share for point in points], [point.times_ms[0] for point in points]


def amdahl_figure(
    curves: Mapping[str, Mapping[int, tuple[Band, Limits]]], title: str, path: str | Path | None = None
) -> Figure:
    """Speedup over lanes, a curve with its band per partition; dashed, the limit of a PL that takes no time.

    `curves`: partition → lanes → (speedup, limits).
    """
    figure = blank(7.2, 4.4)
    axes = figure.add_subplot()
    for colour, (name, by_lanes) in zip(SERIES, curves.items(), strict=False):
        lanes = sorted(by_lanes)
        bands = [by_lanes[count][0] for count in lanes]
        limit = by_lanes[lanes[-1]][1]
        words = f"{name}; dashed, were the PL free: {limit.free_pl:.1f}×; the link too: {limit.free_pl_and_link:.1f}×"
        axes.plot(lanes, [band.nominal for band in bands], "o-", color=colour, markersize=4, label=words)
        axes.fill_between(
            lanes,
            [band.low for band in bands],
            [band.high for band in bands],
            color=colour,
            alpha=0.15,
            linewidth=0,
        )
        axes.axhline(limit.free_pl, color=colour, linestyle="--", linewidth=1.0)
    axes.axhline(1.0, color=GREY, linewidth=0.8)
    axes.set_xscale("log", base=2)
    counts = sorted({count for by_lanes in curves.values() for count in by_lanes})
    axes.set_xticks(counts, [str(count) for count in counts])
    axes.set_ylim(bottom=0.0)
    axes.set_xlabel("lanes")
    axes.set_ylabel("modelled speedup over all_ps")
    axes.set_title(f"Modelled: what more lanes buy, and Amdahl's limits: {title}", fontsize=10)
    figure.legend(fontsize=8, frameon=False, loc="outside lower center")
    return finished(figure, path)


def roofline_figure(rows: Sequence[Roof], platform: Platform, path: str | Path | None = None) -> Figure:
    """Each module's operations a second against its operations a byte, under the roofs of lanes and DMA."""
    figure = blank(7.2, 4.6)
    axes = figure.add_subplot()
    clock_mhz = platform.pl.clock_mhz.value
    peak = platform.pl.lanes.value * clock_mhz * 1e-3
    bandwidth = platform.link.dma_to_pl_bytes_per_pl_cycle.value * clock_mhz * 1e-3
    known = [row.intensity for row in rows if row.intensity < float("inf")]
    left, right = min([0.1, *known]) / 2, 10 * max([10.0, *known])
    ridge = peak / bandwidth
    axes.plot([left, ridge, right], [left * bandwidth, peak, peak], color="black", linewidth=1.2)
    lanes = f"{platform.pl.lanes.value} lanes at {clock_mhz:g} MHz: {peak:.2f} Gop/s"
    note(axes, lanes, (right, peak), (0, 4), ha="right")
    note(axes, f"DMA {1000 * bandwidth:.0f} MB/s", (0.6 * ridge, 0.6 * peak), (-6, 4), ha="right")
    for colour, row in zip(SERIES, rows, strict=False):
        place = min(row.intensity, right / 1.5)
        axes.plot([place, place], [row.gops_with_link, row.gops], color=colour, linewidth=1.0)
        axes.plot(place, row.gops, "o", color=colour, markersize=6, label=row.module.replace("_", " "))
        axes.plot(place, row.gops_with_link, "v", color=colour, markersize=6)
    axes.plot([], [], "o", color=GREY, label="(round) while computing")
    axes.plot([], [], "v", color=GREY, label="(triangle) with copies and interrupts")
    axes.set_xscale("log")
    log_axis(axes.yaxis, [0.9 * min(row.gops_with_link for row in rows), peak])
    axes.set_xlabel("operations per byte across the link")
    axes.set_ylabel("modelled Gop/s")
    axes.set_title(f"Modelled roofline: {platform.name}", fontsize=10)
    axes.legend(fontsize=7, frameon=False, loc="lower right")
    return finished(figure, path)
