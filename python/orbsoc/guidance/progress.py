"""Iterations as they happen: a live table on a terminal, plain lines elsewhere."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import TracebackType
from typing import Self

from rich.console import Console
from rich.live import Live
from rich.table import Table

from .scp import Iteration

Cells = Callable[[Iteration], Mapping[str, str]]
"""A mission's row of the table, by column title."""


class IterationTable:
    """Shows every iteration it is called with. Use as a context manager; one table per run."""

    def __init__(self, console: Console, cells: Cells) -> None:
        self._console = console
        self._cells = cells
        self._table: Table | None = None
        self._live: Live | None = None

    def __call__(self, iteration: Iteration) -> None:
        row = self._cells(iteration)
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
