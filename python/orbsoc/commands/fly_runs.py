"""`orbsoc fly … --runs N`: many flights on many processes, into a folder that survives interruptions; and what both forms share."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

import typer

from orbsoc.files.interrupts import Interrupts

from . import hw_options as options
from .failures import FAILED, exit_handling

if TYPE_CHECKING:
    from orbsoc.fly.loop import Timing
    from orbsoc.guidance.closed_loop import ClosedLoop
    from orbsoc.guidance.scenario_file import BaseScenario
    from orbsoc.sweep import Executor


def executor_of(dask: str | None, workers: int | None) -> Executor:
    """Processes, or a Dask cluster."""
    from .sweep_progress import executor_of as made

    return made(dask, workers)


def timing_of(loop: ClosedLoop, deadline_ms: float | None) -> Timing:
    """The allowance of the loop, no longer than the window."""
    from orbsoc.fly.loop import Timing

    window_s = None if deadline_ms is None else 1e-3 * deadline_ms
    return Timing(loop.allowance_s if window_s is None else min(loop.allowance_s, window_s), window_s)


def check_computer(device: str, partition: str, deadline_ms: float | None, slower: float) -> None:
    """Refuse what no computer is. Raises HwModelError."""
    from hw_model import HwModelError
    from orbsoc.hw.cycle_budget import check_names
    from orbsoc.hw.deadlines import check_deadline

    check_names(device, partition)
    check_deadline(deadline_ms)
    if not 0.0 < slower < float("inf"):
        raise HwModelError(f"--slower = {slower:g}: must be a positive number; 10 is ten times as slow")


def fly_runs(
    load: Callable[[], BaseScenario],
    folder: Path,
    *,
    runs: int,
    seed: int,
    device: str,
    partition: str,
    deadline_ms: float | None,
    slower: float,
    executor: Callable[[], Executor],
    resume: bool,
    report: bool,
    as_json: bool,
) -> NoReturn:
    """Fly `runs` dispersed flights of the scenario that `load` gives; leaves by typer.Exit.

    Exit codes: 0 where no word of the verdict is bad, 1 where one is, 2 bad input, 130 interrupted (finished flights stay for
    --resume).
    """
    interrupted = f"interrupted; finished flights are in {folder}, --resume goes on"
    with (
        Interrupts() as interrupts,
        exit_handling(as_json, interrupted=interrupted, interrupts=interrupts),
    ):
        from rich.console import Console

        from orbsoc.fly.many import Study, cost_of_delay, fly_many, read_flights, summary
        from orbsoc.fly.many_verdict import verdict_of_many
        from orbsoc.fly.solver import OnboardSolver
        from orbsoc.missions.registry import flyable

        from .sweep_progress import SweepProgress

        scenario = load()
        check_computer(device, partition, deadline_ms, slower)
        loop = flyable(scenario).closed_loop(scenario, OnboardSolver())  # refuse now what cannot be flown
        timing = timing_of(loop, deadline_ms)
        study = Study(scenario.model_dump(mode="json"), device, partition, slower, timing, runs, seed)
        with SweepProgress(Console(stderr=True)) as progress:
            fly_many(study, folder, executor(), progress, resume=resume)
        interrupts.check()
        found = read_flights(folder)
        delays = cost_of_delay(study, interrupts.check) if report else []
        document = summary(study, scenario, found) | {"delays": [vars_of(each) for each in delays]}
        verdict = verdict_of_many(study, document)
        document["verdict"] = verdict.to_list()
        files = {
            "flights.csv": options.as_csv_text(_rows(found)),
            "flights.json": options.as_json_text(document),
        }
        options.write_all(folder, files)
        if report:
            from orbsoc.fly.many_figures import draw_many

            draw_many(study, found, delays, loop.shown, folder)
    options.print_report([*_table(document), str(verdict)], document, folder, as_json=as_json)
    raise typer.Exit(0 if verdict.succeeded else FAILED)


def vars_of(row: Any) -> dict[str, Any]:
    """A record as a dictionary."""
    from dataclasses import asdict

    return asdict(row)


def _rows(found: dict[str, Any]) -> list[dict[str, Any]]:
    """A row of flights.csv a flight: its figures, without the lists of its re-plans."""
    names = [name for name, values in found.items() if values.dtype != object]
    return [{name: found[name][k].item() for name in names} for k in range(found["flight"].size)]


def _table(document: dict[str, Any]) -> list[str]:
    """How flights ended: standard deviation and largest, with and without re-planning."""
    width = max(map(len, document["ends"]), default=0)
    lines = [f"{'end of a flight':{width}}  with: mean       std      without: mean       std"]
    for name, row in document["ends"].items():
        numbers = [row[side][of] for side in ("with", "without") for of in ("mean", "std")]
        lines.append(f"{name:{width}}" + "".join(f"{value:12.4g}" for value in numbers))
    return lines
