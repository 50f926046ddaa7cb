"""`orbsoc hw design`: the search for an engine, its front of time against area, and where the paper's design lies."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from orbsoc.files.interrupts import Interrupts

from . import hw_options as options
from .failures import exit_handling

if TYPE_CHECKING:
    from hw_model import Platform
    from hw_model.report.design import Row, Standing
    from orbsoc.hw.design import Space

_LISTED = "joined by commas"


def design(
    workload: Annotated[
        Path,
        typer.Argument(help="SCENARIO.toml or PROBLEM.json", metavar="WORKLOAD", show_default=False),
    ],
    device: options.DeviceOption = "zu9eg",
    ordering: Annotated[
        str, typer.Option(help=f"orders of elimination, {_LISTED}")
    ] = "amd,nested_dissection",
    lanes: Annotated[str, typer.Option(help=f"lane counts, {_LISTED}")] = "1,2,4,8,16",
    dividers: Annotated[str, typer.Option(help=f"divider counts, {_LISTED}")] = "1,2,4",
    banks: Annotated[str, typer.Option(help=f"bank counts, {_LISTED}")] = "16,32",
    clusters: Annotated[str, typer.Option(help=f"clusters of lanes and banks, {_LISTED}")] = "1,8",
    clocks: Annotated[
        str | None, typer.Option(help=f"PL clocks in MHz, {_LISTED}; the device's by default")
    ] = None,
    memories: Annotated[
        str,
        typer.Option(help=f"where microcode lies, {_LISTED}: block_ram, streamed_start, streamed, ultra_ram"),
    ] = "block_ram,streamed_start",
    settings: options.SetOption = None,
    resume: Annotated[bool, typer.Option("--resume", help="go on in a folder of this search")] = False,
    threads: Annotated[
        int | None, typer.Option(help="worker processes of this machine; all cores by default", min=1)
    ] = None,
    out: options.OutOption = None,
    as_json: options.JsonOption = False,
) -> None:
    """Price every engine, order, clock, memory and partition, and write the designs that no other beats.

    After Ctrl-C, --resume goes on: what is scheduled and priced stays.
    """
    folder = out or Path("out") / f"hw-design-{workload.stem}"
    interrupted = f"interrupted; priced designs are in {folder}, --resume goes on"
    with Interrupts() as interrupts, exit_handling(as_json, interrupted=interrupted, interrupts=interrupts):
        from orbsoc.hw.design import Space

        chosen = options.parsed_settings(settings, _AXES)
        platform = options.computer(device, chosen)
        space = Space(
            ordering=tuple(options.listed(ordering, "--ordering")),
            lanes=tuple(options.listed(lanes, "--lanes", int)),
            dividers=tuple(options.listed(dividers, "--dividers", int)),
            banks=tuple(options.listed(banks, "--banks", int)),
            clusters=tuple(options.listed(clusters, "--clusters", int)),
            clock_mhz=tuple(options.listed(clocks, "--clocks", float))
            if clocks
            else (platform.pl.clock_mhz.value,),
            microcode_memory=tuple(options.listed(memories, "--memories")),
        )
        _check(space, platform)
        rows, standing, document = _searched(
            workload, device, chosen, space, folder, resume, threads, as_json, interrupts
        )
        options.print_report(_lines(rows, standing, document), document, folder, as_json=as_json)


_AXES = {
    "pl.lanes": "--lanes",
    "pl.dividers": "--dividers",
    "pl.banks": "--banks",
    "pl.clusters": "--clusters",
    "pl.clock_mhz": "--clocks",
    "pl.microcode_memory": "--memories",
}


def _check(space: Space, platform: Platform) -> None:
    """Refuse what no engine can be before anything is solved. Raises HwModelError."""
    from hw_model import HwModelError
    from hw_model.area.engine import require_buildable
    from hw_model.timing.schedules import engine_of
    from orbsoc.hw.design import platform_of

    engine_of(platform, "f64")
    if not space.shapes:
        raise HwModelError(
            f"--clusters {','.join(map(str, space.clusters))} divides none of --lanes {','.join(map(str, space.lanes))}: no engine is left"
        )
    for shape in space.shapes:
        for clock in space.clock_mhz:
            for memory in space.microcode_memory:
                require_buildable(platform_of(platform, shape, clock, memory).pl)


def _searched(
    workload: Path,
    device: str,
    chosen: dict[str, Any],
    space: Space,
    folder: Path,
    resume: bool,
    threads: int | None,
    as_json: bool,
    interrupts: Interrupts,
) -> tuple[list[Row], Standing, dict[str, Any]]:
    """All designs, the paper's standing, and the document; files are written."""
    from dataclasses import asdict, replace

    from rich.console import Console

    from hw_model.figures.design import design_figure
    from hw_model.platform.partition import load_partition
    from hw_model.report.design import Standing, front_of
    from hw_model.report.usage import STUDY_USAGE, require_used
    from orbsoc.hw import design as search
    from orbsoc.hw.exact_cycles import exact_cycles
    from orbsoc.sweep import Processes, ShardStore, Task, run

    from .sweep_progress import SweepProgress

    identity = {
        "name": workload.name,
        "workload": workload.read_text(encoding="utf-8"),
        "device": device,
        "settings": {key: str(value) for key, value in chosen.items()},
        "space": asdict(space),
    }
    platform = options.computer(device, chosen)
    store = ShardStore.open(folder, identity, resume=resume)
    works = [search.record(workload, ordering, folder) for ordering in space.ordering]
    interrupts.check()
    cycles = exact_cycles(works[0].problems, (), works[0].settings)
    reading = STUDY_USAGE.of(works[0].trace, load_partition("paper"), platform, cycles)
    require_used(chosen, [(platform, reading)])
    payloads = search.payloads(space, device, chosen, folder)
    tasks = [
        Task(search.DESIGNS, number, space.designs_of_a_shape, payload)
        for number, payload in enumerate(payloads)
    ]
    workers = Processes(threads or len(os.sched_getaffinity(0)))
    with SweepProgress(Console(stderr=True)) as progress:
        report = run(store, tasks, search.price_shape, workers, progress)
    interrupts.check()
    rows = search.rows_of(store.read(search.DESIGNS))
    front = front_of(rows)
    paper = replace(search.paper_design(space, device, chosen, folder), baseline_ms=rows[0].baseline_ms)
    standing = Standing.of(paper, front)
    document = {
        "schema": "orbsoc.hardware-design/1",
        "provenance": "modelled",
        "workload": search.origin(space.ordering[0], folder),
        "device": platform.name,
        "space": asdict(space),
        "designs": len(rows),
        "left_out": sum(task.rows for task in tasks) - len(rows),
        "schedules": len(space.shapes) * len(works[0].problems),
        "fitting": sum(row.fits for row in rows),
        "front": [asdict(row) for row in front],
        "paper": standing.to_dict(),
        "baseline_ms": standing.paper.baseline_ms,
        "seconds": report.elapsed_s,
        "assumptions": options.echoed(platform, reading),
    }
    options.write_all(
        folder,
        {
            "design.json": options.as_json_text(document),
            "designs.csv": options.as_csv_text([asdict(row) for row in rows]),
            "front.csv": options.as_csv_text([asdict(row) for row in front]),
        },
    )
    title = f"Designs for {document['workload']} on {platform.name}"
    design_figure(rows, front, standing.paper, title, folder / "design.png")
    return rows, standing, document


def _lines(rows: list[Row], standing: Standing, document: dict[str, Any]) -> list[str]:
    """The front, fastest first, and where the paper's design lies."""
    from hw_model.report.design import front_of

    front = front_of(rows)
    left = f"; {document['left_out']} that rtl/ cannot stream are left out" if document["left_out"] else ""
    return [
        f"modelled: {document['workload']} on {document['device']}: {len(rows)} designs from"
        f" {document['schedules']} schedules, {document['fitting']} fit, {len(front)} on the front{left}",
        *(row.words for row in front),
        f"the PS alone takes {standing.paper.baseline_ms:.3f} ms",
        standing.words,
    ]
