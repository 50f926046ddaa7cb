"""`orbsoc fly`: a mission in a closed loop, on a computer whose time counts; once, or many times."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from orbsoc.files.interrupts import Interrupts

from . import hw_options as options
from .failures import FAILED, exit_handling
from .fly_runs import check_computer, executor_of, fly_runs, timing_of

if TYPE_CHECKING:
    from orbsoc.fly.record import FlightRun
    from orbsoc.guidance.scenario_file import BaseScenario


def fly(
    scenario: Annotated[Path, typer.Argument(help="scenario file, TOML", metavar="SCENARIO.toml")],
    seed: Annotated[int, typer.Option(help="of all errors", min=0)] = 0,
    flight: Annotated[
        int | None,
        typer.Option(
            "--flight",
            help="fly this one of the dispersed flights; 0 has errors of navigation alone",
            min=0,
            show_default="0",
        ),
    ] = None,
    device: Annotated[
        str, typer.Option(help="platform of the computer on board: name or TOML file")
    ] = "zu9eg",
    partition: Annotated[str, typer.Option(help="what runs on the PL: name or TOML file")] = "paper",
    deadline_ms: Annotated[
        float | None,
        typer.Option(
            help="window of every answer: one that comes later is not flown; without it that of a period is its length"
        ),
    ] = None,
    slower: Annotated[
        float, typer.Option(help="the computer is this many times as slow as it is modelled")
    ] = 1.0,
    runs: Annotated[
        int | None, typer.Option(help="fly this many dispersed flights instead of one", min=1)
    ] = None,
    workers: Annotated[
        int | None, typer.Option(help="processes for --runs; all cores by default", min=1)
    ] = None,
    dask: Annotated[
        str | None,
        typer.Option(
            help="address of a Dask scheduler for --runs, tcp://HOST:PORT, or 'embedded'", metavar="URL"
        ),
    ] = None,
    resume: Annotated[
        bool, typer.Option("--resume", help="keep the flights of --runs that the folder has")
    ] = False,
    settings: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            help="override a key of the scenario, e.g. event.at_s=20; repeatable",
            metavar="KEY=VALUE",
        ),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(help="output folder; out/NAME-flight or out/NAME-flights by default", metavar="DIR"),
    ] = None,
    report: Annotated[
        bool, typer.Option("--report/--no-report", help="figures, and of one flight report.html")
    ] = True,
    as_json: Annotated[bool, typer.Option("--json", help="print flight.json on standard output")] = False,
) -> None:
    """Fly a mission with its guidance cycle: each re-plan is solved, priced on the computer, and flown when it is ready.

    Exit codes: 0 where no word of the verdict is bad, 1 where one is, 2 bad input, 130 interrupted.
    """
    with exit_handling(as_json):
        _refuse_idle_options(runs, workers=workers, dask=dask, resume=resume, flight=flight)
    if runs is not None:
        fly_runs(
            lambda: _scenario(scenario, settings),
            out if out is not None else Path("out") / f"{scenario.stem}-flights",
            runs=runs, seed=seed, device=device, partition=partition, deadline_ms=deadline_ms, slower=slower,
            executor=lambda: executor_of(dask, workers), resume=resume, report=report, as_json=as_json,
        )  # fmt: skip
    with Interrupts() as interrupts:
        with exit_handling(as_json, interrupted="interrupted; nothing was written", interrupts=interrupts):
            chosen = _scenario(scenario, settings)
            folder = out if out is not None else Path("out") / f"{scenario.stem}-flight"
            check_computer(device, partition, deadline_ms, slower)
            _check(folder)
            run = flown(
                chosen, seed=seed, number=flight or 0, device=device, partition=partition,
                deadline_ms=deadline_ms, slower=slower,
            )  # fmt: skip
            interrupts.check()
            document = run.to_dict()
            _write(folder, run, document, interrupts, report=report)
        if as_json:
            typer.echo(json.dumps(document, allow_nan=False))
        typer.echo(f"{run.verdict}\nwritten to {folder}", err=as_json)
        raise typer.Exit(0 if run.verdict.succeeded else FAILED)


def flown(
    scenario: BaseScenario,
    *,
    seed: int = 0,
    number: int = 0,
    device: str = "zu9eg",
    partition: str = "paper",
    deadline_ms: float | None = None,
    slower: float = 1.0,
) -> FlightRun:
    """One flight, the same without re-planning, and the slowest computer that would do.

    Raises ScenarioError for a mission without a loop, HwModelError for what no computer is, KeyboardInterrupt.
    """
    from orbsoc.fly.computer import Computer
    from orbsoc.fly.loop import fly as fly_once
    from orbsoc.fly.record import FlightRun
    from orbsoc.fly.slower import enough_for
    from orbsoc.fly.solver import OnboardSolver
    from orbsoc.missions.registry import flyable

    solver, computer = OnboardSolver(), Computer(device, partition, slower)
    loop = flyable(scenario).closed_loop(scenario, solver)
    timing = timing_of(loop, deadline_ms)
    found = fly_once(loop, computer, solver, timing, seed=seed, number=number)
    still = fly_once(loop, None, solver, timing, seed=seed, number=number)
    enough = enough_for(loop, found, computer, solver, timing)
    return FlightRun(scenario, loop, found, still, computer, timing, enough)


def _scenario(path: Path, settings: list[str] | None) -> BaseScenario:
    from orbsoc.missions.registry import flyable, load_scenario

    changes = options.parsed_settings(settings, example="event.at_s=20")
    _, chosen = load_scenario(path, changes)
    flyable(chosen)  # refuse now a mission without a loop
    return chosen


def _refuse_idle_options(
    runs: int | None, *, workers: int | None, dask: str | None, resume: bool, flight: int | None
) -> None:
    """Raises HwModelError for an option that would do nothing."""
    from hw_model import HwModelError

    if runs is None:
        idle = {"--workers": workers is not None, "--dask": dask is not None, "--resume": resume}
        reason = "is of many flights; give --runs N, or leave it out"
    else:
        idle, reason = {"--flight": flight is not None}, "is of one flight; leave out --runs, or it"
    for name, given in idle.items():
        if given:
            raise HwModelError(f"{name} {reason}")


def _check(folder: Path) -> None:
    """Refuse now what would otherwise be refused after the work is done."""
    from orbsoc.files.output_folder import check_replaceable, check_writable

    check_replaceable(folder)
    check_writable(folder)


def _write(
    folder: Path, run: FlightRun, document: dict[str, Any], interrupts: Interrupts, *, report: bool
) -> None:
    from orbsoc.files.output_folder import write_manifest, written_at_once
    from orbsoc.fly.figures import draw_flight
    from orbsoc.fly.record import cycle_row

    with written_at_once(folder) as place:
        rows = [cycle_row(each) for each in run.flight.cycles]
        (place / "cycles.csv").write_text(options.as_csv_text(rows), encoding="utf-8")
        if report:
            from orbsoc.report.page import render

            figures = draw_flight(run, place)
            page = render("flight.html.j2", figures, place, flight=document, succeeded=run.verdict.succeeded)
            (place / "report.html").write_text(page, encoding="utf-8")
            document["figures"] = [{"name": each.name, "caption": each.caption} for each in figures]
        write_manifest(place, document, "flight.json")
        interrupts.commit()
