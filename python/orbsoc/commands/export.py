"""`orbsoc export c`: the chip's own program for the pattern of a problem file, or of a scenario's subproblems.

Exit codes: 0 written, 2 bad input: nothing was written.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from .failures import BAD_INPUT, exit_handling, exit_with

if TYPE_CHECKING:
    from orbsoc.conic.problem import Problem

app = typer.Typer(help="Programs for other machines.", no_args_is_help=True, rich_markup_mode=None)
MISSIONS = ("reachable_insertion",)
"""Missions of which all subproblems share a pattern that has a program in C."""


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
) -> None:
    """Write C99 for one pattern: tables, library, self-test, bounds."""
    from orbsoc.flight import FlightError, export_c
    from orbsoc.flight.export import check_place

    with exit_handling(False, interrupted="interrupted; nothing was written"):
        try:
            check_place(out)
            problem = _subproblem(source) if source.suffix == ".toml" else _stated(source)
            written = export_c(problem, out, fp=fp)
        except FlightError as error:
            exit_with(BAD_INPUT, str(error), False)
    typer.echo(f"{len(written)} files written to {out}; README.md has the line that builds the self-test")


def _stated(path: Path) -> Problem:
    """The problem of a problem file."""
    from orbsoc.conic.problem import Problem

    return Problem.load(path)


def _subproblem(path: Path) -> Problem:
    """The first subproblem of a scenario, whose pattern all others of it share."""
    import orbsoc
    from orbsoc.conic.pattern import pattern_digest
    from orbsoc.flight import FlightError
    from orbsoc.missions.registry import load_scenario

    mission, scenario = load_scenario(path)
    if scenario.mission not in MISSIONS:
        known = ", ".join(MISSIONS)
        raise FlightError(
            f"{path}: mission {scenario.mission!r} has no program in C; there is one for {known}, and for any problem"
            " file"
        )
    found: list[Problem] = []

    def recorded(problem: Problem, *arguments: Any, **options: Any) -> Any:
        found.append(problem)
        return orbsoc.solve(problem, *arguments, **options)

    mission.plan(scenario, solve=recorded)
    first = found[0]
    if any(pattern_digest(problem) != pattern_digest(first) for problem in found):
        raise FlightError(f"{path}: its subproblems do not share one pattern")
    return first
