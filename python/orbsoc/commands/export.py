"""`orbsoc export c`: the chip's own program for the pattern of a problem file, or of a scenario's subproblems.

Exit codes: 0 written, 2 bad input: nothing was written.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from .failures import exit_handling

if TYPE_CHECKING:
    from orbsoc.conic.problem import Problem

app = typer.Typer(help="Programs for other machines.", no_args_is_help=True, rich_markup_mode=None)


@app.callback()
def main() -> None:
    """Programs for other machines."""


@app.command()
def c(
    source: Annotated[
        Path,
        typer.Argument(
            help="scenario or problem file", metavar="SCENARIO.toml|PROBLEM.json", show_default=False
        ),
    ],
    out: Annotated[Path, typer.Option(help="folder to write, which must not exist", metavar="DIR")],
    fp: Annotated[int, typer.Option(help="arithmetic of the iteration: 64 or 32")] = 64,
    partition: Annotated[
        str | None,
        typer.Option(
            help="modules that run on the PL, by its driver: name, TOML file, modules joined by +",
            show_default="none",
        ),
    ] = None,
    engine: Annotated[
        str,
        typer.Option(
            help="the PL's engine: lanes, dividers, banks, clusters, address_bits, rows", metavar="KEY=N,..."
        ),
    ] = "lanes=4,dividers=1,banks=16",
    limit_clocks: Annotated[
        int | None,
        typer.Option(
            min=1,
            max=2**32 - 1,
            help="clocks of the PL that a launch may be busy: the PL stops a longer one",
            metavar="N",
            show_default="the most that the settings can take",
        ),
    ] = None,
    microcode: Annotated[str, typer.Option(help="flat or compressed")] = "flat",
    instructions: Annotated[
        bool, typer.Option("--instructions", help="count each stage's instructions under QEMU for BOUNDS.md")
    ] = False,
) -> None:
    """Write C99 for one pattern: tables, library, self-test, bounds; with a partition the PL's program and driver."""
    from orbsoc.flight import export_c
    from orbsoc.flight.export import check_place

    with exit_handling(False, interrupted="interrupted; nothing was written"):
        check_place(out)
        problem, whole, without = (
            _of_scenario(source, fp) if source.suffix == ".toml" else (_stated(source), None, "")
        )
        options = {"partition": partition, "engine": _engine(engine), "form": _form(microcode)}
        options |= {"instructions": instructions, "mission": whole, "limit_clocks": limit_clocks}
        written = export_c(problem, out, fp=fp, **options)
    typer.echo(f"{len(written)} files written to {out}; README.md has the line that builds the self-test")
    if whole is not None:
        typer.echo("the whole mission is among them: mission.h, flight/missions and mission_selftest.c")
    elif without:
        typer.echo(f"the solves alone, without the whole mission; {without}")


def _engine(text: str) -> Any:
    """An engine from `key=n` pairs."""
    from dataclasses import fields

    from orbsoc.flight import FlightError
    from orbsoc.hw.schedules import Engine, EngineError

    allowed = sorted({field.name for field in fields(Engine)} - {"fp", "microcode_words"})
    chosen: dict[str, int] = {}
    for pair in text.split(","):
        key, _, value = pair.partition("=")
        if key.strip() not in allowed or not value.strip().isdigit():
            raise FlightError(f"--engine: {pair!r}: allowed is KEY=N with KEY one of {', '.join(allowed)}")
        chosen[key.strip()] = int(value)
    try:
        return Engine(**chosen)  # type: ignore[arg-type]
    except EngineError as error:
        raise FlightError(f"--engine: {error}") from error


def _form(text: str) -> Any:
    from orbsoc.flight import FlightError

    if text not in ("flat", "compressed"):
        raise FlightError(f"--microcode = {text!r}: allowed is flat or compressed")
    return text


def _stated(path: Path) -> Problem:
    """The problem of a problem file."""
    from orbsoc.conic.problem import Problem

    return Problem.load(path)


def _of_scenario(path: Path, fp: int) -> tuple[Problem, Any, str]:
    """The first subproblem of a scenario, whose pattern all others of it share, and its whole mission, or why it has none."""
    from orbsoc.conic.pattern import pattern_digest
    from orbsoc.flight import FlightError
    from orbsoc.guidance.mission import NotOnBoard, OnBoard
    from orbsoc.guidance.scp import uninterrupted
    from orbsoc.hw.workload import subproblems
    from orbsoc.missions.registry import MISSIONS, load_scenario

    mission, scenario = load_scenario(path)
    if not isinstance(mission, OnBoard):
        known = ", ".join(name for name, each in MISSIONS.items() if isinstance(each, OnBoard))
        raise FlightError(
            f"{path}: mission {scenario.mission!r} has no program in C; there is one for {known}, and for any problem"
            " file"
        )
    without = (
        ""
        if fp == 64
        else f"fp = {fp}: the tolerances of the mission in C are below the resolution of binary32"
    )
    if not without:
        try:
            whole = mission.on_board(scenario, uninterrupted())
            return whole.problem, whole, ""
        except NotOnBoard as error:
            without = str(error)
    found = [problem for problem, _ in subproblems(mission, scenario)]
    if not found:
        raise FlightError(f"{path}: its plan solves no subproblem")
    if any(pattern_digest(problem) != pattern_digest(found[0]) for problem in found):
        raise FlightError(f"{path}: its subproblems do not share one pattern")
    return found[0], None, without
