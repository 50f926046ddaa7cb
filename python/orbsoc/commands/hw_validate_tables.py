"""`orbsoc hw validate --tables`: the modelled tables of docs/pl-schedules.md, made anew."""

from __future__ import annotations

from pathlib import Path
from typing import NoReturn

import typer

from . import hw_options as options

DRAWN = ((4, 1), (8, 2))
"""Lanes and dividers of the engines in the figure."""


def print_tables(scenario: Path, where: Path, *, as_json: bool) -> NoReturn:
    """Mission 004's first subproblems C and A, N = 12, on engines of 1 to 8 lanes; write pl-tables.md and .json, and
    pl-utilisation.png of C's KKT solves.

    Raises RtlError where the scenario is not at hand.
    """
    from orbsoc.hw.schedules import Engine, pl_program
    from orbsoc.hw.utilisation_figure import utilisation_figure
    from orbsoc.rtl.tables import WITH_RESIDUALS, tables
    from orbsoc.rtl.validation import mission_004

    problems = {
        f"mission 004 {letter}, N = 12": mission_004(scenario, free_perigee=free)
        for letter, free in (("C", True), ("A", False))
    }
    document, lines = tables(problems)
    text = "\n".join(lines) + "\n"
    options.write_all(where, {"pl-tables.json": options.as_json_text(document), "pl-tables.md": text})
    first = next(iter(problems.values()))
    drawn = [Engine(lanes=lanes, dividers=dividers) for lanes, dividers in DRAWN]
    panels = [(pl_program(first, None, engine, WITH_RESIDUALS), WITH_RESIDUALS.name) for engine in drawn]
    utilisation_figure(panels, where / "pl-utilisation.png")
    options.print_report(lines, document, where, as_json=as_json)
    raise typer.Exit(0)
