"""`orbsoc hw partition`: every partition on the computers of a device, and whether the paper's is worth its resources."""

from __future__ import annotations

from collections import Counter
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from . import hw_options as options
from .failures import exit_handling
from .hw_progress import Progress

if TYPE_CHECKING:
    from hw_model import Platform
    from hw_model.report.bands import Band
    from hw_model.report.partition_verdict import Verdict
    from hw_model.report.study import Point, Study
    from hw_model.report.usage import ParameterUse
    from hw_model.timing.limits import Limits
    from hw_model.timing.stage_cycles import StageCycles
    from orbsoc.hw.workload import Workload

DEVICE = "zu9eg"
"""The one that is priced where none is named."""


def partition(
    workload: options.WorkloadArgument,
    devices: Annotated[
        str | None,
        typer.Option("--device", help="platforms, joined by commas, or all", show_default=DEVICE),
    ] = None,
    every: Annotated[bool, typer.Option("--all", help="all platforms: short for --device all")] = False,
    lanes: Annotated[str, typer.Option(help="lane counts, joined by commas")] = "2,4,8,16",
    clocks: Annotated[str, typer.Option(help="PL clocks in MHz, joined by commas")] = "100,150,200",
    settings: options.SetOption = None,
    exact: options.ExactOption = None,
    ordering: options.OrderingOption = None,
    out: options.OutOption = None,
    as_json: options.JsonOption = False,
) -> None:
    """Price all partitions of seven modules, and resident control, × lanes × clocks × devices, and say which of them no other beats."""
    with exit_handling(as_json):
        from hw_model.figures.study import pareto_figure
        from hw_model.platform.partition import load_partition
        from hw_model.report.energy_front import energy_front, sensitivities
        from hw_model.report.energy_front import words as energy_words
        from hw_model.report.partition_verdict import verdicts
        from hw_model.report.study import Study, pareto
        from hw_model.report.usage import STUDY_USAGE, require_used
        from orbsoc.hw.elimination import fastest_points

        chosen = options.parsed_settings(settings, _AXES)
        computers = _computers(_named(devices, every=every), lanes, clocks, chosen)
        tell = Progress()
        tell(f"recording {workload.name}")
        works = options.recorded_orders(workload, ordering)
        cycles_in = {
            name: options.stage_cycles(work, exact=exact, computers=computers) for name, work in works.items()
        }
        first_order = next(iter(works))
        record, cycles = works[first_order], cycles_in[first_order]
        reading = STUDY_USAGE.of(record.trace, load_partition("paper"), computers[0], cycles)
        require_used(chosen, ((platform, reading) for platform in computers))
        priced = {
            name: _priced(Study(work.trace, cycles_in[name]), computers, tell) for name, work in works.items()
        }
        points = fastest_points(priced) if len(works) > 1 else priced[first_order]
        tell("drawing")
        front, found, thrifty = pareto(points), verdicts(points), energy_front(points)
        first = {platform.name: platform for platform in reversed(computers)}
        moving = [row for name in sorted(first) for row in sensitivities(points, first[name])]
        document = _document(record, computers, reading, points, front, found)
        document["energy_front"] = [point.row() for point in thrifty]
        document["energy_sensitivity"] = [asdict(row) for row in moving]
        folder = out or Path("out") / f"hw-partition-{record.name}"
        options.write_all(
            folder,
            {
                "partition.json": options.as_json_text(document),
                "partition.csv": options.as_csv_text([point.row() for point in points]),
                "pareto.csv": options.as_csv_text([point.row() for point in front]),
                "energy_sensitivity.csv": options.as_csv_text(document["energy_sensitivity"]),
            },
        )
        drawn = front[0].settings.get("ordering", first_order) if front else first_order
        pareto_figure(points, front, folder / "pareto.png")
        _draw(works[drawn], cycles_in[drawn], computers, priced[drawn], folder)
        lines = _lines(record, points, front, found)
        lines[-1:-1] = [energy_words(name, thrifty, moving) for name in first]
        options.print_report(lines, document, folder, as_json=as_json)


def _named(devices: str | None, *, every: bool) -> str:
    """What `--device` and `--all` ask for. Raises HwModelError where they ask for two things."""
    from hw_model import HwModelError

    if every and devices not in (None, "all"):
        raise HwModelError(f"--all: --device {devices!r} asks for others; give one of the two")
    return "all" if every else devices or DEVICE


_AXES = {"pl.lanes": "--lanes", "pl.clock_mhz": "--clocks"}


def _computers(devices: str, lanes: str, clocks: str, settings: dict[str, Any]) -> list[Platform]:
    """Every platform, with every number of lanes at every clock."""
    from hw_model import HwModelError, platform_names

    names = platform_names() if devices == "all" else options.listed(devices, "--device")
    counts, rates = options.listed(lanes, "--lanes", int), options.listed(clocks, "--clocks", float)
    platforms = [options.computer(name, settings) for name in names]
    twins = [name for name, many in Counter(platform.name for platform in platforms).items() if many > 1]
    if twins:
        raise HwModelError(
            f"--device {devices!r}: two platforms are called {twins[0]!r}; give them names of their own"
        )
    return [
        platform.with_values({"pl.lanes": count, "pl.clock_mhz": rate})
        for platform in platforms
        for rate in rates
        for count in counts
    ]


def _priced(study: Study, computers: list[Platform], tell: Progress) -> list[Point]:
    from hw_model.platform.partition import all_partitions

    splits = all_partitions(programs=study.trace.method is not None)
    tell(f"pricing {len(splits)} partitions on each of {len(computers)} computers")
    points: list[Point] = []
    for number, platform in enumerate(computers, 1):
        points += study.points(platform, splits)
        tell.now_and_then(f"priced {number} of {len(computers)} computers")
    return points


def _document(
    record: Workload,
    computers: list[Platform],
    reading: ParameterUse,
    points: list[Point],
    front: list[Point],
    found: list[Verdict],
) -> dict[str, Any]:
    first = {platform.name: platform for platform in reversed(computers)}
    return {
        "schema": "orbsoc.hardware-partitions/1",
        "provenance": "modelled",
        "workload": record.origin,
        "points": len(points),
        "pareto": [point.row() for point in front],
        "paper": [verdict.to_dict() for verdict in found],
        "assumptions": {name: options.echoed(platform, reading) for name, platform in sorted(first.items())},
    }


def _lines(record: Workload, points: list[Point], front: list[Point], found: list[Verdict]) -> list[str]:
    from hw_model.vocabulary import count_of

    fits = Counter(point.device for point in points if point.budget.fits)
    count = Counter(point.device for point in points)
    lines = [f"modelled: {record.origin}: {len(points)} configurations"]
    for device in count:
        best = next((point for point in front if point.device == device), None)
        if best is None:
            lines.append(f"{device}: none of {count[device]} fits")
            continue
        ratio, what = best.speedup, f"{device}: {fits[device]} of {count[device]} fit"
        if best.partition == "all_ps":
            lines.append(f"{what}; none that fits is faster than the PS alone, {best.times_ms[0]:.3f} ms")
            continue
        lines.append(
            f"{what}; fastest that fits: {best.partition}, {count_of(best.lanes, 'lane')} at"
            f" {best.pl_clock_mhz:g} MHz: {best.times_ms[0]:.3f} ms, speedup {ratio.nominal:.2f}×"
            f" ({ratio.low:.2f}–{ratio.high:.2f}×), energy {best.energy.words}; {best.loading.words}"
        )
    beaten = [verdict for verdict in found if not verdict.optimal]
    for device in count:  # one of many computers of a device stands for it here; partition.json has them all
        own = [verdict for verdict in found if verdict.point.device == device]
        lines.append(own[len(own) // 2].words)
    robust = sum(verdict.robust for verdict in beaten)
    lines.append(
        f"the paper's split is Pareto-optimal on {len(found) - len(beaten)} of {len(found)} computers;"
        f" it is beaten on {len(beaten)}, on {robust} of them over the whole band"
    )
    return lines


def _draw(
    record: Workload,
    cycles: StageCycles,
    computers: list[Platform],
    points: list[Point],
    folder: Path,
) -> None:
    """All in one order of elimination: speedup.png of the shipped partitions and the fastest; amdahl.png, roofline.png of one device."""
    from hw_model.figures.speedup import speedup_figure
    from hw_model.figures.study import amdahl_figure, roofline_figure
    from hw_model.platform.partition import load_partition
    from hw_model.report.speedup import speedup
    from hw_model.timing.limits import limits, roofs

    paper = load_partition("paper")
    rates = sorted({platform.pl.clock_mhz.value for platform in computers})
    middle = [platform for platform in computers if platform.pl.clock_mhz.value == rates[len(rates) // 2]]
    one = [platform for platform in middle if platform.name == computers[-1].name]
    names = ("paper", "matrix_update+factorization+linear_solve", "factor_only")
    known = {(point.device, point.lanes, point.pl_clock_mhz, point.partition): point for point in points}

    def curve(name: str, platform: Platform) -> tuple[Band, Limits]:
        point = known[platform.name, platform.pl.lanes.value, platform.pl.clock_mhz.value, name]
        split = load_partition(name)
        return point.speedup, limits(record.trace, platform, split, cycles, point.budget.programs)

    curves = {name: {platform.pl.lanes.value: curve(name, platform) for platform in one} for name in names}
    title = f"{one[0].name}, PL at {one[0].pl.clock_mhz.value:g} MHz"
    amdahl_figure(curves, title, folder / "amdahl.png")
    typical = min(one, key=lambda platform: abs(platform.pl.lanes.value - 4))
    roofline_figure(roofs(record.trace, typical, paper, cycles), typical, folder / "roofline.png")
    shown = [platform for platform in middle if platform.pl.lanes.value == typical.pl.lanes.value]
    bars = [
        known[platform.name, platform.pl.lanes.value, platform.pl.clock_mhz.value, name]
        for platform in shown
        for name in dict.fromkeys([*names, _fastest(points, platform).partition])
    ]
    computer = {platform.name: platform for platform in shown}
    reports = [speedup(record.trace, computer[bar.device], bar.partition, cycles=cycles) for bar in bars]
    fitting = [bar.budget.fits for bar in bars]
    speedup_figure(reports, folder / "speedup.png", fitting)


def _fastest(points: list[Point], platform: Platform) -> Point:
    """On one computer the fastest that fits, or the fastest; the PS alone is the baseline and no candidate."""
    own = (platform.name, platform.pl.lanes.value, platform.pl.clock_mhz.value)
    rivals = [
        each
        for each in points
        if (each.device, each.lanes, each.pl_clock_mhz) == own and each.partition != "all_ps"
    ]
    return min(rivals, key=lambda each: (not each.budget.fits, each.times_ms[0]))
