"""How a command ends when it does not end well: in words on standard error, with its exit code."""

from __future__ import annotations

import json
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from typing import NoReturn

import typer

FAILED, BAD_INPUT, INTERRUPTED = 1, 2, 130


@contextmanager
def spoken(as_json: bool) -> Iterator[None]:
    """Turn what the block raises into words and an exit code; with `as_json` also into one object on stdout.

    Bad input is 2, Ctrl-C 130; anything else is a defect of orbsoc, printed with its trace, and 1.
    """
    try:
        yield
    except typer.Exit:
        raise
    except KeyboardInterrupt:
        stop(INTERRUPTED, "interrupted", as_json)
    except Exception as error:
        code, words = _judged(error)
        stop(code, words, as_json)


def stop(code: int, words: str, as_json: bool) -> NoReturn:
    """Say why on standard error, as an object on standard output where that is read, and leave with `code`."""
    if as_json:
        typer.echo(json.dumps({"error": words, "exit_code": code}))
    typer.echo(f"orbsoc: {words}" if code == INTERRUPTED else f"orbsoc: error: {words}", err=True)
    raise typer.Exit(code)


def defect(error: Exception) -> tuple[int, str]:
    """Exit code and words of an exception that none of our checks foresaw, after its trace."""
    traceback.print_exception(error)
    return FAILED, f"a defect of orbsoc, please report it: {type(error).__name__}: {error}"


def _judged(error: Exception) -> tuple[int, str]:
    """Exit code and words of an exception."""
    from hw_model import HwModelError
    from orbsoc.conic.errors import FileError, ProblemError
    from orbsoc.files.output_folder import OutputFolderError
    from orbsoc.guidance.scenario_file import ScenarioError
    from orbsoc.hw.deadlines import CaseError
    from orbsoc.hw.schedules import EngineError
    from orbsoc.hw.workload import WorkloadError
    from orbsoc.rtl.validation import RtlError

    bad_input = (
        HwModelError,
        CaseError,
        EngineError,
        FileError,
        ProblemError,
        ScenarioError,
        OutputFolderError,
        RtlError,
        WorkloadError,
    )
    if isinstance(error, bad_input):
        return BAD_INPUT, str(error)
    if isinstance(error, OSError):
        return BAD_INPUT, f"{error.filename}: {error.strerror}" if error.filename else str(error)
    return defect(error)
