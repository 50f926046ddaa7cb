"""Iterations as they happen: one line of progress, or a table of all; plain lines where there is no terminal."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from itertools import count
from math import isfinite
from time import monotonic

from rich.console import Console
from rich.live import Live
from rich.table import Table

from .mission import Column
from .scp import Iteration


def iteration_cells(row: Iteration, columns: Mapping[str, Column]) -> dict[str, str]:
    """One row of the table, by column title; `columns` are the mission's own, by the name of the figure."""
    figures = row.figures

    def scientific(value: float) -> str:
        return f"{value:.1e}" if isfinite(value) else "–"

    return {
        "#": str(row.number),
        **{
            f"{each.title} {each.unit}".rstrip(): format(figures[name], each.form) if name in figures else "–"
            for name, each in columns.items()
        },
        "change": scientific(row.change),
        "slack": scientific(row.slack),
        "tolerance": f"{row.tolerance:.0e}",
        "solver": f"{row.solution.status.name.lower()} in {row.solution.iterations}",
        "solve ms": f"{1e3 * row.solution.solve_s:.2f}",
    }


@contextmanager
def iteration_table(console: Console, columns: Mapping[str, Column]) -> Iterator[Callable[[Iteration], None]]:
    """What shows every iteration that it is called with: as a row of a table, or where there is no terminal as a line."""
    if not console.is_terminal:

        def tell(iteration: Iteration) -> None:
            row = iteration_cells(iteration, columns)
            _print(console, "  ".join(f"{title}={value}" for title, value in row.items()))

        yield tell
        return
    table = Table(box=None, header_style="bold", pad_edge=False)
    with Live(console=console, auto_refresh=False, vertical_overflow="visible") as live:

        def show(iteration: Iteration) -> None:
            row = iteration_cells(iteration, columns)
            for title in row if not table.columns else ():
                table.add_column(title, justify="right", no_wrap=True)
            table.add_row(*row.values(), style="dim" if iteration.change > 1e-4 else "")
            live.update(table, refresh=True)

        yield show


EVERY_S = 10.0
"""Between two lines where there is no terminal."""


@contextmanager
def progress_line(console: Console) -> Iterator[Callable[[Iteration], None]]:
    """What counts the conic problems of a run: a line that is rewritten on a terminal, else one at once and one every `EVERY_S`."""
    numbers, told_s = count(1), monotonic()

    def words() -> str:
        number = next(numbers)
        return f"planning: {number} conic problem{'s' if number > 1 else ''} solved"

    if console.is_terminal:
        with console.status("planning") as status:
            yield lambda _: status.update(words())
        return
    _print(console, "planning")

    def tell(_: Iteration) -> None:
        nonlocal told_s
        line = words()
        if monotonic() - told_s >= EVERY_S:
            told_s = monotonic()
            _print(console, line)

    yield tell


def _print(console: Console, line: str) -> None:
    console.print(line, markup=False, highlight=False, soft_wrap=True)
