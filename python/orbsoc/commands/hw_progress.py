"""What a long command of `orbsoc hw` is at: plain lines on standard error, the same on a terminal and on a pipe."""

from __future__ import annotations

from time import monotonic

import typer

EVERY_S = 2.0
"""At least between two lines of one stage."""


class Progress:
    """Prints the stages of a run as they begin, and within a stage at most one line every `EVERY_S`."""

    def __init__(self) -> None:
        self._told_s = monotonic()

    def __call__(self, line: str) -> None:
        """A stage begins: it is printed at once."""
        typer.echo(line, err=True)
        self._told_s = monotonic()

    def now_and_then(self, line: str) -> None:
        """How far the stage is: printed where the last line is old."""
        if monotonic() - self._told_s >= EVERY_S:
            self(line)
