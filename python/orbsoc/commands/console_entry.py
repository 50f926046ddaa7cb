"""The way in from a shell: what ends a command outside its body is reported too, as one JSON object with `--json`."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import typer
from typer.core import TyperGroup

from .failures import BAD_INPUT, INTERRUPTED, exit_with, report_exit


class OneLineGroup(TyperGroup):
    """The commands of `orbsoc`: arguments that do not parse are told in one line, as every other wrong input is."""

    def make_context(self, *args: Any, **kwargs: Any) -> Any:
        with _in_one_line():
            return super().make_context(*args, **kwargs)

    def invoke(self, ctx: Any) -> Any:
        with _in_one_line():
            return super().invoke(ctx)


@contextmanager
def _in_one_line() -> Iterator[None]:
    """Report the parser's own error, which would print the usage before it; a whole help text goes through."""
    try:
        yield
    except Exception as error:
        formatted = getattr(error, "format_message", None)
        message = str(formatted()) if formatted else "\n"
        if "\n" in message:
            raise
        about = getattr(getattr(error, "param", None), "help", None)
        if about and message.startswith("Missing"):
            message = f"{message.rstrip('.')}: {about}"
        exit_with(BAD_INPUT, message, "--json" in sys.argv[1:])


class ConsoleApp(typer.Typer):
    """A Typer application that also accounts for what ends outside a command's body.

    That is Ctrl-C while modules are still loading (exit code 130), and arguments that do not parse (2).
    """

    def __call__(self, *args: Any, **kwargs: Any) -> Any:
        sys.unraisablehook = _unraisable
        try:
            return super().__call__(*args, **kwargs)
        except KeyboardInterrupt:
            _report("interrupted", INTERRUPTED)
            _forget_the_signal()
            sys.exit(INTERRUPTED)
        except SystemExit as end:
            message = _unreported(end)
            if message is not None:
                _report(message, end.code)
            _forget_the_signal()
            raise


def _unraisable(lost: sys.UnraisableHookArgs) -> None:
    """Ctrl-C that comes out where nothing can be raised, as in a weak reference's callback of an import: Python would
    print a trace and go on. `Interrupts` remembers the signal."""
    if not issubclass(lost.exc_type, KeyboardInterrupt):
        sys.__unraisablehook__(lost)


def _forget_the_signal() -> None:
    """Let the exit code stand after a Ctrl-C that has been handled.

    CPython remembers a KeyboardInterrupt that left code compiled from a string (dataclasses and named tuples are made
    that way, so an import can be in the middle of one), and at the end of `python -m` dies of SIGINT because of it, also
    when the exception was caught. It forgets when it next runs such code.
    """
    exec("")


def _unreported(end: SystemExit) -> str | None:
    """Why a command ended that could not report it itself; None when it has, or ended well.

    Typer leaves the error that it has turned into an exit in the exit's context.
    """
    cause = end.__context__
    if isinstance(cause, typer.Exit):  # of a command that has reported, or stands for Ctrl-C
        return "interrupted" if isinstance(cause.__cause__, KeyboardInterrupt) else None
    if cause is None or not end.code:
        return None
    formatted = getattr(cause, "format_message", None)  # of the parser's own errors
    return str(formatted() if formatted else cause)


def _report(message: str, code: int | str | None) -> None:
    """The object with `--json`; the parser has printed its own errors on standard error."""
    report_exit(code, message, "--json" in sys.argv[1:])
    if code == INTERRUPTED:
        typer.echo(f"orbsoc: {message}", err=True)
