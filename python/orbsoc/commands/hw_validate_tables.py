"""`orbsoc hw validate --tables`: the modelled tables of docs/pl-schedules.md, made anew."""

from __future__ import annotations

from pathlib import Path
from typing import NoReturn

import typer

from orbsoc.commands import hw_options as options


def print_tables(scenario: Path, where: Path, *, as_json: bool) -> NoReturn:
    """Mission 004's first subproblems C and A, N = 12, on engines of 1 to 8 lanes; write pl-tables.md and .json.

    Raises RtlError where the scenario is not at hand.
    """
    from orbsoc.pl_tables import tables
    from orbsoc.rtl_validation import mission_004

    problems = {
        f"mission 004 {letter}, N = 12": mission_004(scenario, free_perigee=free)
        for letter, free in (("C", True), ("A", False))
    }
    document, lines = tables(problems)
    text = "\n".join(lines) + "\n"
    options.write_all(where, {"pl-tables.json": options.as_json_text(document), "pl-tables.md": text})
    options.say(lines, document, where, as_json=as_json)
    raise typer.Exit(0)
