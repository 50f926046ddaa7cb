"""`orbsoc reach`: the reachable domain of a scenario, into a folder that survives interruptions.

Exit codes: 0 done, 1 some point's solver failed or the sweep could not go on, 2 bad input, 130 interrupted (what is
finished stays; `--resume` goes on).
"""

from __future__ import annotations

import json
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
import typer

from orbsoc.files.interrupts import Interrupts

from .failures import FAILED, exit_handling

if TYPE_CHECKING:
    from orbsoc.missions.reachable_domain import Scenario
    from orbsoc.sweep import Executor


def reach(
    scenario: Annotated[Path, typer.Argument(help="scenario file, TOML", metavar="SCENARIO.toml")],
    resume: Annotated[bool, typer.Option("--resume", help="go on in a folder of this scenario")] = False,
    threads: Annotated[
        int | None, typer.Option(help="worker processes of this machine; all cores by default", min=1)
    ] = None,
    dask: Annotated[
        str | None,
        typer.Option(help="address of a Dask scheduler, tcp://HOST:PORT, or 'embedded'", metavar="URL"),
    ] = None,
    device: Annotated[str, typer.Option(help="platform of the cost: name or TOML file")] = "zu9eg",
    partition: Annotated[str, typer.Option(help="what runs on the PL: name or TOML file")] = "paper",
    deadline_ms: Annotated[
        float | None, typer.Option(help="say how many points the modelled computer does in this time")
    ] = None,
    ephemeris: Annotated[
        str | None,
        typer.Option(
            help="also write this grid point's burn and orbit as CCSDS messages: 'inclination node perigee', deg deg km"
        ),
    ] = None,
    report: Annotated[
        bool,
        typer.Option(
            "--report/--no-report",
            help="figures, pages with the cost on every device, and NetCDF; without them, --resume writes them later",
        ),
    ] = True,
    out: Annotated[
        Path | None, typer.Option(help="results folder; out/NAME by default", metavar="DIR")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="print summary.json on standard output")] = False,
) -> None:
    """Solve every point of the grid and the edge of the domain, verify by propagation, and show what is within reach."""
    from .sweep_progress import executor_of

    folder = out if out is not None else Path("out") / scenario.stem
    interrupted = f"interrupted; finished shards are in {folder}, --resume goes on"
    with (
        Interrupts() as interrupts,
        exit_handling(as_json, interrupted=interrupted, interrupts=interrupts),
    ):
        executor = executor_of(dask, threads)
        chosen = _checked(scenario, device, partition, deadline_ms)
        point = None if ephemeris is None else _point(ephemeris, chosen)
        document = _solve_and_write(
            chosen,
            folder,
            executor,
            resume,
            (device, partition, deadline_ms),
            as_json,
            interrupts,
            report=report,
        )
        if point is not None:
            _write_messages(folder, point)
    if as_json:
        typer.echo(json.dumps(document, allow_nan=False, default=float))
    for line in _lines(document, folder):
        typer.echo(line, err=as_json)
    raise typer.Exit(FAILED if document["status"].get("solver failed") else 0)


def _checked(path: Path, device: str, partition: str, deadline_ms: float | None) -> Scenario:
    """The scenario, after all checks that need no solve."""
    from orbsoc.hw.cycle_budget import check_names
    from orbsoc.hw.deadlines import check_deadline
    from orbsoc.missions.reachable_domain import load_scenario

    chosen = load_scenario(path)
    check_names(device, partition)
    check_deadline(deadline_ms)
    return chosen


def _point(text: str, scenario: Scenario) -> tuple[float, float, float]:
    """Inclination, node (deg) and perigee bound (km). Raises StoreError for anything but three numbers of the grid."""
    from orbsoc.sweep import StoreError

    try:
        inc, raan, height = (float(word) for word in text.replace(",", " ").split())
    except ValueError as error:
        raise StoreError(
            f"--ephemeris = {text!r}: must be three numbers: inclination (deg), node (deg), perigee bound (km)"
        ) from error
    grid = scenario.grid
    axes = (
        ("inclination", inc, grid.inclination_deg),
        ("node", raan, grid.raan_deg),
        ("perigee bound", height, grid.perigee_height_km),
    )
    for name, value, span in axes:
        turns = 360.0 if name == "node" else np.inf
        away = np.abs(span.values() - value)
        if not np.minimum(away, np.abs(away - turns)).min() < 1e-6:
            raise StoreError(
                f"--ephemeris = {text!r}: {name} {value:g} is not on the grid: {span.first:g} to {span.last:g} in steps"
                f" of {span.step:g}"
            )
    return inc, raan, height


def _write_messages(folder: Path, point: tuple[float, float, float]) -> None:
    """Write point.oem and point.opm. Raises StoreError when the point has no plan."""
    from orbsoc.missions.reachable_domain.record.ephemeris import fly_point, oem, opm
    from orbsoc.reach import load
    from orbsoc.sweep import StoreError

    found = load(folder)
    try:
        flown = fly_point(found, *point)
    except ValueError as error:
        raise StoreError(f"--ephemeris: {error}") from error
    (folder / "point.oem").write_text(oem(flown), encoding="utf-8")
    (folder / "point.opm").write_text(opm(flown), encoding="utf-8")


def _solve_and_write(
    scenario: Scenario,
    folder: Path,
    executor: Executor,
    resume: bool,
    hardware: tuple[str, str, float | None],
    as_json: bool,
    interrupts: Interrupts,
    *,
    report: bool,
) -> dict[str, Any]:
    from rich.console import Console
    from rich.progress import track

    import hw_model
    from orbsoc.hw.representative_solves import RepresentativeSolves
    from orbsoc.missions.reachable_domain.record.cost import DomainCost, representative_subproblems
    from orbsoc.missions.reachable_domain.record.outputs import write_outputs
    from orbsoc.missions.reachable_domain.record.results_folder import solve_into
    from orbsoc.reach import load
    from orbsoc.report.page import render
    from orbsoc.sweep import StoreError

    from .sweep_progress import SweepProgress

    with SweepProgress(Console(stderr=as_json)) as progress:
        reports = solve_into(folder, scenario, executor, progress, resume=resume)
    interrupts.check()
    found = load(folder)
    device, partition, deadline_ms = hardware
    solves = {
        nodes: RepresentativeSolves.of(problems)
        for nodes, problems in representative_subproblems(found).items()
    }

    def cost_on(device: str, partition: str, deadline_ms: float | None = None) -> DomainCost:
        prices = {nodes: solve.price(device, partition) for nodes, solve in solves.items()}
        return DomainCost.of(found, device, partition, prices, deadline_ms)

    cost = cost_on(device, partition, deadline_ms)
    pairs = list(product(hw_model.platform_names(), hw_model.partition_names())) if report else []
    priced = track(pairs, "pricing every device and partition", console=Console(stderr=True), transient=True)
    fresh = sum(report.rows_done - report.rows_before for report in reports)
    extra = {
        "elapsed_s": sum(report.elapsed_s for report in reports) if fresh else None,
        "rows_solved_in_this_run": fresh,
        "hardware": {**cost.to_dict(), "words": cost.words},
        "hardware_table": [cost_on(*names).to_dict() for names in priced],
    }
    try:
        return write_outputs(folder, found, cost, extra, render if report else None)
    except OSError as error:
        raise StoreError(
            f"--out = {folder}: tables and figures cannot be written: {error.strerror or error}; all shards are kept,"
            " --resume writes them"
        ) from error


def _lines(document: dict[str, Any], folder: Path) -> list[str]:
    """What a person wants to know, the verdict last."""
    counts = ", ".join(f"{count} {name}" for name, count in document["status"].items())
    worst = document["worst"]
    lines = [_limit(row) for row in document["envelope"] or document["limits"]]
    if document["status"].get("reached"):
        lines.append(
            f"every reached point flown: semi-major axis within {worst['sma_error_rel']:.1e}, plane within"
            f" {worst['plane_error_rad']:.1e} rad,"
            f" bounds within {max(worst['perigee_short_m'], worst['altitude_short_m']):.2f} m"
        )
    lines.append(document["hardware"]["words"])
    if document["elapsed_s"] is not None:
        lines.append(
            f"{document['rows_solved_in_this_run']} rows solved in {document['elapsed_s']:.1f} s (measured)"
        )
    return [*lines, f"written to {folder}", f"{document['points']} points: {counts}"]


def _limit(row: dict[str, Any]) -> str:
    """A limit of the planes within reach, beside the paper's where it is the paper's case; an edge that is not drawn has
    no number."""
    ours = "no edge"
    if row["whole_deg"] is not None:
        ours = f"{row['whole_deg']:.2f} deg (± {row['whole_error_deg']:.3f})"
    if "paper_deg" not in row:
        return f"{row['limit']}: {ours}"
    return f"{row['limit']}: {ours}, paper {row['paper_deg']:.2f} deg; {row['reason']}"
