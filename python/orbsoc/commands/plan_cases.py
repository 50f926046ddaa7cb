"""`orbsoc plan … --cases N`: the deadline verdict over dispersed cases of one scenario."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

import typer

from . import hw_options as options
from .failures import FAILED, INTERRUPTED, exit_handling, exit_with

if TYPE_CHECKING:
    from orbsoc.guidance.scenario_file import BaseScenario
    from orbsoc.hw.deadlines import Case, DeadlineReport

EVERY = 10
"""Without a terminal, one line of progress for this many cases."""


def plan_cases(
    load: Callable[[], BaseScenario],
    folder: Path,
    *,
    count: int,
    seed: int,
    resume: bool,
    device: str,
    partition: str,
    deadline_ms: float | None,
    exact: bool,
    as_json: bool,
) -> NoReturn:
    """Plan `count` dispersed cases of the scenario that `load` gives, price and judge them; leaves by typer.Exit.

    Exit codes: 0 PASS or MARGINAL, 1 FAIL or an engine that does not fit into the device, 2 bad input, 130 interrupted (finished cases stay for --resume).
    """
    with exit_handling(as_json):
        from hw_model import HwModelError
        from hw_model.platform.partition import load_partition
        from hw_model.report.usage import WORST_CASE_USAGE
        from hw_model.timing.schedules import engine_of
        from orbsoc.guidance.monte_carlo import CLIP_SIGMA
        from orbsoc.hw.deadlines import check_deadline, estimated_cycles, exact_cycles_of, judge, record_cases
        from orbsoc.missions.registry import dispersible

        scenario = load()
        dispersion = dispersible(scenario).DISPERSION
        platform, split = options.computer(device, None), load_partition(partition)
        if deadline_ms is None:
            raise HwModelError("--cases judges a deadline: give --deadline-ms")
        check_deadline(deadline_ms)
        if count < 1:
            raise HwModelError(f"--cases = {count}: must be at least 1")
        if exact and split.uses_pl:
            engine_of(platform, "f64")  # refuse now what has no schedules
        if not resume and any((folder / "cases").glob("case-*")):
            raise HwModelError(
                f"--out = {folder}: holds cases already; --resume goes on with them, or give another folder"
            )
        try:
            with Progress(count) as watch:
                cases = record_cases(scenario, count, seed, folder / "cases", resume=resume, progress=watch)
        except KeyboardInterrupt:
            exit_with(
                INTERRUPTED,
                f"interrupted; finished cases are in {folder / 'cases'}, --resume goes on",
                as_json,
            )
        cycles_of = exact_cycles_of(cases, folder / "cases") if exact else estimated_cycles
        report = judge(cases, platform, split, deadline_ms, cycles_of)
        document = report.to_dict() | {
            "scenario": scenario.model_dump(mode="json"),
            "seed": seed,
            "dispersion": {
                "tag": dispersion.source,
                "sigma": dispersion.to_dict(),
                "clip_sigma": CLIP_SIGMA,
            },
            "assumptions": options.echoed(
                platform,
                replace(
                    WORST_CASE_USAGE,
                    questions=frozenset({"times", "worst"}),
                    on_pl=split.uses_pl,
                    scheduled=exact and split.uses_pl,
                ),
            ),
        }
        options.write_all(
            folder,
            {
                "deadline.json": options.as_json_text(document),
                "deadline.csv": options.as_csv_text([asdict(row) for row in report.cases]),
            },
        )
        _draw(report, folder / "deadline.png")
        options.print_report(_lines(report), document, folder, as_json=as_json)
        raise typer.Exit(0 if report.verdict != "FAIL" and report.fits else FAILED)


def _lines(report: DeadlineReport) -> list[str]:
    document = report.to_dict()
    times, worst = document["time_ms"], document["worst_ms"]
    lines = [
        f"SCP iterations: {_tally(document['scp_iterations'])}",
        f"IPM iterations of a whole plan: {_tally(document['ipm_iterations'])}",
    ]
    if times["min"] is not None:
        lines.append("modelled ms     min      p50      p95      p99      max")
        for name, row in (("nominal", times), ("worst case", worst)):
            lines.append(
                f"{name:11s}" + "".join(f"{row[key]:9.3f}" for key in ("min", "p50", "p95", "p99", "max"))
            )
    return [*lines, report.headline]


def _tally(counts: dict[str, int]) -> str:
    return ", ".join(f"{value} ({count}×)" for value, count in counts.items())


def _draw(report: DeadlineReport, path: Path) -> None:
    from hw_model.figures.deadline import deadline_figure

    planned = [case for case in report.cases if case.status == "verified"]
    if planned:
        title = f"Modelled: {report.partition} on {report.device}, {len(planned)} cases: {report.verdict}"
        title += "" if report.fits else "; the engine does not fit"
        nominal, worst = [case.time_ms for case in planned], [case.worst_ms for case in planned]
        deadline_figure(nominal, worst, report.deadline_ms, title, path)


class Progress:
    """A bar on a terminal, plain lines elsewhere, both on standard error; called with each finished case."""

    def __init__(self, count: int) -> None:
        from rich.console import Console
        from rich.progress import Progress as Bar

        self._count, self._done = count, 0
        self._console = Console(stderr=True)
        self._bar = Bar(console=self._console, disable=not self._console.is_terminal)
        self._task = self._bar.add_task("cases", total=count)

    def __enter__(self) -> Progress:
        self._bar.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._bar.stop()

    def __call__(self, case: Case) -> None:
        self._done += 1
        self._bar.update(self._task, completed=self._done)
        if not self._console.is_terminal and (self._done % EVERY == 0 or self._done == self._count):
            line = f"case {self._done} of {self._count}: {case.status}, {sum(case.ipm_iterations)} iterations"
            self._console.print(line, markup=False, highlight=False, soft_wrap=True)
