"""`orbsoc hw validate --mutations`: engines and schedulers that are wrong in one place, and what catches each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

import typer

from . import hw_options as options
from .failures import FAILED

if TYPE_CHECKING:
    from orbsoc.rtl.mutations import Catch

SCHEMA = "orbsoc.rtl-mutations/1"


def validate_mutations(folder: Path, where: Path, *, as_json: bool) -> NoReturn:
    """Run every module of a small problem with each mutation, write rtl-mutations.json and .md to `where`, and end with 0
    or, if a mutation goes unnoticed or engine and schedules as they are do not, 1.

    The problem is the smallest of which a decoder freezes with divisions in flight."""
    from orbsoc.rtl.mutations import ENGINE, catches
    from orbsoc.rtl.validation import problems

    name, problem = list(problems().items())[2]
    options.write_all(where, {})
    found: list[Catch] = []
    for catch in catches(folder, name, problem):
        found.append(catch)
        typer.echo(f"{catch.mutation or 'as it is'}, {catch.form}: {_verdict(catch)}", err=True)
    good = all(catch.good for catch in found)
    document = {
        "schema": SCHEMA,
        "provenance": "measured: RTL under Verilator against its schedule",
        "problem": name,
        "engine": asdict(ENGINE),
        "good": good,
        "engines": [asdict(catch) | {"caught": catch.caught, "good": catch.good} for catch in found],
    }
    table = _table(found)
    text = "\n".join(table) + "\n"
    options.write_all(where, {"rtl-mutations.json": options.as_json_text(document), "rtl-mutations.md": text})
    mutated = [catch for catch in found if catch.mutation is not None]
    caught = sum(catch.caught for catch in mutated)
    verdict = f"measured: {caught} of {len(mutated)} mutations of RTL, checks and schedules are caught"
    options.print_report([*table, verdict], document, where, as_json=as_json)
    raise typer.Exit(0 if good else FAILED)


def _table(found: Sequence[Catch]) -> list[str]:
    """Markdown, one row an engine."""
    rows = [
        f"| {catch.mutation or 'none'} | {catch.kind} | {catch.form} | {catch.segments} | {catch.wrong_cycles} |"
        f" {catch.wrong_words} | {catch.asserted} | {catch.signalled} | {catch.silent} | {_verdict(catch)} |"
        for catch in found
    ]
    return [
        "| mutation | of | sequencer | segments | cycles off | words different | asserted | wrong signals |"
        " silent rules | verdict |",
        "|---|---|---|---|---|---|---|---|---|---|",
        *rows,
    ]


def _verdict(catch: Catch) -> str:
    if catch.caught:
        return "caught" if catch.good else "DIFFERENT"
    return "equal" if catch.good else "UNNOTICED"
