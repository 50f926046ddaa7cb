"""`orbsoc plan`: scenario → mission by its key → plan → check → price → write.

`orbsoc.plan_file` is the same for a Python user, who reads its result instead of the files:

>>> run = orbsoc.plan_file("scenarios/rec1.toml", out="out/rec1")  # doctest: +SKIP
>>> run.plan.status  # doctest: +SKIP
<PlanStatus.VERIFIED: 'verified'>
"""

from __future__ import annotations

import enum
import json
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager, nullcontext
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from orbsoc.files.interrupts import Interrupts

from . import hw_options as options
from .failures import FAILED, exit_handling
from .plan_cases import plan_cases

if TYPE_CHECKING:
    from orbsoc.guidance.mission import Agreement, Mission, Plan
    from orbsoc.guidance.scenario_file import BaseScenario
    from orbsoc.guidance.scp import Iteration
    from orbsoc.hw.cycle_budget import CycleBudget
    from orbsoc.hw.emulation import PsScheduler
    from orbsoc.report.run import PlanRun

    Watch = Callable[[Mission], AbstractContextManager[Callable[[Iteration], None] | None]]


class CheckChoice(enum.StrEnum):
    """Solvers that can answer independently."""

    CLARABEL = "clarabel"


def plan(
    scenario: Annotated[Path, typer.Argument(help="scenario file, TOML", metavar="SCENARIO.toml")],
    problem: Annotated[str | None, typer.Option(help="short for --set problem=…")] = None,
    settings: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            help="override a key of the scenario, e.g. method.nodes=16; repeatable",
            metavar="KEY=VALUE",
        ),
    ] = None,
    device: Annotated[
        str, typer.Option(help="platform of the cycle budget: name or TOML file; none leaves it out")
    ] = "zu9eg",
    partition: Annotated[str, typer.Option(help="what runs on the PL: name or TOML file")] = "paper",
    deadline_ms: Annotated[
        float | None,
        typer.Option(help="judge the modelled time of the conic solves of the plan against this"),
    ] = None,
    cases: Annotated[
        int | None,
        typer.Option(help="plan this many dispersed cases instead, and judge the deadline over all of them"),
    ] = None,
    seed: Annotated[int | None, typer.Option(help="of the dispersion of --cases", show_default="0")] = None,
    resume: Annotated[
        bool, typer.Option("--resume", help="keep the cases of --cases that the folder has")
    ] = False,
    exact: Annotated[
        bool,
        typer.Option(
            "--exact/--estimate",
            help="cycles of the PL from schedules, equal to the RTL, or estimated",
            show_default=False,
        ),
    ] = True,
    check: Annotated[CheckChoice | None, typer.Option(help="plan again with another solver, compare")] = None,
    ps: Annotated[bool, typer.Option("--ps", help="plan on the emulated PS+PL computer")] = False,
    impulses: Annotated[
        Path | None,
        typer.Option(
            help="judge this programme instead of planning one: time_s,dv_r_m_s,dv_t_m_s,dv_n_m_s",
            metavar="FILE.csv",
        ),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(help="output folder; out/NAME or out/NAME-PROBLEM by default", metavar="DIR"),
    ] = None,
    report: Annotated[
        bool,
        typer.Option("--report/--no-report", help="figures and report.html, which take longer than the plan"),
    ] = True,
    verbose: Annotated[bool, typer.Option("--verbose", help="a table of all iterations")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="print plan.json on standard output")] = False,
) -> None:
    """Plan one mission, verify it by propagation, and price the computer that would have planned it.

    The verdict has one line a question. Exit codes: 0 where no word of it is bad, 1 where one is (not verified, not safe,
    a deadline missed, a check that disagrees), 2 bad input, 130 interrupted.
    """
    from hw_model import HwModelError

    with exit_handling(as_json):
        _refuse_idle_options(cases, seed=seed, resume=resume, check=check, ps=ps, no_report=not report)
        if cases is not None and device == "none":
            raise HwModelError(
                "--device none: --cases judges deadlines on a device; name one, or leave it out"
            )
    if cases is not None:
        if impulses is not None:
            raise typer.BadParameter(
                "--impulses judges one programme, and --cases plans many; give one of them"
            )
        plan_cases(
            lambda: _scenario(scenario, _overrides(problem, settings))[1],
            out if out is not None else Path("out") / f"{scenario.stem}-cases",
            count=cases, seed=seed or 0, resume=resume, device=device, partition=partition, deadline_ms=deadline_ms,
            exact=exact, as_json=as_json,
        )  # fmt: skip
    with Interrupts() as interrupts:
        with exit_handling(as_json, interrupted="interrupted; nothing was written", interrupts=interrupts):
            changes = _overrides(problem, settings)
            mission, chosen = _scenario(scenario, changes)
            folder = out if out is not None else _default_folder(scenario, chosen)
            run, document = plan_scenario(
                mission, chosen, folder, device=device, partition=partition, deadline_ms=deadline_ms, exact=exact,
                check=check is not None, ps=ps, impulses=impulses, report=report, interrupts=interrupts,
                file=(str(scenario), changes),
                watch=lambda each: _watch(each, as_json=as_json, verbose=verbose),
            )  # fmt: skip
        if as_json:
            typer.echo(json.dumps(document, allow_nan=False))
        _print_summary(run, folder, as_json)
        raise typer.Exit(0 if run.succeeded else FAILED)


def _refuse_idle_options(
    cases: int | None, *, seed: int | None, resume: bool, check: CheckChoice | None, ps: bool, no_report: bool
) -> None:
    """Raises HwModelError for an option that would do nothing."""
    from hw_model import HwModelError

    if cases is None:
        idle = [("--seed", seed is not None), ("--resume", resume)]
        reason = "belongs to dispersed cases; give --cases N, or leave it out"
    else:
        idle = [("--check", check is not None), ("--ps", ps), ("--no-report", no_report)]
        reason = "is for one plan, not for --cases; cases are planned on the emulated computer anyway"
    for name, given in idle:
        if given:
            raise HwModelError(f"{name} {reason}")


def plan_file(
    path: str | PathLike[str],
    *,
    settings: Mapping[str, Any] | None = None,
    out: str | PathLike[str] | None = None,
    **options: Any,
) -> PlanRun:
    """Plan a scenario file of any mission, price it, and write the folder `out` if one is given.

    `settings` override keys of the scenario, {"method.nodes": 16}; `options` are those of `plan_scenario`. Raises
    ScenarioError, `hw_model.HwModelError`, OutputFolderError, PropagationError; KeyboardInterrupt when interrupted.
    """
    mission, scenario = _scenario(Path(path), settings)
    options.setdefault("file", (str(path), settings or {}))
    return plan_scenario(mission, scenario, None if out is None else Path(out), **options)[0]


def plan_scenario(
    mission: Mission,
    scenario: BaseScenario,
    folder: Path | None,
    *,
    device: str = "zu9eg",
    partition: str = "paper",
    deadline_ms: float | None = None,
    exact: bool = True,
    check: bool = False,
    ps: bool = False,
    impulses: str | PathLike[str] | None = None,
    report: bool = True,
    file: tuple[str, Mapping[str, Any]] | None = None,
    interrupts: Interrupts | None = None,
    watch: Watch | None = None,
) -> tuple[PlanRun, dict[str, Any]]:
    """Plan, check, price, write into `folder`; with it the document of `plan.json`.

    Device "none" leaves the price out, `check` plans again with Clarabel, `ps` plans on the emulated computer, `impulses`
    is a file that is judged instead of planning, without `report` there are no figures and no page, `file` is the scenario's
    with its changed keys, for the commands in the verdict, `watch` gives what sees each subproblem. Raises before or instead of writing anything, KeyboardInterrupt after any Ctrl-C.
    """
    from orbsoc.hw.schedules import EngineTooSmallError
    from orbsoc.report.run import PlanRun

    interrupts = interrupts or Interrupts()
    _check_before_planning(folder, device, partition, deadline_ms, exact=exact)
    if impulses is not None:
        found = _audited(scenario, impulses, check=check, ps=ps, deadline_ms=deadline_ms)
        run = PlanRun(mission, found, "nothing: the impulses were given", None, None, file=file)
        return run, _written(run, folder, interrupts, report=report)
    scheduler = _scheduler() if ps else None
    with watch(mission) if watch else nullcontext() as callback:
        found = _uninterrupted(mission.plan(scenario, solve=scheduler, callback=callback))
    interrupts.check()
    compared = _compared(mission, scenario, found) if check else None
    interrupts.check()
    budget, too_large = None, None
    if device != "none":
        try:
            budget = _priced(mission, scenario, found, scheduler, device, partition, deadline_ms, exact=exact)
        except EngineTooSmallError as error:
            too_large = device, str(error)
    interrupts.check()
    solver = "orbsoc on the emulated PS+PL computer" if ps else "orbsoc"
    run = PlanRun(mission, found, solver, budget, compared, too_large, file)
    return run, _written(run, folder, interrupts, report=report)


def _written(run: PlanRun, folder: Path | None, interrupts: Interrupts, *, report: bool) -> dict[str, Any]:
    """The document of a run, written into the folder if there is one."""
    from orbsoc.report.run import write_run

    document = run.to_dict()
    if folder is not None:
        write_run(folder, run, document, report=report, commit=interrupts.commit)
    return document


def _audited(
    scenario: BaseScenario, path: str | PathLike[str], *, check: bool, ps: bool, deadline_ms: float | None
) -> Plan:
    """The programme of a file, judged by the scenario's mission."""
    from hw_model import HwModelError
    from orbsoc.guidance.impulses import ImpulseProgramme
    from orbsoc.missions.registry import auditable

    idle = {"--check": check, "--ps": ps, "--deadline-ms": deadline_ms is not None}
    if any(idle.values()):
        names = ", ".join(name for name, given in idle.items() if given)
        raise HwModelError(f"{names} would do nothing here: with --impulses nothing is solved")
    return auditable(scenario).audit(scenario, ImpulseProgramme.read(path))


def _scenario(path: Path, settings: Mapping[str, Any] | None) -> tuple[Mission, BaseScenario]:
    from orbsoc.guidance.in_flight import idle_complaints
    from orbsoc.guidance.scenario_file import ScenarioError
    from orbsoc.missions.registry import load_scenario

    found = load_scenario(path, settings)
    if idle := idle_complaints(settings or ()):
        raise ScenarioError(str(path), idle)
    return found


def _overrides(problem: str | None, settings: list[str] | None) -> dict[str, Any]:
    """Values by key of the scenario. Raises HwModelError for what is no pair or set twice, and for a key of the computer."""
    from hw_model import HwModelError

    taken = None if problem is None else {"problem": "--problem"}
    given = options.parsed_settings(settings, taken, example="method.nodes=16")
    for key in given:
        if key.partition(".")[0] in COMPUTER:
            raise HwModelError(
                f"--set '{key}={given[key]}': sets a key of the scenario, and this is one of the computer;"
                " name a platform file (--device FILE.toml), or price the plan by `orbsoc hw trace` and its --set"
            )
    return given if problem is None else {"problem": problem, **given}


COMPUTER = ("ps", "pl", "link", "runtime", "area", "energy", "resources")
"""Tables of a platform; no scenario has one of these names."""


def _default_folder(path: Path, scenario: BaseScenario) -> Path:
    return Path("out") / "-".join(filter(None, (path.stem, scenario.variant)))


def _check_before_planning(
    folder: Path | None, device: str, partition: str, deadline_ms: float | None, *, exact: bool
) -> None:
    """Refuse now what would otherwise be refused after the work is done."""
    from hw_model import HwModelError
    from orbsoc.files.output_folder import check_replaceable, check_writable
    from orbsoc.hw.deadlines import check_deadline

    if folder is not None:
        check_replaceable(folder)
        check_writable(folder)
    if device != "none":
        from orbsoc.hw.cycle_budget import check_names

        check_names(device, partition, exact=exact)
    elif deadline_ms is not None:
        raise HwModelError(f"--deadline-ms = {deadline_ms}: there is no time to judge with --device none")
    check_deadline(deadline_ms)


def _scheduler() -> PsScheduler:
    from orbsoc.hw.emulation import PsScheduler

    return PsScheduler()


def _watch(
    mission: Mission, *, as_json: bool, verbose: bool
) -> AbstractContextManager[Callable[[Iteration], None]]:
    """The iterations as they happen: one line of progress, or all of them as a table."""
    from rich.console import Console

    from orbsoc.guidance.progress import iteration_table, progress_line

    if verbose:
        return iteration_table(Console(stderr=as_json), mission.COLUMNS)
    return progress_line(Console(stderr=True))


def _uninterrupted(found: Plan) -> Plan:
    """The plan; raises KeyboardInterrupt when it was interrupted."""
    from orbsoc.guidance.mission import PlanStatus

    if found.status is PlanStatus.INTERRUPTED:
        raise KeyboardInterrupt
    return found


def _compared(mission: Mission, scenario: BaseScenario, found: Plan) -> Agreement:
    """The comparison with the same plan made by Clarabel."""
    from orbsoc.guidance.mission import Agreement
    from orbsoc.interfaces.clarabel import solve

    return Agreement.of(found, _uninterrupted(mission.plan(scenario, solve=solve)))


def _priced(
    mission: Mission,
    scenario: BaseScenario,
    found: Plan,
    scheduler: PsScheduler | None,
    device: str,
    partition: str,
    deadline_ms: float | None,
    *,
    exact: bool,
) -> CycleBudget | None:
    """What every subproblem costs the computer; None where there is none."""
    from orbsoc.guidance.mission import PlanStatus
    from orbsoc.hw.cycle_budget import cycle_budget
    from orbsoc.hw.outer_loop import outer_loop_of

    if not found.subproblems:
        return None
    return cycle_budget(
        found.subproblems,
        device=device,
        partition=partition,
        deadline_ms=deadline_ms,
        verified=found.status is PlanStatus.VERIFIED,
        scheduled=scheduler,
        exact=exact,
        outer_loop=outer_loop_of(mission, scenario, found),
    )


def _print_summary(run: PlanRun, folder: Path, as_json: bool) -> None:
    """The verdict's lines, last, where the eye is; on standard error beside JSON."""
    from rich.console import Console

    console = Console(stderr=as_json)
    words = f"{run.verdict}\nwritten to {folder}"
    console.print(words, markup=False, highlight=False, soft_wrap=True)
