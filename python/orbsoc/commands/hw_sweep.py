"""`orbsoc hw sweep`: a grid of configurations, priced from one record; the Pareto front as CSV and figure."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from . import hw_options as options
from .failures import exit_handling

if TYPE_CHECKING:
    from hw_model import Platform
    from hw_model.report.study import Point
    from hw_model.report.sweep import Refused, Sweep
    from orbsoc.hw.workload import Workload


def sweep(
    file: Annotated[
        Path, typer.Argument(help="axes of the grid, TOML", metavar="SWEEP.toml", show_default=False)
    ],
    workload: Annotated[
        Path | None,
        typer.Argument(help="what to price; else the sweep file's `workload`", metavar="WORKLOAD"),
    ] = None,
    exact: options.ExactOption = None,
    out: options.OutOption = None,
    as_json: options.JsonOption = False,
) -> None:
    """Price every point of a grid and write all of them and the Pareto front of time against resources."""
    with exit_handling(as_json):
        from hw_model.figures.study import pareto_figure
        from hw_model.platform.partition import load_partition
        from hw_model.report.study import pareto
        from hw_model.report.sweep import load_sweep, possible_computers
        from hw_model.report.usage import STUDY_USAGE
        from orbsoc.hw.workload import load_workload

        chosen = load_sweep(file)
        _check_orderings(chosen, file)
        place = _workload(chosen, workload, file)
        record = load_workload(place)
        platforms = [platform for platform, _ in possible_computers(chosen)[0]]
        cycles = options.stage_cycles(record, exact=exact, computers=platforms)
        points, refused = _points(place, record, chosen, platforms, exact)
        front = pareto(points)
        first = {platform.name: platform for platform in reversed(platforms)}
        widest = max(map(load_partition, chosen.partitions), key=lambda split: split.uses_pl)
        document = {
            "schema": "orbsoc.hardware-sweep/1",
            "provenance": "modelled",
            "workload": record.origin,
            "points": len(points),
            "axes": {"device": list(chosen.devices), "partition": list(chosen.partitions)}
            | ({"ordering": list(chosen.orderings)} if chosen.orderings else {})
            | {key: list(values) for key, values in chosen.axes.items()},
            "refused": [asdict(each) for each in refused],
            "pareto": [point.row() for point in front],
            "assumptions": {
                name: options.echoed(platform, STUDY_USAGE.of(record.trace, widest, platform, cycles))
                for name, platform in sorted(first.items())
            },
        }
        folder = out or Path("out") / f"hw-sweep-{file.stem}"
        options.write_all(
            folder,
            {
                "sweep.json": options.as_json_text(document),
                "sweep.csv": options.as_csv_text([point.row() for point in points]),
                "pareto.csv": options.as_csv_text([point.row() for point in front]),
            },
        )
        pareto_figure(points, front, folder / "pareto.png")
        fitting = sum(point.budget.fits for point in points)
        lines = [
            f"modelled: {record.origin}: {len(points)} points, {fitting} fit, {len(front)} on the Pareto front",
            *map(_line, front),
            *(
                ["none fits; nearest to it: " + _line(min(points, key=_share))]
                if points and not front
                else []
            ),
            *(f"no point: {each.device} {_settings(each.settings)}: {each.why}" for each in refused[:_SHOWN]),
            *([f"… and {len(refused) - _SHOWN} more without a point"] if len(refused) > _SHOWN else []),
        ]
        options.print_report(lines, document, folder, as_json=as_json)


def _check_orderings(chosen: Sweep, file: Path) -> None:
    """Raise SweepError for an order of elimination that the solver does not know."""
    from hw_model.report.sweep import SweepError
    from orbsoc.hw.elimination import ORDERS

    for name in chosen.orderings:
        if name not in ORDERS:
            raise SweepError(
                f"sweep {file.name}: `axes.ordering` = {name!r}: allowed are {', '.join(ORDERS)}"
            )


def _points(
    place: Path, record: Workload, chosen: Sweep, platforms: list[Platform], exact: bool | None
) -> tuple[list[Point], list[Refused]]:
    """The points of each order of the sweep, or of each the one in the fastest order; and what has none in any order.

    Raises SweepError for an axis of orders where the record is a trace, which has its own.
    """
    from hw_model.report.study import Study
    from hw_model.report.sweep import SweepError, run
    from orbsoc.hw.elimination import (
        HOST,
        differing_orders,
        fastest_points,
        named,
        with_fastest_baseline,
    )
    from orbsoc.hw.workload import load_workload

    if record.has_order and chosen.orderings:
        raise SweepError(f"`axes.ordering`: {place.name} has its own order; give a scenario or a problem")
    works = {HOST: record}
    for name in chosen.orderings or (() if record.has_order else differing_orders(record)):
        works[name] = works.get(name) or load_workload(place, name)
    priced: dict[str, list[Point]] = {}
    without: dict[str, list[Refused]] = {}
    for name in chosen.orderings or works:
        cycles = options.stage_cycles(works[name], exact=exact, computers=platforms)
        priced[name], without[name] = run(works[name].trace, chosen, Study(works[name].trace, cycles))
    if record.has_order:
        return priced[HOST], without[HOST]
    if not chosen.orderings:
        refused = [each for each in without[HOST] if all(each in others for others in without.values())]
        return fastest_points(priced), refused
    settled = with_fastest_baseline(priced)
    points = [named(point, name) for name, found in settled.items() for point in found]
    return points, [
        replace(each, settings={"ordering": name, **each.settings})
        for name, found in without.items()
        for each in found
    ]


def _line(point: Point) -> str:
    from hw_model.vocabulary import count_of

    settings = "".join(f" {key}={value}" for key, value in point.settings.items())
    return (
        f"{point.device} {point.partition} {count_of(point.lanes, 'lane')} {point.pl_clock_mhz:g} MHz{settings}:"
        f" {point.times_ms[0]:.3f} ms, {point.energy.nominal_mj:.2f} mJ,"
        f" {point.budget.tightest.kind} at {100 * point.area_share:.0f} % of its ceiling"
        f"{'' if point.budget.fits else ', DOES NOT FIT'}{_loads(point)}"
    )


def _loads(point: Point) -> str:
    """What the loads of a run take, where there are any."""
    return f", of it {point.loading.plan_ms:.3f} ms loading programs" if point.loading.plan_ms else ""


def _share(point: Point) -> float:
    return point.area_share


_SHOWN = 5
"""Refusals that are printed; `sweep.json` has all."""


def _settings(settings: Mapping[str, Any]) -> str:
    return " ".join(f"{key}={value}" for key, value in settings.items())


def _workload(chosen: Sweep, given: Path | None, file: Path) -> Path:
    """The workload of the command line, or of the sweep file. Raises SweepError when neither names one."""
    from hw_model.report.sweep import SweepError

    place = given or chosen.workload
    if place is None:
        raise SweepError(f"sweep {file.name}: names no `workload`; name it there or on the command line")
    return place
