"""Shards on disk: hive-partitioned Parquet files, each moved into place in one step, and what they belong to."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from orbsoc.files.atomic_write import write_atomically

MANIFEST = "sweep.json"
SCHEMA = "orbsoc.sweep/1"
PART = "part.parquet"
JOURNAL = "journal"
"""Beside it, of a shard that is not finished: `journal.Journal`."""

Columns = Mapping[str, NDArray[Any]]


class StoreError(ValueError):
    """A results folder cannot be used; the message names it and says what to do."""


@dataclass(frozen=True, slots=True)
class Task:
    """A shard to make: which dataset and number, how many rows it has, and the plain values its work needs."""

    dataset: str
    number: int
    rows: int
    payload: dict[str, Any] = field(repr=False)

    @property
    def place(self) -> str:
        """Folder of the shard below the store."""
        return f"{self.dataset}/shard={self.number:04d}"


@dataclass(frozen=True, slots=True)
class ShardStore:
    """A results folder. `identity` is that of the requested sweep: a folder never holds two of them."""

    folder: Path
    identity: str

    @classmethod
    def open(cls, folder: Path, document: Mapping[str, Any], *, resume: bool) -> ShardStore:
        """Create the folder, or open it again with `resume`.

        Raises StoreError when it holds another sweep, the same one without `resume`, or files that are not ours.
        """
        identity = hashlib.sha256(json.dumps(document, sort_keys=True).encode()).hexdigest()
        store = cls(folder, identity)
        manifest = folder / MANIFEST
        try:
            if manifest.exists():
                store._check(_read(manifest), resume)
            elif folder.exists() and any(folder.iterdir()):
                raise StoreError(
                    f"--out = {folder}: holds files but no {MANIFEST}, so they are not a sweep's; give a new folder"
                )
            else:
                folder.mkdir(parents=True, exist_ok=True)
                content = {"schema": SCHEMA, "identity": identity, "scenario": dict(document)}
                write_atomically(manifest, json.dumps(content, indent=2) + "\n")
        except OSError as error:
            raise StoreError(f"--out = {folder}: cannot be written: {error.strerror}") from error
        return store

    @classmethod
    def load(cls, folder: Path) -> ShardStore:
        """An existing results folder, to read. Raises StoreError when it is none."""
        document = _read(folder / MANIFEST)
        return cls(folder, document["identity"])

    def document(self) -> dict[str, Any]:
        """The document of the requested sweep."""
        scenario: dict[str, Any] = _read(self.folder / MANIFEST)["scenario"]
        return scenario

    def is_finished(self, task: Task) -> bool:
        """Whether the shard is there."""
        return (self.folder / task.place / PART).is_file()

    def write(self, task: Task, columns: Columns) -> None:
        """Put a shard in its place, whole or not at all. Raises OSError."""
        import pyarrow as pa
        import pyarrow.parquet as parquet

        stream = pa.BufferOutputStream()
        parquet.write_table(_table(columns), stream)
        place = self.folder / task.place
        place.mkdir(parents=True, exist_ok=True)
        write_atomically(place / PART, stream.getvalue().to_pybytes(), durable=True)
        (place / JOURNAL).unlink(missing_ok=True)

    def read(self, dataset: str) -> dict[str, NDArray[Any]]:
        """All finished shards of a dataset in order of their numbers, as columns. Raises StoreError without any."""
        import pyarrow as pa
        import pyarrow.parquet as parquet

        parts = sorted((self.folder / dataset).glob(f"shard=*/{PART}"))
        if not parts:
            raise StoreError(f"{self.folder}: has no shard of `{dataset}` yet; run the sweep, or resume it")
        table = pa.concat_tables([parquet.read_table(part, partitioning=None) for part in parts])
        return {name: _column(table.column(name)) for name in table.column_names}

    def _check(self, found: dict[str, Any], resume: bool) -> None:
        name = found.get("scenario", {}).get("name", "?")
        if found["identity"] != self.identity:
            raise StoreError(
                f"--out = {self.folder}: holds the results of another scenario ({name}, or other values of it);"
                " nothing was overwritten; give another folder"
            )
        if not resume:
            raise StoreError(
                f"--out = {self.folder}: holds results of this scenario; add --resume to continue or read them, or"
                " give another folder"
            )


def _read(path: Path) -> dict[str, Any]:
    try:
        document = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError as error:
        raise StoreError(f"{path.parent}: is not a results folder, it has no {MANIFEST}") from error
    except ValueError as error:
        raise StoreError(f"{path}: is not JSON: {error}") from error
    if not isinstance(document, dict) or document.get("schema") != SCHEMA:
        raise StoreError(f"{path}: is not the manifest of a sweep")
    return document


def _table(columns: Columns) -> Any:
    import pyarrow as pa

    def array(values: NDArray[Any]) -> Any:
        if values.dtype == object and any(not isinstance(value, str) for value in values):
            return pa.array(list(values), type=pa.list_(pa.float64()))
        return pa.array(values)

    return pa.table({name: array(values) for name, values in columns.items()})


def _column(column: Any) -> NDArray[Any]:
    """A column as NumPy: numbers, words, or an object array of vectors and None."""
    import pyarrow as pa

    if pa.types.is_list(column.type):
        values: Sequence[Any] = column.to_pylist()
        out = np.full(len(values), None, dtype=object)
        for k, value in enumerate(values):
            out[k] = None if value is None else np.asarray(value, dtype=np.float64)
        return out
    return np.asarray(column.to_numpy())
