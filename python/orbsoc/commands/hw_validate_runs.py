"""What every validation of whole runs on the RTL does with them: progress, a document, a table, a verdict and an exit code."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any, NoReturn, Protocol, TypeVar

import typer

from . import hw_options as options
from .failures import FAILED


class Judged(Protocol):
    """An outcome that says whether the RTL and Rust agree."""

    @property
    def good(self) -> bool: ...


T = TypeVar("T", bound=Judged)


def report_runs(
    runs: Iterable[T],
    count: int,
    where: Path,
    *,
    name: str,
    head: dict[str, Any],
    line: Callable[[T], str],
    record: Callable[[T], dict[str, Any]],
    table: Callable[[Sequence[T]], list[str]],
    verdict: Callable[[Sequence[T], bool], str],
    as_json: bool,
) -> NoReturn:
    """Go through `count` runs, write rtl-NAME.json and rtl-NAME.md to `where`, and end with 0 or, at any difference, 1.

    `head` begins the document, `line` is printed of each run as it ends.
    """
    options.write_all(where, {})
    outcomes: list[T] = []
    for done, outcome in enumerate(runs, start=1):
        outcomes.append(outcome)
        typer.echo(f"{done}/{count} {line(outcome)}", err=True)
    equal = all(outcome.good for outcome in outcomes)
    document = {**head, "equal": equal, name: [record(outcome) for outcome in outcomes]}
    rows = table(outcomes)
    files = {f"rtl-{name}.json": options.as_json_text(document), f"rtl-{name}.md": "\n".join(rows) + "\n"}
    options.write_all(where, files)
    options.print_report([*rows, verdict(outcomes, equal)], document, where, as_json=as_json)
    raise typer.Exit(0 if equal else FAILED)
