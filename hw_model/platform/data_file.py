"""Platform and partition files: the shipped ones by name, others by path."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any, TypeGuard

from hw_model.errors import HwModelError

Table = dict[str, Any]


def shipped(folder: str) -> list[str]:
    """Names of the files that ship in `folder` of this package."""
    return sorted(path.stem for path in (Path(__file__).parent / folder).glob("*.toml"))


def read(kind: str, folder: str, name_or_path: str | Path, error: type[HwModelError]) -> tuple[Table, str]:
    """The tables of a file and how messages call it. What ends in .toml is a path, all else a name."""
    path = Path(name_or_path)
    if path.suffix != ".toml":
        names = shipped(folder)
        if str(name_or_path) not in names:
            raise error(
                f"{kind} {str(name_or_path)!r} is not known; known: {', '.join(names)}, "
                "or the path of a .toml file"
            )
        path = Path(__file__).parent / folder / f"{name_or_path}.toml"
    where = f"{kind} {path.name}"
    return read_toml(path, where, error), where


def read_toml(path: Path, where: str, error: type[HwModelError]) -> Table:
    """The tables of a file; `where` is how messages call it."""
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as failure:
        raise error(f"{where}: cannot be read: {failure.strerror}") from failure
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as failure:
        raise error(f"{where}: not a TOML file: {failure}") from failure


def is_table(value: object) -> TypeGuard[Table]:
    """Whether a value read from TOML is a table (whose keys are always strings)."""
    return isinstance(value, dict)
