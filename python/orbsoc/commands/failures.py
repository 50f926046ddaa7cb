"""How a command ends that does not end well: a message on standard error, and the exit code."""

from __future__ import annotations

import json
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from typing import NoReturn

import typer

from orbsoc.files.extras import what_to_install
from orbsoc.files.interrupts import Interrupts

FAILED, BAD_INPUT, INTERRUPTED = 1, 2, 130


@contextmanager
def exit_handling(
    as_json: bool, *, interrupted: str = "interrupted", interrupts: Interrupts | None = None
) -> Iterator[None]:
    """Turn what the block raises into a message and an exit code; with `as_json` also into one object on stdout.

    Bad input is 2, Ctrl-C 130 with the message `interrupted`, and so is any error after a signal that `interrupts`
    received. Anything else is a defect of orbsoc, printed with its trace, and 1.
    """
    try:
        yield
    except typer.Exit:
        raise
    except KeyboardInterrupt:
        exit_with(INTERRUPTED, interrupted, as_json)
    except Exception as error:
        if interrupts is not None and interrupts.received:
            exit_with(INTERRUPTED, interrupted, as_json)
        exit_with(*exit_of(error), as_json)


def exit_with(code: int, message: str, as_json: bool) -> NoReturn:
    """Report why, and leave with `code`."""
    report_exit(code, message, as_json)
    typer.echo(f"orbsoc: {message}" if code == INTERRUPTED else f"orbsoc: error: {message}", err=True)
    raise typer.Exit(code)


def report_exit(code: int | str | None, message: str, as_json: bool) -> None:
    """The object on standard output of a command that ended early, with `as_json`."""
    if as_json:
        typer.echo(json.dumps({"error": message, "exit_code": code}))


def exit_of(error: Exception) -> tuple[int, str]:
    """Exit code and message of an exception; the trace is printed when it is a defect of orbsoc."""
    from hw_model import HwModelError
    from orbsoc.conic.errors import FileError, ProblemError, SettingsError
    from orbsoc.files.output_folder import OutputFolderError
    from orbsoc.flight import FlightError
    from orbsoc.guidance.impulses import ImpulseFileError
    from orbsoc.guidance.scenario_file import ScenarioError
    from orbsoc.hw.deadlines import CaseError
    from orbsoc.hw.schedules import EngineError, EngineTooSmallError
    from orbsoc.hw.workload import WorkloadError
    from orbsoc.orbit import PropagationError
    from orbsoc.rtl.validation import RtlError
    from orbsoc.sweep import StoreError, WorkersLost

    bad_input = (
        HwModelError, CaseError, EngineError, FileError, FlightError, ImpulseFileError, OutputFolderError, ProblemError, RtlError,
        ScenarioError, SettingsError, StoreError, WorkloadError,
    )  # fmt: skip
    if isinstance(error, EngineTooSmallError):
        return FAILED, f"does NOT FIT the engine, and is not priced: {error}"
    if isinstance(error, bad_input):
        return BAD_INPUT, str(error)
    if isinstance(error, OSError):
        return BAD_INPUT, f"{error.filename}: {error.strerror}" if error.filename else str(error)
    if isinstance(error, ModuleNotFoundError) and (advice := what_to_install(error)):
        return BAD_INPUT, advice
    if isinstance(error, PropagationError):
        return FAILED, f"no plan: the burn cannot be flown: {error}"
    if isinstance(error, WorkersLost):
        return FAILED, str(error)
    traceback.print_exception(error)
    return FAILED, f"a defect of orbsoc, please report it: {type(error).__name__}: {error}"
