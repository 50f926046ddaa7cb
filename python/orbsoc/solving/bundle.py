"""The failure bundle: everything needed to see a solve fail again, in one JSON file of schema `orbsoc.bundle/1`.

One object:

- `schema`: "orbsoc.bundle/1";
- `problem`: a document of orbsoc.conic.problem_file; `settings`: every field of `orbsoc.Settings`;
- `solution`: a document of orbsoc.conic.solution_file: what was returned;
- `start`: {"x", "y", "z", "s"}, the point that the solve started from, or null;
- `history`: one object for each iteration, its keys those of orbsoc.solving.iteration_table.COLUMNS;
- `versions`: {"orbsoc", "core", "numpy", "scipy", "python", "platform"}.

The same settings on the same problem give the same bits, unless the clock or Ctrl-C ended the solve.
"""

from __future__ import annotations

import platform
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from os import PathLike, fspath
from pathlib import Path
from typing import Any

from orbsoc import _core
from orbsoc.conic.errors import FileError, ProblemError
from orbsoc.conic.problem import Problem
from orbsoc.conic.problem_file import decode_problem, encode_problem
from orbsoc.conic.settings import Settings
from orbsoc.conic.solution import Solution, Start
from orbsoc.conic.solution_file import decode_solution, encode_solution
from orbsoc.files.json_fields import (
    Document,
    FieldError,
    Fields,
    checked_list,
    decode_number,
    encode_number,
    encode_numbers,
    read_json,
    write_json,
)
from orbsoc.files.versions import __version__

SCHEMA = "orbsoc.bundle/1"
_FIELDS = ("schema", "problem", "settings", "solution", "start", "history", "versions")
_START = ("x", "y", "z", "s")

Progress = Mapping[str, float]


@dataclass(frozen=True, slots=True)
class Bundle:
    """A solve that did not end with SOLVED; `orbsoc.solve(bundle.problem, bundle.settings, warm_start=bundle.start)`
    repeats it."""

    problem: Problem
    settings: Settings
    solution: Solution
    history: tuple[Progress, ...]
    versions: Mapping[str, str]
    start: Start | None = None


def check_place(path: str | PathLike[str]) -> None:
    """Raise OSError now where a bundle could not be written after the work is done, TypeError where `path` is none."""
    if not isinstance(path, str | PathLike):
        raise TypeError(f"`bundle` is {path!r}; it must be the path of a file")
    place = Path(path)
    if not place.parent.is_dir():
        raise FileNotFoundError(f"bundle = {fspath(path)}: there is no folder {place.parent}")
    if place.is_dir():
        raise IsADirectoryError(f"bundle = {fspath(path)}: is a folder; give the path of a file")


def recording(
    history: list[Progress], callback: Callable[[Progress], object] | None
) -> Callable[[Progress], object]:
    """A callback that keeps each iteration's statistics in `history`, then asks `callback`."""

    def watch(progress: Progress) -> object:
        history.append(dict(progress))
        return callback(progress) if callback else False

    return watch


def write_bundle(bundle: Bundle, path: str | PathLike[str]) -> None:
    """Write a bundle; raises OSError if the path cannot be written."""
    settings = {field.name: getattr(bundle.settings, field.name) for field in fields(bundle.settings)}
    document: Document = {
        "schema": SCHEMA,
        "problem": encode_problem(bundle.problem),
        "settings": _encoded(settings),
        "solution": encode_solution(bundle.solution),
        "start": bundle.start and {name: encode_numbers(getattr(bundle.start, name)) for name in _START},
        "history": [_encoded(progress) for progress in bundle.history],
        "versions": dict(bundle.versions),
    }
    write_json(document, path)


def read_bundle(path: str | PathLike[str]) -> Bundle:
    """Read a file of this schema; raises FileError naming the field, OSError if the file cannot be read."""
    try:
        return decode_bundle(read_json(path))
    except (FieldError, ProblemError) as error:
        raise FileError(f"{fspath(path)}: {error}") from error


def decode_bundle(document: Any) -> Bundle:
    """The bundle of a document; raises FieldError or ProblemError."""
    top = Fields(document)
    top.check_names(SCHEMA, _FIELDS)
    entries = checked_list("history", top.document.get("history"), None)
    history = [Fields(entry, f"history[{k}]") for k, entry in enumerate(entries)]
    versions = top.inner("versions")
    return Bundle(
        problem=Problem(**decode_problem(top.document.get("problem"), "problem")),
        settings=_decode_settings(top.inner("settings")),
        solution=Solution(**decode_solution(top.document.get("solution"), "solution")),
        history=tuple({key: entry.number(key) for key in entry.document} for entry in history),
        versions={key: versions.text(key) for key in versions.document},
        start=_decode_start(top),
    )


def _decode_start(top: Fields) -> Start | None:
    """The point of a bundle; files of before there were warm starts have none."""
    if top.document.get("start") is None:
        return None
    point = top.inner("start")
    for key in point.document:
        if key not in _START:
            raise FieldError(point.name(key), f"is unknown; known fields are {', '.join(_START)}")
    return Start(*(point.numbers(name) for name in _START))


def versions() -> dict[str, str]:
    """What a replay depends on."""
    import numpy
    import scipy

    return {
        "orbsoc": __version__,
        "core": _core.__version__,
        "numpy": numpy.__version__,
        "scipy": scipy.__version__,
        "python": platform.python_version(),
        "platform": platform.platform(),
    }


def _encoded(values: Mapping[str, Any]) -> Document:
    return {key: encode_number(value) if type(value) is float else value for key, value in values.items()}


def _decode_settings(given: Fields) -> Settings:
    known = {field.name: field.type for field in fields(Settings)}
    values: dict[str, Any] = {}
    for key, value in given.document.items():
        if key not in known:
            raise FieldError(given.name(key), f"is unknown; known fields are {', '.join(known)}")
        values[key] = decode_number(given.name(key), value) if known[key] == "float" else value
    try:
        return Settings(**values)
    except (TypeError, ValueError) as error:
        raise FieldError("settings", f"do not hold: {error}") from error
