"""`orbsoc reproduce`: what the missions' papers print, beside what this computes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from orbsoc.missions.registry import MISSIONS

from . import hw_options as options
from .failures import FAILED, exit_handling

if TYPE_CHECKING:
    from orbsoc.guidance.mission import PaperRow

COLUMNS = ("quantity", "source", "paper", "ours", "tolerance", "verdict", "reason")


def reproduce(
    what: Annotated[
        str,
        typer.Argument(
            help=f"mission ({', '.join(MISSIONS)}), number of a paper (000 to 004) or all", metavar="NAME"
        ),
    ] = "all",
    scenarios: Annotated[Path, typer.Option(help="folder of the papers' scenarios", metavar="DIR")] = Path(
        "scenarios"
    ),
    out: Annotated[Path, typer.Option(help="output folder", metavar="DIR")] = Path("out/reproduce"),
    as_json: options.JsonOption = False,
) -> None:
    """Compute what a paper prints: its value, ours, tolerance, verdict, and why they differ.

    Exit codes: 0 every stated verdict holds, 1 one does not, 2 bad input.
    """
    from orbsoc.guidance.mission import BROKEN

    papers = {name: MISSIONS[name].PAPER for name in MISSIONS if what not in MISSIONS}
    names = [what] if what in MISSIONS else [name for name in papers if what in ("all", papers[name])]
    if not names:
        allowed = ", ".join(["all", *sorted({*papers.values()} - {""}), *MISSIONS])
        raise typer.BadParameter(f"{what!r}: no such mission; allowed: {allowed}")
    if not scenarios.is_dir():
        raise typer.BadParameter(f"--scenarios {scenarios}: no such folder; give that of the source tree")
    with exit_handling(as_json):
        rows = {name: MISSIONS[name].reproduce(scenarios) for name in names}
        document = {
            "schema": "orbsoc.reproduce/1",
            "missions": {name: [asdict(row) for row in found] for name, found in rows.items()},
        }
        text = _markdown(rows)
        options.write_all(
            out, {"reproduce.json": options.as_json_text(document), "reproduce.md": text + "\n"}
        )
        options.print_report(text.splitlines(), document, out, as_json=as_json)
        broken = [row.quantity for found in rows.values() for row in found if row.verdict == BROKEN]
        if broken:
            typer.echo(f"orbsoc: does not hold as stated: {', '.join(broken)}", err=True)
            raise typer.Exit(FAILED)


def _markdown(rows: Mapping[str, Sequence[PaperRow]]) -> str:
    """A table a mission."""
    lines: list[str] = []
    for name, found in rows.items():
        lines += ["", f"## {name}", "", f"| {' | '.join(COLUMNS)} |", "|" + "---|" * len(COLUMNS)]
        lines += (f"| {' | '.join(getattr(row, column) for column in COLUMNS)} |" for row in found)
    return "\n".join(lines[1:])
