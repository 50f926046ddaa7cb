"""The command `orbsoc`: reads arguments, runs, prints; every answer comes from the packages below it.

Exit codes: 0 done, 1 the plan or a check failed (its reason is printed), 2 bad input, 130 interrupted. A missed
deadline is a finding about the computer, printed and written, and leaves the exit code as it is.
"""

from __future__ import annotations

import enum
import json
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from orbsoc.files.interrupts import Interrupts

from . import hw as hw_commands
from . import reach as reach_command
from . import solve as solve_command
from .console_entry import ConsoleApp
from .failures import FAILED, exit_handling
from .plan_cases import plan_cases

if TYPE_CHECKING:
    from orbsoc.guidance.scp import Solve
    from orbsoc.hw.emulation import PsScheduler
    from orbsoc.missions.reachable_insertion import Plan, Scenario
    from orbsoc.missions.reachable_insertion.agreement import Agreement
    from orbsoc.report.page import Run

app = ConsoleApp(
    help="Can this spacecraft re-plan its orbit on this chip, before this deadline?",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)


class ProblemChoice(enum.StrEnum):
    """Problems of a scenario."""

    MIN_TIME = "min_time"
    MAX_ENERGY = "max_energy"


class DirectionChoice(enum.StrEnum):
    """Whether the perigee direction is the target's or free."""

    FIXED = "fixed"
    FREE = "free"


class CheckChoice(enum.StrEnum):
    """Solvers that can answer independently."""

    CLARABEL = "clarabel"


class SchemaChoice(enum.StrEnum):
    """Files that have a JSON Schema."""

    SCENARIO = "scenario"
    REACH_SCENARIO = "reach-scenario"


@dataclass(frozen=True, slots=True)
class Hardware:
    """Which computer to price the plan on, and the deadline to judge it by."""

    device: str
    partition: str
    deadline_ms: float | None
    exact: bool


@app.callback()
def main() -> None:
    """Can this spacecraft re-plan its orbit on this chip, before this deadline?"""


app.command()(solve_command.solve)
app.add_typer(hw_commands.app, name="hw")
app.command()(reach_command.reach)


@app.command()
def plan(
    scenario: Annotated[Path, typer.Argument(help="scenario file, TOML", metavar="SCENARIO.toml")],
    problem: Annotated[ProblemChoice | None, typer.Option(help="override the scenario's problem")] = None,
    perigee_direction: Annotated[
        DirectionChoice | None, typer.Option(help="override the scenario's target.perigee_direction")
    ] = None,
    nodes: Annotated[int | None, typer.Option(help="override the scenario's method.nodes")] = None,
    device: Annotated[str, typer.Option(help="platform of the cycle budget: name or TOML file")] = "zu9eg",
    partition: Annotated[str, typer.Option(help="what runs on the PL: name or TOML file")] = "paper",
    deadline_ms: Annotated[
        float | None,
        typer.Option(
            help="judge the modelled time of the conic solves of the plan against this;"
            " a missed deadline does not change the exit code"
        ),
    ] = None,
    cases: Annotated[
        int | None,
        typer.Option(help="plan this many dispersed cases instead, and judge the deadline over all of them"),
    ] = None,
    seed: Annotated[int, typer.Option(help="of the dispersion")] = 0,
    resume: Annotated[bool, typer.Option("--resume", help="keep the cases that the folder has")] = False,
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
    out: Annotated[
        Path | None, typer.Option(help="output folder; out/NAME-PROBLEM by default", metavar="DIR")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="print plan.json on standard output")] = False,
) -> None:
    """Plan one mission, verify it by propagation, and price the computer that would have planned it.

    Exit codes: 0 verified, 1 not verified or a check failed, 2 bad input, 130 interrupted.
    """
    if cases is not None:
        plan_cases(
            lambda: _scenario(scenario, problem, perigee_direction, nodes),
            out if out is not None else Path("out") / f"{scenario.stem}-cases",
            count=cases, seed=seed, resume=resume, device=device, partition=partition, deadline_ms=deadline_ms,
            exact=exact, as_json=as_json,
        )  # fmt: skip
    with Interrupts() as interrupts:
        with exit_handling(as_json, interrupted="interrupted; nothing was written", interrupts=interrupts):
            chosen = _scenario(scenario, problem, perigee_direction, nodes)
            folder = out if out is not None else Path("out") / f"{scenario.stem}-{chosen.problem}"
            hardware = Hardware(device, partition, deadline_ms, exact)
            run, document = _plan_and_write(chosen, folder, hardware, check, ps, as_json, interrupts)
        if as_json:
            typer.echo(json.dumps(document, allow_nan=False))
        _print_summary(document, folder, as_json)
        raise typer.Exit(0 if _succeeded(run) else FAILED)


@app.command()
def schema(what: Annotated[SchemaChoice, typer.Argument(help="which file")]) -> None:
    """Print the JSON Schema of a file that orbsoc reads: of `orbsoc plan`, or of `orbsoc reach`."""
    from pydantic import BaseModel

    from orbsoc.missions import reachable_domain, reachable_insertion

    models: dict[SchemaChoice, type[BaseModel]] = {
        SchemaChoice.SCENARIO: reachable_insertion.Scenario,
        SchemaChoice.REACH_SCENARIO: reachable_domain.Scenario,
    }
    typer.echo(json.dumps(models[what].model_json_schema(), indent=2))


def _plan_and_write(
    scenario: Scenario,
    folder: Path,
    hardware: Hardware,
    check: CheckChoice | None,
    ps: bool,
    as_json: bool,
    interrupts: Interrupts,
) -> tuple[Run, dict[str, Any]]:
    """Plan, check, price, write; raises before or instead of writing anything, KeyboardInterrupt after any Ctrl-C."""
    from orbsoc.hw.cycle_budget import cycle_budget
    from orbsoc.missions.reachable_insertion import PlanStatus
    from orbsoc.report.page import Run, run_document, write_run

    _check_before_planning(folder, hardware)
    scheduler = _scheduler() if ps else None
    found = _planned(scenario, scheduler, as_json)
    interrupts.check()
    compared = _checked(found, check)
    interrupts.check()
    budget = cycle_budget(
        found.iterations,
        device=hardware.device,
        partition=hardware.partition,
        deadline_ms=hardware.deadline_ms,
        verified=found.status is PlanStatus.VERIFIED,
        scheduled=scheduler,
        exact=hardware.exact,
    )
    interrupts.check()
    solver = "orbsoc on the emulated PS+PL computer" if ps else "orbsoc"
    run = Run(found, solver, budget, compared)
    document = run_document(run)
    write_run(folder, run, document, commit=interrupts.commit)
    return run, document


def _scenario(
    path: Path, problem: ProblemChoice | None, direction: DirectionChoice | None, nodes: int | None
) -> Scenario:
    from orbsoc.missions.reachable_insertion import load_scenario

    return load_scenario(path).with_changes(
        problem=None if problem is None else problem.value,
        perigee_direction=None if direction is None else direction.value,
        nodes=nodes,
    )


def _check_before_planning(folder: Path, hardware: Hardware) -> None:
    """Refuse now what would otherwise be refused after the work is done."""
    from orbsoc.files.output_folder import check_replaceable
    from orbsoc.hw.cycle_budget import check_names
    from orbsoc.hw.deadlines import check_deadline

    check_replaceable(folder)
    check_names(hardware.device, hardware.partition, exact=hardware.exact)
    check_deadline(hardware.deadline_ms)


def _scheduler() -> PsScheduler:
    from orbsoc.hw.emulation import PsScheduler

    return PsScheduler()


def _planned(scenario: Scenario, solve: Solve | None, as_json: bool) -> Plan:
    """The plan, with its iterations shown as they happen; raises KeyboardInterrupt when it was interrupted."""
    from rich.console import Console

    from orbsoc.guidance.progress import IterationTable
    from orbsoc.missions.reachable_insertion import PlanStatus, plan
    from orbsoc.missions.reachable_insertion.record import iteration_cells

    with IterationTable(Console(stderr=as_json), iteration_cells) as table:
        found = plan(scenario, solve=solve, callback=table)
    if found.status is PlanStatus.INTERRUPTED:
        raise KeyboardInterrupt
    return found


def _checked(found: Plan, check: CheckChoice | None) -> Agreement | None:
    """The comparison with the same plan made by Clarabel, when asked for."""
    if check is None:
        return None
    from orbsoc.interfaces.clarabel import solve
    from orbsoc.missions.reachable_insertion import PlanStatus, plan
    from orbsoc.missions.reachable_insertion.agreement import agreement

    theirs = plan(found.scenario, solve=solve)
    if theirs.status is PlanStatus.INTERRUPTED:
        raise KeyboardInterrupt
    return agreement(found, theirs)


def _succeeded(run: Run) -> bool:
    from orbsoc.missions.reachable_insertion import PlanStatus

    same_bits = run.budget is None or run.budget.same_bits
    agrees = run.check is None or run.check.agrees
    return run.plan.status is PlanStatus.VERIFIED and agrees and same_bits


def _print_summary(document: dict[str, Any], folder: Path, as_json: bool) -> None:
    """The verdict last, where the eye is; plain text, one fact per line, on standard error beside JSON."""
    from rich.console import Console

    console = Console(stderr=as_json)
    lines = [""]
    hardware, check = document["hardware"], document["check"]
    if check:
        lines.append(
            f"{check['solver']}: {'agrees' if check['agrees'] else 'DOES NOT AGREE'}; {check['words']}"
        )
    if hardware:
        lines.append(hardware["headline"])
        if hardware["deadline"]:
            lines.append(hardware["deadline"])
        if not hardware["same_bits"]:
            lines.append("the scheduled solves DO NOT return the bits of the native ones")
    lines += [document["verdict"], f"written to {folder}"]
    for line in lines:
        console.print(line, markup=False, highlight=False, soft_wrap=True)
