"""Iterations as they happen: one line of progress, or a table of all; plain lines where there is no terminal."""

from __future__ import annotations

from collections.abc import Mapping
from math import isfinite
from time import monotonic
from types import TracebackType
from typing import Self

from rich.console import Console
from rich.live import Live
from rich.status import Status
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
            f"{column.title} {column.unit}".rstrip(): format(figures[name], column.form)
            if name in figures
            else "–"
            for name, column in columns.items()
        },
        "change": scientific(row.change),
        "slack": scientific(row.slack),
        "tolerance": f"{row.tolerance:.0e}",
        "solver": f"{row.solution.status.name.lower()} in {row.solution.iterations}",
        "solve ms": f"{1e3 * row.solution.solve_s:.2f}",
    }


class IterationTable:
    """Shows every iteration it is called with. Use as a context manager; one table per run."""

    def __init__(self, console: Console, columns: Mapping[str, Column]) -> None:
        self._console = console
        self._columns = columns
        self._table: Table | None = None
        self._live: Live | None = None

    def __call__(self, iteration: Iteration) -> None:
        row = iteration_cells(iteration, self._columns)
        if self._live is None:
            self._print(row)
            return
        if self._table is None:
            self._table = Table(box=None, header_style="bold", pad_edge=False)
            for title in row:
                self._table.add_column(title, justify="right", no_wrap=True)
        self._table.add_row(*row.values(), style="dim" if iteration.change > 1e-4 else "")
        self._live.update(self._table, refresh=True)

    def __enter__(self) -> Self:
        if self._console.is_terminal:
            self._live = Live(console=self._console, auto_refresh=False, vertical_overflow="visible")
            self._live.__enter__()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._live is not None:
            self._live.__exit__(kind, error, trace)
            self._live = None

    def _print(self, row: Mapping[str, str]) -> None:
        line = "  ".join(f"{title}={value}" for title, value in row.items())
        self._console.print(line, markup=False, highlight=False, soft_wrap=True)


EVERY_S = 10.0
"""Between two lines where there is no terminal."""


class ProgressLine:
    """Counts the conic problems of a run: a line that is rewritten on a terminal, else one at once and one every `EVERY_S`."""

    def __init__(self, console: Console) -> None:
        self._console = console
        self._status: Status | None = None
        self._count = 0
        self._told_s = 0.0

    def __call__(self, iteration: Iteration) -> None:
        self._count += 1
        words = f"planning: {self._count} conic problem{'s' if self._count > 1 else ''} solved"
        if self._status is not None:
            self._status.update(words)
        elif self._count > 1 and monotonic() - self._told_s >= EVERY_S:
            self._tell(words)

    def __enter__(self) -> Self:
        if self._console.is_terminal:
            self._status = self._console.status("planning")
            self._status.start()
        else:
            self._tell("planning")
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._status is not None:
            self._status.stop()
            self._status = None

    def _tell(self, words: str) -> None:
        self._told_s = monotonic()
        self._console.print(words, markup=False, highlight=False, soft_wrap=True)
