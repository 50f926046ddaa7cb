"""Output folders that are complete or absent: written beside their place, then moved there in one step."""

from __future__ import annotations

import json
import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

MANIFEST = "plan.json"
"""The file that marks a folder as an output of orbsoc: it names its schema and every file beside it; of a flight another."""
SCHEMA = "orbsoc.plan/1"
MANIFESTS = {MANIFEST: SCHEMA, "flight.json": "orbsoc.flight/1"}
"""Every such file, with its schema."""


class OutputFolderError(ValueError):
    """The output folder cannot be written, or holds files that orbsoc did not write."""


def check_replaceable(folder: Path) -> None:
    """Raise OutputFolderError unless `folder` is absent, empty, or an earlier output with nothing added to it."""
    if not folder.exists() and not folder.is_symlink():
        return
    if folder.is_symlink() or not folder.is_dir():
        raise OutputFolderError(f"--out = {folder}: exists and is not a folder; give another path")
    present = {entry.name for entry in folder.iterdir()}
    foreign = sorted(present - _files_of(folder))
    if foreign:
        raise OutputFolderError(
            f"--out = {folder}: holds {foreign[0]}, which orbsoc did not write; give a new or empty folder, or"
            " an earlier output folder"
        )


def check_writable(folder: Path) -> None:
    """Raise OutputFolderError where a folder could not be written; tried, and undone, before any work is done."""
    above = folder.absolute().parent
    missing = [each for each in (above, *above.parents) if not each.exists()]
    try:
        _sibling(folder.absolute()).rmdir()
    finally:
        for each in missing:
            if each.is_dir():
                each.rmdir()


def _sibling(folder: Path) -> Path:
    """A new hidden folder beside `folder`."""
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        return Path(tempfile.mkdtemp(prefix=f".{folder.name}.", suffix=".incomplete", dir=folder.parent))
    except OSError as error:
        raise OutputFolderError(f"--out = {folder}: cannot be written: {error.strerror}") from error


@contextmanager
def written_at_once(folder: Path) -> Iterator[Path]:
    """A temporary sibling of `folder` to write into; it takes the place of `folder` when the block ends well.

    On any exception, Ctrl-C included, the sibling is removed and `folder` is what it was. Raises
    OutputFolderError when the place cannot be written or holds foreign files.
    """
    folder = folder.absolute()
    check_replaceable(folder)
    temporary = _sibling(folder)
    try:
        try:
            yield temporary
        except OSError as error:  # a full disk, which names no file
            if error.filename is not None and not Path(error.filename).is_relative_to(temporary):
                raise
            raise OutputFolderError(f"--out = {folder}: cannot be written: {error.strerror}") from error
        temporary.chmod(0o777 & ~_umask())
        check_replaceable(folder)
        _move_into_place(temporary, folder)
    finally:
        shutil.rmtree(temporary, ignore_errors=True)


def write_manifest(folder: Path, document: dict[str, Any], name: str = MANIFEST) -> None:
    """Write `plan.json`, or another of `MANIFESTS`, with its schema and the list of all files of the folder. Call it last."""
    names = sorted({entry.name for entry in folder.iterdir()} | {name})
    text = json.dumps({"schema": MANIFESTS[name], "files": names, **document}, indent=2, allow_nan=False)
    (folder / name).write_text(text + "\n", encoding="utf-8")


def _files_of(folder: Path) -> set[str]:
    """File names an earlier output lists; empty when the folder is not one."""
    return next(filter(None, (_listed(folder / name, schema) for name, schema in MANIFESTS.items())), set())


def _listed(manifest: Path, schema: str) -> set[str]:
    try:
        document = json.loads(manifest.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return set()
    if not isinstance(document, dict) or document.get("schema") != schema:
        return set()
    files = document.get("files", [])
    return {name for name in files if isinstance(name, str)} if isinstance(files, list) else set()


def _move_into_place(temporary: Path, folder: Path) -> None:
    """Rename; an earlier output steps aside first, and comes back if the rename fails."""
    if not folder.exists():
        temporary.rename(folder)
        return
    aside = Path(tempfile.mkdtemp(prefix=f".{folder.name}.", suffix=".replaced", dir=folder.parent))
    aside.rmdir()
    folder.rename(aside)
    try:
        temporary.rename(folder)
    except BaseException:
        aside.rename(folder)
        raise
    shutil.rmtree(aside, ignore_errors=True)


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
